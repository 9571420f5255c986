"""A body turned by control moment gyros, flown closed loop with its sensors and its structure."""
