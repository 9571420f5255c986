"""The judge of two axes on a carrier that somebody else steers."""
