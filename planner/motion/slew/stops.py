"""The unavoidable approach of an axis in a given state to its hard stops and its rate limit."""

import math
from collections.abc import Iterator

from planner.base.commands import COMMAND_STEP_S
from planner.motion.slew.problem import AxisState
from planner.world.platforms import AxisLimits


def stop_margin_rad(state: AxisState, limits: AxisLimits) -> float:
    """Angle left to the stop when the axis brakes as hard as it can; negative: it must hit.

    Braking is jerk_max until -acceleration_max, held until the axis rests for an instant.
    No other motion within the limits reaches less far.
    """
    above = limits.angle_max_rad - state.angle_rad - _overshoot_rad(state, limits)
    below = state.angle_rad - limits.angle_min_rad - _overshoot_rad(state.mirror_image(), limits)
    return min(above, below)


def rate_margin_rad_s(state: AxisState, limits: AxisLimits) -> float:
    """Rate left to the limit when the acceleration is taken back as fast as jerk allows."""
    signed = math.copysign(state.acceleration_rad_s2**2, state.acceleration_rad_s2)
    signed /= 2.0 * limits.jerk_max_rad_s3
    worst = max(abs(state.rate_rad_s), abs(state.rate_rad_s + signed))
    return limits.rate_max_rad_s - worst


def margins_on_rows(state: AxisState, limits: AxisLimits) -> tuple[float, float]:
    """Angle left to the stop and rate left to its limit when the jerk changes on rows only.

    The hardest braking takes from each row to the next as much acceleration as its jerk and its
    limit allow: no other motion on rows is slower, or less far, at any instant.
    """
    up = _hardest_on_rows(state, limits)
    down = _hardest_on_rows(state.mirror_image(), limits)
    return (
        min(limits.angle_max_rad - up[0], -down[0] - limits.angle_min_rad),
        limits.rate_max_rad_s - max(up[1], down[1]),
    )


def hardest_jerks(state: AxisState, limits: AxisLimits) -> Iterator[tuple[AxisState, float]]:
    """Row by row, the state and the jerk that brakes a way upwards hardest, until it is over."""
    h = COMMAND_STEP_S
    q, v, a = state.angle_rad, state.rate_rad_s, state.acceleration_rad_s2
    while v > 0.0 or a > 0.0:
        jerk = max(-limits.jerk_max_rad_s3, (-limits.acceleration_max_rad_s2 - a) / h)
        yield AxisState(angle_rad=q, rate_rad_s=v, acceleration_rad_s2=a), jerk
        q += h * (v + h * (a / 2.0 + h * jerk / 6.0))
        v += h * (a + h * jerk / 2.0)
        a += h * jerk


def _hardest_on_rows(state: AxisState, limits: AxisLimits) -> tuple[float, float]:
    """The greatest angle and rate of an axis that brakes its way upwards in whole rows."""
    h = COMMAND_STEP_S
    farthest, fastest = state.angle_rad, state.rate_rad_s
    for row, jerk in hardest_jerks(state, limits):
        q, v, a = row.angle_rad, row.rate_rad_s, row.acceleration_rad_s2
        if a > 0.0:
            peak = min(h, -a / jerk)
            fastest = max(fastest, v + peak * (a + peak * jerk / 2.0))
        stop = h
        if v + h * (a + h * jerk / 2.0) <= 0.0 < fastest:
            # The rate is concave: after its peak it has one root, here without cancellation.
            root = math.sqrt(max(a * a - 2.0 * jerk * v, 0.0))
            stop = (a + root) / -jerk if a > 0.0 else 2.0 * v / (root - a)
        farthest = max(farthest, q + stop * (v + stop * (a / 2.0 + stop * jerk / 6.0)))
    return farthest, fastest


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
