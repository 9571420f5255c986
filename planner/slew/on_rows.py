"""Makes a slew that rows 0.2 s apart can carry: within its limits, and still itself."""

import time
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from planner.commands import COMMAND_STEP_S
from planner.errors import InfeasibleSlew
from planner.platforms import AxisLimits
from planner.pointing.hermite import cubic_range
from planner.slew.braking import braked_ends
from planner.slew.closed_forms import quickest_profile
from planner.slew.optimal import SPANS, graded_ocp, smoothest_motion
from planner.slew.problem import LIMIT_TOLERANCE, AxisSlew
from planner.slew.solution import AxisProfile, SlewSolution, obeys
from planner.slew.spline_ocp import SplineOcp

REPRODUCTION_RAD = np.deg2rad(0.1 / 3600.0)  # how far the flown Hermite may leave the plan
EXCESS_MARGIN = 1.2
ROWS_ALL_FREE = 250  # beyond, freeing the jerk on every row takes long and comes last
ROWS_ALL_FREE_MAX = 700  # 140 s: more than any platform's least time; solved in half a second
ON_ROWS_KEPT = 2  # both axes ask for the same one; at 700 rows it takes 30 MB
ROWS_SPREAD = 48
ROWS_AROUND = 6  # of each switch of the least-time profile, where the jerk wants to change
SAMPLES_PER_ROW = 8  # the deviation is a quartic bump in a cell: its peak is met within 4 %


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
    a cubic Hermite reproduces exactly.  The jerk of the Hermite is a weighted mean of the
    plan's, so it needs no test.
    Raises InfeasibleSlew when the time is too short by less than a row or so for that.
    """
    began_s = time.perf_counter()
    problem = solution.problem
    rows = rows_in(solution.duration_s)
    profiles, status, iterations = [], [], solution.iterations
    for name, slew, profile, found in zip(
        problem.axis_names, problem.axes, solution.profiles, solution.status, strict=True
    ):
        if reproduces(profile, rows, slew.limits):
            profiles.append(profile)
            status.append(found)
            continue
        on_rows, used = _smoothest_on_rows(profile, slew, rows)
        if on_rows is None:
            raise InfeasibleSlew(
                f"{name} makes the slew in {solution.duration_s:.1f} s only when its jerk may "
                f"change between the rows of the command table; one row more is enough",
                axis=name,
                limit="duration",
            )
        profiles.append(on_rows)
        status.append(f"{found}, jerk on rows")
        iterations += used
    return replace(
        solution,
        profiles=tuple(profiles),
        status=tuple(status),
        iterations=iterations,
        wall_s=solution.wall_s + time.perf_counter() - began_s,
    )


def reproduces(profile: AxisProfile, rows: int, limits: AxisLimits) -> bool:
    """Whether the Hermite of the sampled profile keeps the limits and the plan to 0.1 arcsec."""
    return (
        _deviation_rad(profile, rows) <= REPRODUCTION_RAD
        and limit_excess(profile, rows, limits) <= 0.0
    )


def limit_excess(profile: AxisProfile, rows: int, limits: AxisLimits) -> float:
    """Share by which the flown Hermite passes a limit of angle, rate or acceleration."""
    angle, rate, _, _ = profile.evaluate(np.linspace(0.0, profile.duration_s, rows + 1))
    ranges = cubic_range(profile.duration_s / rows, angle[:, None], rate[:, None])
    excess = -np.inf
    for (least, greatest), (low, high) in zip(ranges[:3], limits.bounds[:3], strict=True):
        span = high - low
        worst = max(float(greatest.max()) - high, low - float(least.min()))
        excess = max(excess, worst / span - LIMIT_TOLERANCE)
    return float(excess)


def _smoothest_on_rows(
    profile: AxisProfile, slew: AxisSlew, rows: int
) -> tuple[AxisProfile | None, int]:
    """The smoothest of the motions that rows can carry, and the iterations it took."""
    whole, iterations = _with_braked_ends(slew, rows)
    if whole is not None:
        return whole, iterations
    slew = replace(slew, duration_s=profile.duration_s)
    for ocp, limits in _formulations(profile, slew, rows):
        result = ocp.solve(replace(slew, limits=limits))
        iterations += result.iterations
        if _is_carried(result.profile, slew, rows):
            return result.profile, iterations
    return None, iterations


def _formulations(
    profile: AxisProfile, slew: AxisSlew, rows: int
) -> Iterator[tuple[SplineOcp, AxisLimits]]:
    """Solvers in turn, with limits to keep."""
    limits = slew.limits
    if rows > ROWS_ALL_FREE:
        # A long slew leaves its plan only where the acceleration's limit bends it.
        excess = max(limit_excess(profile, rows, limits), 0.0)
        acceleration_max_rad_s2 = limits.acceleration_max_rad_s2 * (
            1.0 - 2.0 * EXCESS_MARGIN * excess
        )
        yield graded_ocp(SPANS), replace(limits, acceleration_max_rad_s2=acceleration_max_rad_s2)
        yield _ocp_on_some_rows(slew, rows), limits
    if rows <= ROWS_ALL_FREE_MAX:
        yield ocp_on_all_rows(rows), limits


def _with_braked_ends(slew: AxisSlew, rows: int) -> tuple[AxisProfile | None, int]:
    """Braked at the ends in whole rows, and between them as rows can carry it; None if it can't."""
    ends = braked_ends(slew)
    if ends is None or ends.rows >= rows:
        return None, 0
    free_rows = rows - ends.rows
    between = replace(ends.free, duration_s=free_rows * COMMAND_STEP_S)
    found = smoothest_motion(between)
    if found is None:
        return None, 0
    free, iterations = found.profile, found.iterations
    if not reproduces(free, free_rows, slew.limits):
        free_on_rows, used = _smoothest_on_rows(free, between, free_rows)
        iterations += used
        if free_on_rows is None:
            return None, iterations
        free = free_on_rows
    whole = ends.around(free)
    return (whole if _is_carried(whole, slew, rows) else None), iterations


def _is_carried(profile: AxisProfile, slew: AxisSlew, rows: int) -> bool:
    keeps = obeys(profile, slew.start, slew.end, slew.limits)
    return keeps and reproduces(profile, rows, slew.limits)


def _ocp_on_some_rows(slew: AxisSlew, rows: int) -> SplineOcp:
    """A solver whose jerk may change on the rows that matter in a slew near its least time."""
    quickest = quickest_profile(slew.start, slew.end, slew.limits, rows * COMMAND_STEP_S)
    free = set(np.linspace(0, rows, ROWS_SPREAD, dtype=int).tolist())
    if quickest is not None:
        for switch_s in quickest.breakpoints_s:
            row = round(float(switch_s) / COMMAND_STEP_S)
            free.update(range(max(row - ROWS_AROUND, 0), min(row + ROWS_AROUND, rows) + 1))
    return SplineOcp(np.array(sorted(free | {0, rows})) / rows, degree=3)


def _deviation_rad(profile: AxisProfile, rows: int) -> float:
    """Of the Hermite from the profile; only cells that may be off by too much are looked at."""
    step_s = profile.duration_s / rows
    cells = _cells_in_doubt(profile, rows)
    if not cells.size:
        return 0.0
    s = np.arange(1, SAMPLES_PER_ROW) / SAMPLES_PER_ROW
    starts_s = cells.astype(float) * step_s
    angle0, rate0, _, _ = profile.evaluate(starts_s)
    angle1, rate1, _, _ = profile.evaluate(starts_s + step_s)
    between = (starts_s[:, None] + s * step_s).ravel()
    planned = profile.evaluate(between)[0].reshape(len(cells), len(s))
    h00, h01 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s**2 * (3.0 - 2.0 * s)
    h10, h11 = s * (1.0 - s) ** 2 * step_s, s**2 * (s - 1.0) * step_s
    hermite = (
        np.outer(angle0, h00) + np.outer(angle1, h01) + np.outer(rate0, h10) + np.outer(rate1, h11)
    )
    return float(np.abs(hermite - planned).max())


def _cells_in_doubt(profile: AxisProfile, rows: int) -> NDArray[np.intp]:
    """Cells with a breakpoint inside, and those where the fourth derivative is large.

    Elsewhere the Hermite's error is at most step^4 / 384 of that derivative (de Boor 2001, ch. V).
    """
    step_s = profile.duration_s / rows
    at_row = profile.breakpoints_s / step_s
    begins, ends = np.floor(at_row[:-1] + 1e-9), np.ceil(at_row[1:] - 1e-9)
    inside = np.flatnonzero(np.abs(at_row - np.round(at_row)) > 1e-9)
    powers = np.arange(4, profile.coefficients.shape[1])
    width = np.diff(profile.breakpoints_s)[:, None]
    scale = powers * (powers - 1) * (powers - 2) * (powers - 3)
    fourth = np.abs(profile.coefficients[:, 4:] * scale * width ** (powers - 4)).sum(axis=1)
    doubtful = np.flatnonzero(fourth * step_s**4 / 384.0 > REPRODUCTION_RAD)
    cells = [np.floor(at_row[inside])]
    cells += [np.arange(begins[piece], ends[piece]) for piece in doubtful]
    return np.unique(np.clip(np.concatenate(cells), 0, rows - 1)).astype(np.intp)


@lru_cache(maxsize=ON_ROWS_KEPT)
def ocp_on_all_rows(rows: int) -> SplineOcp:
    """A solver whose jerk may change on every row and nowhere else; a Hermite reproduces it."""
    return SplineOcp(np.linspace(0.0, 1.0, rows + 1), degree=3)
