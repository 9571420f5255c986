"""The judges of tables by the kind of platform."""
