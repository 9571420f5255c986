"""A command table flown closed loop, and how still it holds the camera."""
