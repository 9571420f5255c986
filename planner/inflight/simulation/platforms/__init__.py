"""The flight of each kind of platform, as flights ask for it."""
