"""Sensors of each kind of platform, as a comparison of telemetry asks them."""
