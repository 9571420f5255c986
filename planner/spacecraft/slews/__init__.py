"""Slews from one moving attitude to another within the spacecraft's limits."""
