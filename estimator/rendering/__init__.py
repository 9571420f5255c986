"""Rendered pictures of the horizon with their truth, which share nothing with the estimate."""
