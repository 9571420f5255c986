"""The parts of a plan's view that belong to one kind of platform."""
