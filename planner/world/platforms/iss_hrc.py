"""The axes and limits of the camera platform on the ISS.

Source: Sumarokov 2016, p. 86 and eq. 11-12.
"""

import math

from planner.world.platforms.definition import AxisDefinition, PlatformDefinition

_TILT_RAD = math.radians(5.0)  # eq. 11: alpha leans 5 deg out of -Y


def _hrc_axis(name: str, axis_platform: tuple[float, float, float]) -> AxisDefinition:
    return AxisDefinition(
        name=name,
        axis_platform=axis_platform,
        angle_min_deg=-175.0,
        angle_max_deg=175.0,
        rate_max_deg_s=3.0,
        acceleration_max_deg_s2=1.0,
        jerk_max_deg_s3=1.0,  # our default: the paper bounds jerk only by filtering
        rate_min_deg_s=1.0 / 60.0,
    )


ISS_HRC = PlatformDefinition(
    name="iss-hrc",
    outer=_hrc_axis("alpha", (0.0, -math.cos(_TILT_RAD), math.sin(_TILT_RAD))),
    inner=_hrc_axis("beta", (1.0, 0.0, 0.0)),
    # in torque equilibrium, forward: telemetry of 2018-10-12 (docs/sources.md) has -4.0/-2.2/0.8
    usual_yaw_pitch_roll_deg=(-4.0, -2.0, 1.0),
    park_positions_deg={"zero": {"alpha": 0.0, "beta": 0.0}},  # the index marks; none is published
).platform()
