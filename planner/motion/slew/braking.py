"""Braking that an axis must do first, and last, before it passes its rate limit or a stop.

An acceleration towards the rate limit leaves an axis that is near it no choice: the jerk must
take the acceleration back; nor does a rate towards a stop, which must be braked.  Doing so in
whole rows of the command table leaves a slew between two ordinary states, and all three parts
can be flown from rows exactly.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.motion.slew.closed_forms import JerkPhase, profile_from_jerk
from planner.motion.slew.problem import AxisSlew, AxisState
from planner.motion.slew.solution import AxisProfile, chain_profiles
from planner.motion.slew.stops import hardest_jerks, stop_margin_rad
from planner.world.platforms import AxisLimits

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
    return BrakedEnds(first=first, free=free, last=_backwards(last) if last else None, rows=rows)


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
    """As hard as it can, until the axis no longer moves towards the stop; None: it is far."""
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


def _backwards(profile: AxisProfile) -> AxisProfile | None:
    """Pieces of constant jerk with time running backwards."""
    jerks = profile.coefficients[::-1, 3] * -6.0
    widths = np.diff(profile.breakpoints_s)[::-1]
    phases = map(JerkPhase, widths.tolist(), jerks.tolist())
    return profile_from_jerk(_end_state(profile).backwards(), list(phases))
