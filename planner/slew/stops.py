"""Can an axis in a given state still keep its hard stops and its rate limit?"""

import math

from planner.platforms import AxisLimits
from planner.slew.problem import AxisState


def stop_margin_rad(state: AxisState, limits: AxisLimits) -> float:
    """Angle left to the stop when the axis brakes as hard as it can; negative: it must hit.

    Braking is jerk_max until -acceleration_max, held until the axis rests for an instant.
    No other motion within the limits reaches less far.
    """
    above = limits.angle_max_rad - state.angle_rad - _overshoot_rad(state, limits)
    mirrored = AxisState(
        angle_rad=-state.angle_rad,
        rate_rad_s=-state.rate_rad_s,
        acceleration_rad_s2=-state.acceleration_rad_s2,
    )
    below = state.angle_rad - limits.angle_min_rad - _overshoot_rad(mirrored, limits)
    return min(above, below)


def rate_margin_rad_s(state: AxisState, limits: AxisLimits) -> float:
    """Rate left to the limit when the acceleration is taken back as fast as jerk allows."""
    signed = math.copysign(state.acceleration_rad_s2**2, state.acceleration_rad_s2)
    signed /= 2.0 * limits.jerk_max_rad_s3
    worst = max(abs(state.rate_rad_s), abs(state.rate_rad_s + signed))
    return limits.rate_max_rad_s - worst


def _overshoot_rad(state: AxisState, limits: AxisLimits) -> float:
    """How far the axis still moves upwards when it brakes as hard as it can."""
    v, a = state.rate_rad_s, state.acceleration_rad_s2
    jerk, brake = limits.jerk_max_rad_s3, limits.acceleration_max_rad_s2
    if v <= 0.0 and a <= 0.0:
        return 0.0
    discriminant = a * a + 2.0 * jerk * v
    if discriminant < 0.0:
        return 0.0  # the axis moves down throughout
    t_rest = (a + math.sqrt(discriminant)) / jerk
    t_full = (a + brake) / jerk
    t = min(t_rest, t_full)
    travelled = t * (v + t * (a / 2.0 - t * jerk / 6.0))
    if t_rest > t_full:
        v_left = v + t_full * (a - jerk * t_full / 2.0)
        travelled += v_left * v_left / (2.0 * brake)
    return max(travelled, 0.0)
