"""Makes a slew that rows 0.2 s apart can carry: within its limits, and still itself."""

import time
from dataclasses import replace

from planner.commands import COMMAND_STEP_S
from planner.errors import InfeasibleSlew
from planner.slew.flown import reproduces
from planner.slew.optimal import how_good
from planner.slew.problem import AxisSlew
from planner.slew.smoothest import Smoothest, smoothest
from planner.slew.solution import AxisProfile, SlewSolution


def rows_in(duration_s: float) -> int:
    """How many command steps a slew of duration_s takes; ValueError if it isn't a whole number."""
    rows = round(duration_s / COMMAND_STEP_S)
    if rows < 1 or abs(rows * COMMAND_STEP_S - duration_s) > 1e-6 * COMMAND_STEP_S:
        raise ValueError(
            f"duration_s must be a multiple of the command step, 0.2 s, not {duration_s}"
        )
    return rows


def fit_to_rows(solution: SlewSolution) -> SlewSolution:
    """The slew as it can be flown from rows every 0.2 s: cubic Hermite between them.

    A sampled profile whose Hermite breaks a limit or leaves the plan by more than 0.1 arcsec
    is replaced, axis by axis, by the smoothest motion whose jerk changes on rows only, which
    a cubic Hermite reproduces; so is one that spares modes, which feel what is flown.
    Raises InfeasibleSlew when the time is too short by less than a row or so for that.
    """
    began_s = time.perf_counter()
    problem = solution.problem
    rows = rows_in(solution.duration_s)
    profiles, status, runs, iterations = [], [], [], solution.iterations
    for name, slew, profile, found, run, bound in zip(
        problem.axis_names,
        problem.axes,
        solution.profiles,
        solution.status,
        solution.runs,
        solution.lower_bounds_rad2_s5 or (0.0,) * len(solution.profiles),
        strict=True,
    ):
        if not slew.avoid_modes and reproduces(profile, rows, slew.limits):
            profiles.append(profile)
            status.append(found)
            runs.append(run)
            continue
        on_rows = _smoothest_on_rows(profile, slew, rows, bound)
        if on_rows is None:
            raise InfeasibleSlew(
                f"{name} makes the slew in {solution.duration_s:.1f} s only when its jerk may "
                f"change between the rows of the command table; one row more is enough",
                axis=name,
                limit="duration",
            )
        profiles.append(on_rows.profile)
        status.append(f"{how_good(on_rows, bound)}, jerk on rows")
        runs.append(on_rows.run)
        iterations += on_rows.iterations
    return replace(
        solution,
        profiles=tuple(profiles),
        status=tuple(status),
        runs=tuple(runs),
        iterations=iterations,
        wall_s=solution.wall_s + time.perf_counter() - began_s,
    )


def _smoothest_on_rows(
    profile: AxisProfile, slew: AxisSlew, rows: int, bound_rad2_s5: float
) -> Smoothest | None:
    """The smoothest of the motions that rows can carry."""
    slew = replace(slew, duration_s=profile.duration_s)
    found = smoothest(slew, profile, rows, lower_bound_rad2_s5=bound_rad2_s5)
    if found is None or not reproduces(found.profile, rows, slew.limits):
        return None
    return found
