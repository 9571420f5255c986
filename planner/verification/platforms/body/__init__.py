"""The judge of a spacecraft that turns as a whole."""
