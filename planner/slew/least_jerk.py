"""What is the smoothest motion between two states when no limit is in the way?"""

import numpy as np

from planner.slew.problem import AxisState
from planner.slew.solution import AxisProfile


def least_jerk_profile(start: AxisState, end: AxisState, duration_s: float) -> AxisProfile:
    """The quintic through both states: exactly the least integral of squared jerk.

    Where it keeps the limits it solves the constrained problem too.
    Source: Euler-Lagrange equation of that integral, sixth derivative zero.
    """
    T = duration_s
    c0, c1, c2 = start.angle_rad, start.rate_rad_s, start.acceleration_rad_s2 / 2.0
    d_angle = end.angle_rad - c0 - T * (c1 + T * c2)
    d_rate = (end.rate_rad_s - c1 - 2.0 * T * c2) * T
    d_acceleration = (end.acceleration_rad_s2 - 2.0 * c2) * T**2
    c3 = (10.0 * d_angle - 4.0 * d_rate + d_acceleration / 2.0) / T**3
    c4 = (-15.0 * d_angle + 7.0 * d_rate - d_acceleration) / T**4
    c5 = (6.0 * d_angle - 3.0 * d_rate + d_acceleration / 2.0) / T**5
    return AxisProfile(
        breakpoints_s=np.array([0.0, T]), coefficients=np.array([[c0, c1, c2, c3, c4, c5]])
    )
