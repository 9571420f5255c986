"""The slew of least squared jerk within all limits, solved axis by axis."""

import time
from dataclasses import replace
from typing import NamedTuple

from planner.slew.braking import braked_ends
from planner.slew.closed_forms import LONGEST_S, least_jerk_profile, with_wait
from planner.slew.feasibility import axis_refusal, verdict
from planner.slew.problem import AxisSlew, SlewProblem, within
from planner.slew.smoothest import Smoothest, bound_without_contacts, smoothest
from planner.slew.solution import AxisProfile, SlewSolution, obeys

OPTIMAL_GAP = 1e-3  # of the cost: what is called optimal is no further from the bound


class AxisSolution(NamedTuple):
    """status says by which method the profile was found; no motion costs less than the bound."""

    profile: AxisProfile
    status: str
    lower_bound_rad2_s5: float
    iterations: int


def optimal_slew(problem: SlewProblem) -> SlewSolution:
    """The slew with the least integral of squared jerk, every limit kept at every instant.

    Each axis comes with a lower bound for every motion between its states within its limits; it
    is called optimal where it costs at most 0.1 % more.  Every profile is accepted on its own
    exact extremes, whatever the solver says.  Structural modes to spare cost extra.
    Raises InfeasibleSlew.
    Neglects coupling between the axes, which share nothing but the duration: cones to keep
    out of are left to `planner.detour.detour`.
    """
    began_s = time.perf_counter()
    axes = [
        _solve_axis(name, slew) for name, slew in zip(problem.axis_names, problem.axes, strict=True)
    ]
    return SlewSolution(
        problem=problem,
        profiles=tuple(axis.profile for axis in axes),
        status=tuple(axis.status for axis in axes),
        lower_bounds_rad2_s5=tuple(axis.lower_bound_rad2_s5 for axis in axes),
        iterations=sum(axis.iterations for axis in axes),
        wall_s=time.perf_counter() - began_s,
        violations=(),
        end_error_rad=(0.0,) * len(axes),
    )


def _solve_axis(name: str, slew: AxisSlew) -> AxisSolution:
    """Raises InfeasibleSlew."""
    found = _smoothest(slew)
    if isinstance(found, str):
        raise axis_refusal(name, slew, found)
    return found


def _with_wait(slew: AxisSlew) -> AxisSolution | None:
    """Smoothly to rest, a wait, and smoothly on, where stops leave no choice at the ends."""
    rest, part_s = slew.start.at_rest(), LONGEST_S / 2.0
    to_rest = on = None
    if slew.start != rest:
        to_rest = smoothest_motion(replace(slew, end=rest, duration_s=part_s))
    if slew.end != rest:
        on = smoothest_motion(replace(slew, start=rest, duration_s=part_s))
    if (to_rest is None and slew.start != rest) or (on is None and slew.end != rest):
        return None
    parts = [part for part in (to_rest, on) if part is not None]
    profile = with_wait(
        rest, to_rest.profile if to_rest else None, on.profile if on else None, slew.duration_s
    )
    if profile is None:
        return None
    return AxisSolution(
        profile,
        ", a wait, ".join(part.status for part in parts),
        bound_without_contacts(slew),
        sum(part.iterations for part in parts),
    )


def smoothest_motion(slew: AxisSlew) -> AxisSolution | None:
    """None where there is none: the same without a reason."""
    if slew.duration_s <= 0.0:
        return None
    if not (within(slew.start, slew.limits) and within(slew.end, slew.limits)):
        return None
    found = _smoothest(slew)
    return None if isinstance(found, str) else found


def _smoothest(slew: AxisSlew) -> AxisSolution | str:
    """The smoothest motion, or the limit that forbids any."""
    start, end, limits = slew.start, slew.end, slew.limits
    free = least_jerk_profile(start, end, slew.duration_s)
    if not slew.avoid_modes and obeys(free, start, end, limits):
        return AxisSolution(free, "closed form", free.jerk_squared_integral, 0)
    possible = verdict(start, end, limits, slew.duration_s)
    if possible.limit is not None:
        return possible.limit
    found = smoothest(slew, possible.profile, None)
    if found is not None:
        return AxisSolution(found.profile, how_good(found, found.lower_bound_rad2_s5), *found[1:3])
    waiting = _with_wait(slew) if slew.duration_s > LONGEST_S else None
    if waiting is not None:
        return waiting
    braked = _with_braked_ends(slew)
    if braked is not None:
        return braked
    if possible.profile is None:
        return "angle"
    bound = bound_without_contacts(slew)
    return AxisSolution(possible.profile, "feasible, not the smoothest", bound, 0)


def how_good(found: Smoothest, lower_bound_rad2_s5: float) -> str:
    """What a motion that was sought as the smoothest may be called."""
    if found.spares_modes:
        return "modes spared"
    gap = 1.0 - lower_bound_rad2_s5 / found.profile.jerk_squared_integral
    return "optimal" if gap <= OPTIMAL_GAP else f"smooth, gap {gap:.1%}"


def _with_braked_ends(slew: AxisSlew) -> AxisSolution | None:
    """Braked at the ends where the rate comes near its limit, and the smoothest between.

    Where an end all but determines how the axis leaves or reaches it, no motion is left to
    search among.
    """
    ends = braked_ends(slew)
    free = None if ends is None else smoothest_motion(ends.free)
    if ends is None or free is None:
        return None
    profile = ends.around(free.profile)
    if not obeys(profile, slew.start, slew.end, slew.limits):
        return None
    status = f"braked at the ends, {free.status} between"
    return AxisSolution(profile, status, bound_without_contacts(slew), free.iterations)
