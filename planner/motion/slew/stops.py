"""The unavoidable approach of an axis in a given state to its hard stops and its rate limit."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.motion.slew.closed_forms import JerkPhase, profile_from_jerk
from planner.motion.slew.problem import AxisSlew, AxisState
from planner.motion.slew.solution import AxisProfile, chain_profiles
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


# Braking that an axis must do first, and last, before it passes its rate limit or a stop.
#
# An acceleration towards the rate limit leaves an axis that is near it no choice: the jerk must
# take the acceleration back; nor does a rate towards a stop, which must be braked.  Doing so in
# whole rows of the command table leaves a slew between two ordinary states, and all three parts
# can be flown from rows exactly.

NEAR_STOP_S = 5.0  # at the rate limit: with more way in hand the axis is free
NEAR_SHARE = 0.1  # of the rate limit: with more in hand the axis is free
ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True)
class BrakedEnds:
    """first, last: motions in `rows` rows together at either end, None where the axis is free.

    free: the slew that is left between them.
    """

    first: AxisProfile | None
    free: AxisSlew
    last: AxisProfile | None
    rows: int

    def around(self, free: AxisProfile) -> AxisProfile:
        """The whole motion, free between the ends."""
        return chain_profiles([part for part in (self.first, free, self.last) if part is not None])


def braked_ends(slew: AxisSlew) -> BrakedEnds | None:
    """How both ends are braked, or None where neither end needs to be."""
    first = brake(slew.start, slew.limits)
    last = brake(slew.end.backwards(), slew.limits)
    parts = [part for part in (first, last) if part is not None]
    if not parts:
        return None
    rows = round(sum(part.duration_s for part in parts) / COMMAND_STEP_S)
    free = replace(
        slew,
        start=_end_state(first) if first else slew.start,
        end=_end_state(last).backwards() if last else slew.end,
        duration_s=slew.duration_s - rows * COMMAND_STEP_S,
    )
    return BrakedEnds(first=first, free=free, last=_in_reverse(last) if last else None, rows=rows)


def brake(state: AxisState, limits: AxisLimits) -> AxisProfile | None:
    """What an axis in this state must do at once, in whole rows; None where it is free.

    With the gentlest jerk that keeps the rate and ends, acceleration spent, on a row.
    """
    acceleration = abs(state.acceleration_rad_s2)
    sign = math.copysign(1.0, state.acceleration_rad_s2)
    room = limits.rate_max_rad_s - sign * state.rate_rad_s
    jerk_max = limits.jerk_max_rad_s3
    spare = room - acceleration**2 / (2.0 * jerk_max)
    if acceleration == 0.0 or spare > NEAR_SHARE * limits.rate_max_rad_s:
        return _brake_before_stop(state, limits)
    rows = math.floor(2.0 * room / acceleration / COMMAND_STEP_S + ROUNDING)
    jerk = acceleration / (rows * COMMAND_STEP_S) if rows else math.inf
    if jerk > jerk_max * (1.0 + ROUNDING):
        jerk = min(acceleration**2 / (2.0 * room), jerk_max) if room > 0.0 else jerk_max
        rows = math.ceil(acceleration / (jerk * COMMAND_STEP_S) - ROUNDING)
    return profile_from_jerk(state, [JerkPhase(rows * COMMAND_STEP_S, -sign * jerk)])


def _brake_before_stop(state: AxisState, limits: AxisLimits) -> AxisProfile | None:
    """Brake as hard as it can, until the axis no longer moves towards the stop; None: it is far."""
    near_rad = NEAR_SHARE * NEAR_STOP_S * limits.rate_max_rad_s
    if stop_margin_rad(state, limits) > near_rad:
        return None
    sign = math.copysign(1.0, state.rate_rad_s)
    towards = state if sign > 0.0 else state.mirror_image()
    jerks = [sign * jerk for _, jerk in hardest_jerks(towards, limits)]
    return profile_from_jerk(state, [JerkPhase(COMMAND_STEP_S, jerk) for jerk in jerks])


def _end_state(profile: AxisProfile) -> AxisState:
    angle, rate, acceleration, _ = profile.end_values[1].tolist()
    return AxisState(angle_rad=angle, rate_rad_s=rate, acceleration_rad_s2=acceleration)


def _in_reverse(profile: AxisProfile) -> AxisProfile | None:
    """Pieces of constant jerk with time running backwards."""
    jerks = profile.coefficients[::-1, 3] * -6.0
    widths = np.diff(profile.breakpoints_s)[::-1]
    phases = map(JerkPhase, widths.tolist(), jerks.tolist())
    return profile_from_jerk(_end_state(profile).backwards(), list(phases))
