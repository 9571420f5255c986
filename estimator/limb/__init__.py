"""The Earth's limb: its geometry, its daylight, and where a frame shows it."""
