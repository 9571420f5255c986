"""The search for windows, by kind of platform."""
