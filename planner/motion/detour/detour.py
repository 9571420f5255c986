"""Detours around cones and masks that a straight slew enters."""

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array
from planner.base.effort import WorkLimitReached
from planner.base.errors import InfeasibleSlew
from planner.motion.detour.ends import free_part, with_part_replaced
from planner.motion.detour.infeasibility_proof import OPTIONS as PROOF_OPTIONS
from planner.motion.detour.infeasibility_proof import (
    catching_region,
    is_unreachable,
)
from planner.motion.detour.passage import rough_paths
from planner.motion.detour.search import (
    OPTIONS as DETOUR_SEARCH_OPTIONS,
)
from planner.motion.detour.search import (
    Detour,
    DetourSearch,
    slew_entry,
)
from planner.motion.detour.spline_ocp import SplineOcp, graded_ocp, ocp_on_all_rows
from planner.motion.pointing.keep_out import KeepOutView, MovingCone
from planner.motion.slew.problem import SlewProblem
from planner.motion.slew.solution import SlewSolution, rows_in
from planner.world.platforms import FieldMask


@dataclass(frozen=True, kw_only=True)
class DetourOptions:
    """The number of guesses from which a way around cones is sought; how good it must be."""

    spans: int = 32  # costs 1e-4 more than 48, and a fifth less time
    finer_spans: int = 64  # where a way found in the others can't be flown in rows
    side_instants: int = 60  # of the straight slew, at which a side step must be outside
    # share of the slew in which a side step takes no middle: there its ends hold it
    near_ends: float = 0.15
    # of a slew: a base of a spline that is free on each row grows with their square
    rows_all_free_max: int = 200
    # guesses that wander from end to end, where none was found: where one was, however dear, they
    # found none that cost over 1 % less (two dozen slews)
    random_restarts: int = 24
    random_restart_rad: float = 2.0  # by so much, over `WAVES`
    # of the cost: then the optimum has neighbours between the instants, maybe cheaper ones
    large_sampling_gap: float = 0.02
    perturbations: int = 8  # guesses beside such a way
    perturbation_rad: float = 0.3  # by so much, likewise
    spared: float = 0.97  # of the acceleration limit, where the flown Hermite passed it


OPTIONS = DetourOptions()

ASIDE_RAD = np.concatenate([[0.02, 0.05], np.linspace(0.1, 3.0, 30)])
WAVES = np.arange(1, 5)  # half waves; with three, or 1.5 rad, one slew of 12 found no way
Region = MovingCone | FieldMask


def avoid_cones(
    solution: SlewSolution, *, thorough: bool = True, prove: bool = True
) -> SlewSolution:
    """The slew itself, or the smoothest one found around the cones and masks it enters.

    Both axes are then solved together from guesses on both sides; the better one that keeps
    every limit, also when flown from rows, and stays outside on a 10 ms grid is taken.
    thorough: also try guesses near what was found, and two dozen others where nothing was.
    prove: where there is no detour, prove it before searching long; else that is only said after
    the search.  Raises InfeasibleSlew.
    """
    problem = solution.problem
    if problem.keep_out is None:
        return solution
    began_s = time.perf_counter()
    entry = slew_entry(solution.profiles, problem.keep_out)
    if entry.depth_rad <= -DETOUR_SEARCH_OPTIONS.touch_rad:
        return solution
    _require_ends_outside(problem, problem.keep_out, solution.duration_s)
    catching = catching_region(problem, problem.keep_out, solution.duration_s)
    if catching is not None:
        raise _infeasible_slew(solution, (catching,))
    found = _detour_between_ends(solution, problem.keep_out, thorough=thorough, prove=prove)
    if found is None:
        if prove and is_unreachable(
            problem, problem.keep_out, solution.duration_s, PROOF_OPTIONS.fine_cells_rad
        ):
            raise _infeasible_slew(solution, _blocking_regions(solution, problem.keep_out))
        regions = problem.keep_out.regions
        raise InfeasibleSlew(
            f"the straight slew enters {entry.title} by {math.degrees(entry.depth_rad):.2f} deg "
            f"and no way around {_join_titles(regions)} was found in {solution.duration_s:.1f} s; "
            f"{_ways_out(regions)}",
            limit="keep_out",
        )
    return replace(
        solution,
        profiles=found.profiles,
        status=("detour",) * len(found.profiles),
        runs=(found.run,),
        iterations=solution.iterations + found.iterations,
        wall_s=solution.wall_s + time.perf_counter() - began_s,
        search_truncated=found.search_truncated,
    )


def _require_ends_outside(problem: SlewProblem, view: KeepOutView, duration_s: float) -> None:
    angle = np.array([[axis.angle_rad for axis in side] for side in (problem.start, problem.end)])
    depths = view.depths_rad(np.array([0.0, duration_s]), angle)
    for side, depth in zip(("begins", "ends"), depths.T, strict=True):
        worst = int(np.argmax(depth))
        if depth[worst] > 0.0:
            raise InfeasibleSlew(
                f"the slew {side} {math.degrees(depth[worst]):.2f} deg inside "
                f"{view.regions[worst].title}",
                limit="keep_out",
            )


def _detour_between_ends(
    straight: SlewSolution, view: KeepOutView, *, thorough: bool, prove: bool
) -> Detour | None:
    """Around the regions, after and before what the ends must brake."""
    part = free_part(straight, view)
    if part is None:
        return _seek_detour(straight, view, thorough=thorough, prove=prove)
    free, shifted, begins_s = part
    if prove:
        _require_reachable_end(straight, view)
    depths = shifted.depths_rad(
        np.array([0.0, free.duration_s]), free.motion(np.array([0.0, free.duration_s]))[0]
    )
    if depths.max() >= 0.0:
        return _seek_detour(straight, view, thorough=thorough, prove=prove)
    # Of a part of a slew nothing is proven: another motion at its ends may be possible.
    found = _seek_detour(free, shifted, thorough=thorough, prove=False)
    if found is None:
        return None
    profiles = with_part_replaced(straight, begins_s, found.profiles)
    if slew_entry(profiles, view).depth_rad > -DETOUR_SEARCH_OPTIONS.touch_rad:
        return _seek_detour(straight, view, thorough=thorough, prove=prove)
    return found._replace(profiles=profiles)


def _require_reachable_end(straight: SlewSolution, view: KeepOutView) -> None:
    if is_unreachable(straight.problem, view, straight.duration_s, PROOF_OPTIONS.cells_rad):
        raise _infeasible_slew(straight, _blocking_regions(straight, view))


def _infeasible_slew(straight: SlewSolution, regions: tuple[Region, ...]) -> InfeasibleSlew:
    return InfeasibleSlew(
        f"no motion within the limits leads around {_join_titles(regions)} in "
        f"{straight.duration_s:.1f} s; {_ways_out(regions)}, or choose other times",
        limit="keep_out",
    )


def _seek_detour(
    straight: SlewSolution, view: KeepOutView, *, thorough: bool, prove: bool
) -> Detour | None:
    """Both sides first; where neither leads on, the way that flooding the angles finds.

    Where that fails too, guesses that wander; not all, where the work that may be done ends before.
    """
    spline = graded_ocp(OPTIONS.spans)
    search = DetourSearch(straight, view, spline)
    found = search.solve_near(_both_sides(view, straight, spline))
    if not any(one.off_rows or math.isfinite(one.cost) for one in found):
        if prove:
            _require_reachable_end(straight, view)
        found += _along_rough_paths(straight, view)
    best, search_truncated = min(found, key=lambda one: one.cost), False
    if thorough:
        try:
            found += _more_detours(straight, search, best)
        except WorkLimitReached:
            if not math.isfinite(best.cost):
                raise
            search_truncated = True
    if any(one.off_rows for one in found) and not any(math.isfinite(one.cost) for one in found):
        found += _on_rows(straight, view, min(found, key=lambda one: not one.off_rows))
    best = min(found, key=lambda one: one.cost)
    if not math.isfinite(best.cost):
        return None
    return best._replace(
        iterations=sum(one.iterations for one in found), search_truncated=search_truncated
    )


def _along_rough_paths(straight: SlewSolution, view: KeepOutView) -> list[Detour]:
    """Detours near flooded paths, until one is good.

    In a narrow passage the hulls of finer splines leave a degree more.
    """
    t_s, paths = rough_paths(straight.problem, view, straight.duration_s)
    found: list[Detour] = []
    for path in paths:
        for spans in (OPTIONS.spans, OPTIONS.finer_spans):
            search = DetourSearch(straight, view, graded_ocp(spans))
            found += search.solve_near((_aside_along(straight, search.spline, t_s, path),))
            if any(one.off_rows or math.isfinite(one.cost) for one in found):
                return found
    return found


def _more_detours(straight: SlewSolution, search: DetourSearch, best: Detour) -> list[Detour]:
    """Detours from guesses near one that has neighbours; from random ones where there is none."""
    if not math.isfinite(best.cost):
        guesses = _random_waves(search.spline, OPTIONS.random_restarts, OPTIONS.random_restart_rad)
        return search.solve_near(guesses)
    if best.sampling_gap_share <= OPTIONS.large_sampling_gap:
        return []
    aside = _aside_of(best, straight, search.spline)
    waves = _random_waves(search.spline, OPTIONS.perturbations, OPTIONS.perturbation_rad)
    return search.solve_near(tuple(aside + wave for wave in waves), start="wide")


def _blocking_regions(straight: SlewSolution, view: KeepOutView) -> tuple[Region, ...]:
    """The first region that makes the end unreachable by itself, or all of them."""
    if len(view.regions) == 1:
        return view.regions
    for region in view.regions:
        alone = view.with_region_alone(region)
        if is_unreachable(straight.problem, alone, straight.duration_s, PROOF_OPTIONS.cells_rad):
            return (region,)
    return view.regions


def _join_titles(regions: tuple[Region, ...]) -> str:
    *before, last = [region.title for region in regions]
    return f"{', '.join(before)} and {last}" if before else last


def _ways_out(regions: tuple[Region, ...]) -> str:
    if any(isinstance(region, MovingCone) for region in regions):
        return "give the slew more time or the cone a smaller half angle"
    return "give the slew more time, or begin it with other angles"


def _on_rows(straight: SlewSolution, view: KeepOutView, near: Detour) -> list[Detour]:
    """Solve again where rows can't carry it: with acceleration to spare, then jerk on rows."""
    rows = rows_in(straight.duration_s)
    bases = [
        (graded_ocp(OPTIONS.spans), OPTIONS.spared),
        (graded_ocp(OPTIONS.finer_spans), OPTIONS.spared),
    ]
    if rows <= OPTIONS.rows_all_free_max:
        bases.append((ocp_on_all_rows(rows), 1.0))
    found: list[Detour] = []
    for spline, share in bases:
        aside = _aside_of(near, straight, spline)
        found += DetourSearch(straight, view, spline, share).solve_near((aside,))
        if math.isfinite(found[-1].cost):
            break
    return found


def _aside_of(detour: Detour, straight: SlewSolution, spline: SplineOcp) -> Array:
    at_s = spline.greville_tau * straight.duration_s
    path = np.stack([profile.evaluate(at_s)[0] for profile in detour.profiles])
    return np.asarray(path - straight.motion(at_s)[0].T)


def _aside_along(straight: SlewSolution, spline: SplineOcp, t_s: Array, path_rad: Array) -> Array:
    at_s = spline.greville_tau * straight.duration_s
    path = np.stack([np.interp(at_s, t_s, angle_rad) for angle_rad in path_rad.T])
    return np.asarray(path - straight.motion(at_s)[0].T)


def _both_sides(view: KeepOutView, straight: SlewSolution, spline: SplineOcp) -> tuple[Array, ...]:
    """How far to step aside at the spline's `greville_tau` instants, (2, k), to either side."""
    T = straight.duration_s
    tau = (np.arange(OPTIONS.side_instants) + 0.5) / OPTIONS.side_instants
    angle, rate, _, _ = straight.motion(tau * T)
    depth = view.depths_rad(tau * T, angle).max(axis=0)
    worst = int(np.argmax(depth))
    middle = float(np.clip(tau[worst], OPTIONS.near_ends, 1.0 - OPTIONS.near_ends))
    speed = float(np.linalg.norm(rate[worst]))
    ahead = rate[worst] / speed if speed > 0.0 else np.array([1.0, 0.0])
    across = np.array([-ahead[1], ahead[0]])

    def coefficients_aside(direction: Array) -> Array:
        bump = _smooth_bump(tau, middle)
        tried = angle + (ASIDE_RAD[:, None] * bump)[:, :, None] * direction
        flat = view.depths_rad(np.tile(tau * T, len(ASIDE_RAD)), tried.reshape(-1, 2))
        deepest = flat.max(axis=0).reshape(len(ASIDE_RAD), -1).max(axis=1)
        outside = np.flatnonzero(deepest < 0.0)
        size = ASIDE_RAD[outside[0] if outside.size else int(np.argmin(deepest))]
        return np.asarray(np.outer(size * direction, _smooth_bump(spline.greville_tau, middle)))

    return coefficients_aside(across), coefficients_aside(-across)


def _random_waves(spline: SplineOcp, count: int, size_rad: float) -> tuple[Array, ...]:
    """Smooth excursions of any kind, the same ones every time."""
    rng = np.random.default_rng(0)
    waves = np.sin(np.pi * np.outer(WAVES, spline.greville_tau))
    sizes = rng.normal(size=(count, 2, len(WAVES))) * size_rad / WAVES
    return tuple(sizes @ waves)


def _smooth_bump(tau: Array, middle_tau: float) -> Array:
    x = np.minimum(tau / middle_tau, (1.0 - tau) / (1.0 - middle_tau))
    return np.asarray(x * x * x * (10.0 - x * (15.0 - 6.0 * x)))
