"""Flights of a plan's table and their images, once as planned and many times disturbed."""
