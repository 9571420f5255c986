"""The slew of least squared jerk within all limits, solved axis by axis."""

import time
from dataclasses import replace
from typing import NamedTuple

from planner.base.errors import InfeasibleSlew
from planner.base.solvers import SolverRun
from planner.motion.slew.closed_forms import least_jerk_profile
from planner.motion.slew.feasibility import AxisVerdict, axis_refusal, verdict
from planner.motion.slew.problem import AxisSlew, SlewProblem
from planner.motion.slew.smoothest import Smoothest, bound_without_contacts, find_smoothest
from planner.motion.slew.solution import AxisProfile, SlewSolution, obeys, reproduces, rows_in

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


def optimal_slew(problem: SlewProblem, *, on_rows: bool = False) -> SlewSolution:
    """The slew with the least integral of squared jerk, every limit kept at every instant.

    Each axis's optimal control problem is solved by Ipopt, and comes with a lower bound for every
    motion between its states within its limits; it is called optimal where it costs at most
    0.1 % more.  Every profile is accepted on its own exact extremes, whatever the solver says.
    on_rows: as it can be flown from rows every 0.2 s with the cubic Hermite between them.  Where
    that breaks a limit or leaves the motion by more than 0.1 arcsec, the axis flies the smoothest
    motion that rows carry instead; so it does with modes to suppress, which feel what is flown.
    Structural modes to suppress cost extra.
    Raises InfeasibleSlew, on rows also when the time is too short by less than a row or so.
    Neglects coupling between the axes, which share nothing but the duration: cones to keep
    out of are left to `planner.motion.detour.detour`.
    """
    began_s = time.perf_counter()
    rows = rows_in(problem.duration_s) if on_rows else None
    slews = dict(zip(problem.axis_names, problem.axes, strict=True))
    if rows == 1:  # of constant jerk: nothing is left to choose for the modes' sake
        slews = {name: replace(slew, avoid_modes=()) for name, slew in slews.items()}
    axes = [_solve_axis(name, slew, rows) for name, slew in slews.items()]
    if rows is not None:
        axes = [
            axis if _is_carried(axis.profile, slew, rows) else _on_rows(name, slew, axis, rows)
            for (name, slew), axis in zip(slews.items(), axes, strict=True)
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


def _is_carried(profile: AxisProfile, slew: AxisSlew, rows: int) -> bool:
    """Whether rows fly the slew as it is."""
    return not slew.avoid_modes and reproduces(profile, rows, slew.limits)


def _solve_axis(name: str, slew: AxisSlew, rows: int | None) -> AxisSolution:
    """The motion whose jerk may change anywhere; Ipopt's only where rows, if any, carry it.

    Raises InfeasibleSlew.
    """
    start, end, limits = slew.start, slew.end, slew.limits
    quintic = least_jerk_profile(start, end, slew.duration_s)
    possible = AxisVerdict(profile=quintic)
    if not obeys(quintic, start, end, limits):
        possible = verdict(start, end, limits, slew.duration_s)
    if possible.limit is not None:
        raise axis_refusal(name, slew, possible.limit)
    known = possible.profile
    if rows is None:
        found = find_smoothest(slew, known, None)
    elif slew.avoid_modes:
        found = find_smoothest(replace(slew, avoid_modes=()), known, None, may_fly=None)
    else:
        found = find_smoothest(slew, known, None, may_fly=lambda p: _is_carried(p, slew, rows))
    if found is not None:
        bound = found.lower_bound_rad2_s5
        return AxisSolution(
            found.profile, _how_good(found, bound), bound, found.run, found.iterations
        )
    if known is None:
        raise axis_refusal(name, slew, "angle")
    return AxisSolution(known, FEASIBLE, bound_without_contacts(slew), None, 0)


def _on_rows(name: str, slew: AxisSlew, anywhere: AxisSolution, rows: int) -> AxisSolution:
    """The smoothest of the motions that rows carry.  Raises InfeasibleSlew."""
    known, bound = anywhere.profile, anywhere.lower_bound_rad2_s5
    slew = replace(slew, duration_s=known.duration_s)
    found = find_smoothest(slew, known, rows, lower_bound_rad2_s5=bound)
    if found is None or not reproduces(found.profile, rows, slew.limits):
        raise InfeasibleSlew(
            f"{name} makes the slew in {slew.duration_s:.1f} s only when its jerk may "
            f"change between the rows of the command table; one row more is enough",
            axis=name,
            limit="duration",
        )
    return AxisSolution(
        found.profile,
        f"{_how_good(found, bound)}, jerk on rows",
        bound,
        found.run,
        anywhere.iterations + found.iterations,
    )


def _how_good(found: Smoothest, lower_bound_rad2_s5: float) -> str:
    """What a motion that was sought as the smoothest may be called."""
    if found.suppresses_modes:
        return "modes suppressed"
    cost = found.profile.jerk_squared_integral
    gap = (cost - lower_bound_rad2_s5) / max(cost, found.negligible_rad2_s5)
    return "optimal" if gap <= OPTIMAL_GAP else f"smooth, gap {gap:.1%}"
