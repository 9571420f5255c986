"""What are the axes and limits of the camera platform on the ISS?  (Sumarokov 2016, p. 86 and eq. 11-12)"""

import math

from planner.platforms.two_axis import AxisLimits, TwoAxisPlatform

AXIS_TILT_RAD = math.radians(5.0)  # eq. 11: alpha leans 5 deg out of -Y

_LIMITS = AxisLimits(
    angle_min_rad=math.radians(-175.0),
    angle_max_rad=math.radians(175.0),
    rate_max_rad_s=math.radians(3.0),
    acceleration_max_rad_s2=math.radians(1.0),
    jerk_max_rad_s3=math.radians(1.0),  # our default: the paper bounds jerk only by filtering
    rate_min_rad_s=math.radians(1.0 / 60.0),
)

ISS_HRC = TwoAxisPlatform(
    name="iss-hrc",
    outer_name="alpha",
    outer_axis_platform=(0.0, -math.cos(AXIS_TILT_RAD), math.sin(AXIS_TILT_RAD)),
    outer_limits=_LIMITS,
    inner_name="beta",
    inner_axis_platform=(1.0, 0.0, 0.0),
    inner_limits=_LIMITS,
    zero_direction_platform=(0.0, 0.0, 1.0),
)
