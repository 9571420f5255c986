"""The spacecraft itself: its definition, gyros, dynamics and on-board computer."""
