"""The ways and slews of each kind of platform, as campaigns ask for them."""
