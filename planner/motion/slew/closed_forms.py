"""Motions of one axis that need no solver: the quickest, one of a given duration, the smoothest.

The quickest keep the limits of rate, acceleration and jerk exactly and leave hard stops to
`planner.motion.slew.stops`; the smoothest knows no limit.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np
import ruckig

from planner.base import effort
from planner.base.arrays import Array
from planner.motion.slew.problem import AxisState
from planner.motion.slew.solution import AxisProfile, chain_profiles
from planner.world.platforms import AxisLimits

LONGEST_S = 3600.0  # Ruckig gives up at 7600 s; most slews of an hour can rest on their way
SLOW_UNIT_S = 100.0  # for axes that need longer than Ruckig can count in seconds
LOOK_UP = 16  # of `effort`: with what else is looked at beside it
DURATION_TOLERANCE = 1e-9  # relative: rounding of a sum of phases
_SUCCESS = (ruckig.Result.Working, ruckig.Result.Finished)
Quantity = TypeVar("Quantity", float, Array)


class JerkPhase(NamedTuple):
    """A stretch of constant jerk."""

    duration_s: float
    jerk_rad_s3: float


def quickest_profile(
    start: AxisState, end: AxisState, limits: AxisLimits, at_least_s: float = 0.0
) -> AxisProfile | None:
    """The least-time profile that lasts at_least_s, in pieces of constant jerk.

    None when Ruckig knows none.  It may pass a hard stop, and the rate limit when the
    start's acceleration can't be taken back in time.
    Source: Berscheid, Kroeger 2021, "Jerk-limited real-time trajectory generation with
    arbitrary target states".
    """
    if at_least_s > LONGEST_S:
        resting = _resting_profile(start, end, limits, at_least_s)
        if resting is not None:
            return resting
    try:
        return _by_ruckig(start, end, limits, at_least_s, 1.0)
    except ValueError:  # how its binding says "over 7600 s", a result that it has no name for
        return _by_ruckig(start, end, limits, at_least_s, SLOW_UNIT_S)


def _by_ruckig(
    start: AxisState, end: AxisState, limits: AxisLimits, at_least_s: float, unit_s: float
) -> AxisProfile | None:
    """unit_s: what Ruckig takes for a second."""
    effort.charge(LOOK_UP)
    request = ruckig.InputParameter(1)
    rate_max, acceleration_max = limits.rate_max_rad_s, limits.acceleration_max_rad_s2
    # Scaled so that Ruckig's absolute tolerances (1e-8) mean the same for every platform.
    angle = 1.0 / (acceleration_max * unit_s**2)
    rate, acceleration, jerk = angle * unit_s, 1.0 / acceleration_max, angle * unit_s**3
    request.current_position = [0.0]
    request.current_velocity = [_clip(start.rate_rad_s, rate_max) * rate]
    request.current_acceleration = [
        _clip(start.acceleration_rad_s2, acceleration_max) * acceleration
    ]
    request.target_position = [(end.angle_rad - start.angle_rad) * angle]
    request.target_velocity = [_clip(end.rate_rad_s, rate_max) * rate]
    request.target_acceleration = [_clip(end.acceleration_rad_s2, acceleration_max) * acceleration]
    request.max_velocity = [rate_max * rate]
    request.max_acceleration = [1.0]
    request.max_jerk = [limits.jerk_max_rad_s3 * jerk]
    request.minimum_duration = at_least_s / unit_s
    trajectory = ruckig.Trajectory(1)
    try:
        if ruckig.Ruckig(1).calculate(request, trajectory) not in _SUCCESS:
            return None
    except ruckig.RuckigError:  # a target state that no motion within the limits arrives in
        return None
    found = trajectory.profiles[0][0]
    phases = [
        *zip(found.brake.t, found.brake.j, strict=True),
        *zip(found.t, found.j, strict=True),
        *zip(found.accel.t, found.accel.j, strict=True),
    ]
    return profile_from_jerk(start, [JerkPhase(t * unit_s, j / jerk) for t, j in phases if t > 0.0])


def _resting_profile(
    start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float
) -> AxisProfile | None:
    """Back to rest at the start's angle, a wait there, and on to the end; None: no time for it."""
    rest = start.at_rest()
    to_rest = None if start == rest else quickest_profile(start, rest, limits)
    on = None if end == rest else quickest_profile(rest, end, limits)
    if (to_rest is None and start != rest) or (on is None and end != rest):
        return None
    return with_wait(rest, to_rest, on, duration_s)


def with_wait(
    rest: AxisState, to_rest: AxisProfile | None, on: AxisProfile | None, duration_s: float
) -> AxisProfile | None:
    """A motion to rest, a wait, and a motion on; a missing one is already where it leads.

    None where that takes longer.
    """
    moving_s = sum(part.duration_s for part in (to_rest, on) if part is not None)
    if moving_s > duration_s:
        return None
    wait = AxisProfile(
        breakpoints_s=np.array([0.0, duration_s - moving_s]),
        coefficients=np.array([[rest.angle_rad, 0.0, 0.0, 0.0]]),
    )
    return chain_profiles([part for part in (to_rest, wait, on) if part is not None])


def profile_lasting(
    start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float
) -> AxisProfile | None:
    """A profile of exactly duration_s within rate, acceleration and jerk limits, or None.

    The durations an axis can take are not always all those above the least one: there are
    gaps, and None is the answer inside a gap as well as below the least duration.
    """
    profile = quickest_profile(start, end, limits, duration_s)
    if profile is None or profile.duration_s > duration_s * (1.0 + DURATION_TOLERANCE):
        return None
    return profile


def profile_from_jerk(start: AxisState, phases: Sequence[JerkPhase]) -> AxisProfile | None:
    """Piecewise cubic from the start through the phases; None if there are none."""
    if not phases:
        return None
    angle, rate, acceleration = start.angle_rad, start.rate_rad_s, start.acceleration_rad_s2
    breakpoints, coefficients = [0.0], []
    for t, jerk in phases:
        coefficients.append((angle, rate, acceleration / 2.0, jerk / 6.0))
        angle += t * (rate + t * (acceleration / 2.0 + t * jerk / 6.0))
        rate += t * (acceleration + t * jerk / 2.0)
        acceleration += t * jerk
        breakpoints.append(breakpoints[-1] + t)
    return AxisProfile(breakpoints_s=np.array(breakpoints), coefficients=np.array(coefficients))


def least_jerk_profile(start: AxisState, end: AxisState, duration_s: float) -> AxisProfile:
    """The quintic through both states: exactly the least integral of squared jerk.

    Where it keeps the limits it solves the constrained problem too.
    Source: Euler-Lagrange equation of that integral, sixth derivative zero.
    """
    motion = [(one.angle_rad, one.rate_rad_s, one.acceleration_rad_s2) for one in (start, end)]
    return AxisProfile(
        breakpoints_s=np.array([0.0, duration_s]),
        coefficients=np.array([quintic_coefficients(duration_s, *motion)]),
    )


def quintic_coefficients(
    duration_s: Quantity, start: Sequence[Quantity], end: Sequence[Quantity]
) -> list[Quantity]:
    """Power coefficients, rad/s^j for j up to 5, of the quintic from start to end.

    start, end: angle, rate and acceleration; all of them numbers, or arrays of one shape.
    """
    T = duration_s
    c0, c1, c2 = start[0], start[1], start[2] / 2.0
    d_angle = end[0] - c0 - T * (c1 + T * c2)
    d_rate = (end[1] - c1 - 2.0 * T * c2) * T
    d_acceleration = (end[2] - 2.0 * c2) * T**2
    c3 = (10.0 * d_angle - 4.0 * d_rate + d_acceleration / 2.0) / T**3
    c4 = (-15.0 * d_angle + 7.0 * d_rate - d_acceleration) / T**4
    c5 = (6.0 * d_angle - 3.0 * d_rate + d_acceleration / 2.0) / T**5
    return [c0, c1, c2, c3, c4, c5]


def _clip(value: float, bound: float) -> float:
    """The value without the rounding by which a valid state may pass its limit."""
    return min(max(value, -bound), bound)
