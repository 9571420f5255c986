"""The rules of each kind of platform for what a request may ask of it."""
