"""The slew of least squared jerk within all limits, solved axis by axis."""

import time
from typing import NamedTuple

from planner.slew.closed_forms import least_jerk_profile
from planner.slew.feasibility import axis_refusal, verdict
from planner.slew.problem import AxisSlew, SlewProblem
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
