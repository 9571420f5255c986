"""The part of a slew in which it is free to leave its way, when its ends must brake first.

No hull of a spline holds a rate whose peak all but touches its limit, so a detour keeps the
straight slew's own motion there: it begins, and ends, where both axes are free.
"""

import math
from dataclasses import replace

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.motion.pointing.keep_out import KeepOutView
from planner.motion.slew.problem import AxisState, axis_states
from planner.motion.slew.solution import AxisProfile, SlewSolution, chain_profiles
from planner.motion.slew.stops import brake

STEP_ROWS = 2
ROUNDING_S = 1e-9
SHARE_MAX = 0.25  # of the slew, at either end


def free_part(
    straight: SlewSolution, view: KeepOutView
) -> tuple[SlewSolution, KeepOutView, float] | None:
    """The part of a straight slew between its braked ends, the cones then, and when it begins.

    None where no end brakes, or the straight slew doesn't get free in a quarter of its time.
    """
    first_s, last_s = _braked_s(straight, at_end=False), _braked_s(straight, at_end=True)
    if first_s is None or last_s is None or first_s + last_s == 0.0:
        return None
    stop_s = straight.duration_s - last_s
    shifted = view.from_time(first_s)
    problem = replace(
        straight.problem,
        start=_states_at(straight, first_s),
        end=_states_at(straight, stop_s),
        duration_s=stop_s - first_s,
        keep_out=shifted,
    )
    profiles = tuple(_cut_profile(profile, first_s, stop_s) for profile in straight.profiles)
    return replace(straight, problem=problem, profiles=profiles), shifted, first_s


def with_part_replaced(
    straight: SlewSolution, begins_s: float, between: tuple[AxisProfile, AxisProfile]
) -> tuple[AxisProfile, AxisProfile]:
    """Another motion in place of the straight slew's free part."""
    stop_s = begins_s + between[0].duration_s
    first, second = (
        chain_profiles(
            [
                *([_cut_profile(old, 0.0, begins_s)] if begins_s > 0.0 else []),
                new,
                *([_cut_profile(old, stop_s, old.duration_s)] if stop_s < old.duration_s else []),
            ]
        )
        for old, new in zip(straight.profiles, between, strict=True)
    )
    return first, second


def _braked_s(straight: SlewSolution, *, at_end: bool) -> float | None:
    """Whole rows after which, seen from that end, no axis must brake; None: too many."""
    rows = 0
    while rows * COMMAND_STEP_S <= SHARE_MAX * straight.duration_s:
        since_s = rows * COMMAND_STEP_S
        states = _states_at(straight, straight.duration_s - since_s if at_end else since_s)
        if all(
            brake(state.backwards() if at_end else state, limits) is None
            for state, limits in zip(states, straight.problem.limits, strict=True)
        ):
            return since_s
        rows += STEP_ROWS
    return None


def _states_at(straight: SlewSolution, at_s: float) -> tuple[AxisState, ...]:
    if at_s == 0.0:
        return straight.problem.start
    if at_s == straight.duration_s:
        return straight.problem.end
    angle, rate, acceleration, _ = straight.motion(np.array([at_s]))
    return axis_states(angle[0], rate[0], acceleration[0])


def _cut_profile(profile: AxisProfile, begin_s: float, stop_s: float) -> AxisProfile:
    """The motion from begin_s to stop_s, its time counted from begin_s."""
    breaks = profile.breakpoints_s
    inner = breaks[(breaks > begin_s + ROUNDING_S) & (breaks < stop_s - ROUNDING_S)]
    at_s = np.concatenate([[begin_s], inner, [stop_s]])
    piece = np.searchsorted(breaks, at_s[:-1] + ROUNDING_S, side="right") - 1
    old, since_s = profile.coefficients[piece], at_s[:-1] - breaks[piece]
    count = old.shape[1]
    new = np.zeros_like(old)
    for power in range(count):
        for other in range(power, count):
            new[:, power] += math.comb(other, power) * old[:, other] * since_s ** (other - power)
    return AxisProfile(breakpoints_s=at_s - begin_s, coefficients=new)
