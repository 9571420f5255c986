"""The slew of least squared jerk within all limits, solved axis by axis."""

import time
from typing import NamedTuple

from planner.slew.closed_forms import least_jerk_profile
from planner.slew.feasibility import AxisVerdict, axis_refusal, verdict
from planner.slew.problem import AxisSlew, SlewProblem
from planner.slew.smoothest import Smoothest, bound_without_contacts, smoothest
from planner.slew.solution import AxisProfile, SlewSolution, obeys
from planner.solvers import SolverRun

OPTIMAL_GAP = 1e-3  # of the cost: what is called optimal is no further from the bound


FEASIBLE = "feasible, not the smoothest"


class AxisSolution(NamedTuple):
    """status: how good the profile is; no motion costs less than the bound.

    run: of the solver whose motion it is, None where it found none.  iterations: in all.
    """

    profile: AxisProfile
    status: str
    lower_bound_rad2_s5: float
    run: SolverRun | None
    iterations: int


def optimal_slew(problem: SlewProblem) -> SlewSolution:
    """The slew with the least integral of squared jerk, every limit kept at every instant.

    Each axis's optimal control problem is solved by Ipopt, and comes with a lower bound for every
    motion between its states within its limits; it is called optimal where it costs at most
    0.1 % more.  Every profile is accepted on its own exact extremes, whatever the solver says.
    Structural modes to spare cost extra.  Raises InfeasibleSlew.
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
        runs=tuple(axis.run for axis in axes),
        iterations=sum(axis.iterations for axis in axes),
        wall_s=time.perf_counter() - began_s,
        violations=(),
        end_error_rad=(0.0,) * len(axes),
    )


def _solve_axis(name: str, slew: AxisSlew) -> AxisSolution:
    """Raises InfeasibleSlew."""
    start, end, limits = slew.start, slew.end, slew.limits
    quintic = least_jerk_profile(start, end, slew.duration_s)
    possible = AxisVerdict(profile=quintic)
    if not obeys(quintic, start, end, limits):
        possible = verdict(start, end, limits, slew.duration_s)
    if possible.limit is not None:
        raise axis_refusal(name, slew, possible.limit)
    known = possible.profile
    found = smoothest(slew, known, None)
    if found is not None:
        bound = found.lower_bound_rad2_s5
        return AxisSolution(
            found.profile, how_good(found, bound), bound, found.run, found.iterations
        )
    if known is None:
        raise axis_refusal(name, slew, "angle")
    return AxisSolution(known, FEASIBLE, bound_without_contacts(slew), None, 0)


def how_good(found: Smoothest, lower_bound_rad2_s5: float) -> str:
    """What a motion that was sought as the smoothest may be called."""
    if found.spares_modes:
        return "modes spared"
    cost = found.profile.jerk_squared_integral
    gap = (cost - lower_bound_rad2_s5) / max(cost, found.negligible_rad2_s5)
    return "optimal" if gap <= OPTIMAL_GAP else f"smooth, gap {gap:.1%}"
