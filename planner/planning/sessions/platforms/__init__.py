"""The motion of each kind of platform, as sessions ask for it."""
