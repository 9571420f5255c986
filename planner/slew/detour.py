"""Which way around the cones, when the straight slew enters one?"""

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.errors import InfeasibleSlew
from planner.gimbal.keep_out import Entry, KeepOutView, deepest_entry
from planner.platforms import AxisLimits
from planner.slew.backends.detour_ocp import POINTS, detour_ocp
from planner.slew.backends.ipopt import graded_ocp
from planner.slew.backends.spline_ocp import SplineOcp
from planner.slew.grid import on_all_rows, reproduces, rows_in
from planner.slew.passage import passage
from planner.slew.problem import SlewProblem
from planner.slew.solution import AxisProfile, SlewSolution, obeys

Array = NDArray[np.float64]
Profiles = tuple[AxisProfile, AxisProfile]
SPANS = 32  # costs 1e-4 more than 48, and a fifth less time
TOUCH_RAD = 1e-6  # the flown Hermite may leave the plan by half of it
MARGIN_RAD = math.radians(0.1)
MARGIN_GROWTH_RAD = math.radians(0.02)
MARGIN_RISE = 0.05  # share of the slew over which the margin grows from its ends
PASSES = 4
HOPELESS_RAD = math.radians(2.0)  # deeper than a path can sink between two instants
ASIDE_RAD = np.concatenate([[0.02, 0.05], np.linspace(0.1, 3.0, 30)])
NEAR_ENDS = 0.15
ROWS_ALL_FREE_MAX = 200
DEAR = 4.0  # times the straight slew's cost: then it's worth while to look for better ones
WANDERINGS, WANDERING_RAD = 12, 1.5
SPARED = 0.97  # of the acceleration limit, where the flown Hermite passed it


class _Detour(NamedTuple):
    """cost: infinite where the result is not good.  off_rows: good but for flying it from rows."""

    profiles: Profiles
    cost: float
    off_rows: bool
    iterations: int


def cleared(solution: SlewSolution, *, thorough: bool = True) -> SlewSolution:
    """The slew itself, or the smoothest one found around the cones it enters.

    Both axes are then solved together, with the cones at 120 instants, from guesses on both
    sides; the better one that keeps every limit, also when flown from rows, and stays outside
    on a 10 ms grid is taken.  thorough: also try a dozen other guesses where the ways found
    are dear, or none is found and none ruled out.  Raises InfeasibleSlew.
    """
    problem = solution.problem
    if problem.keep_out is None:
        return solution
    began_s = time.perf_counter()
    entry = entered(solution.profiles, problem.keep_out)
    if entry.depth_rad <= -TOUCH_RAD:
        return solution
    _require_ends_outside(problem, problem.keep_out, solution.duration_s)
    found = _around(problem, problem.keep_out, solution, thorough=thorough)
    if found is None:
        raise InfeasibleSlew(
            f"the straight slew enters the cone about {entry.about} by "
            f"{math.degrees(entry.depth_rad):.2f} deg and no way around it was found in "
            f"{solution.duration_s:.1f} s; give the slew more time or the cone a smaller half "
            "angle",
            limit="keep_out",
        )
    return replace(
        solution,
        profiles=found.profiles,
        status=("detour",) * len(found.profiles),
        iterations=solution.iterations + found.iterations,
        wall_s=solution.wall_s + time.perf_counter() - began_s,
    )


def entered(profiles: tuple[AxisProfile, ...], view: KeepOutView) -> Entry:
    """How deep a slew goes into the cones."""

    def motion(t_s: Array) -> tuple[Array, Array]:
        values = [profile.evaluate(t_s) for profile in profiles]
        return (
            np.stack([value[0] for value in values], axis=1),
            np.stack([value[1] for value in values], axis=1),
        )

    return deepest_entry(view, motion, 0.0, profiles[0].duration_s)


def _require_ends_outside(problem: SlewProblem, view: KeepOutView, duration_s: float) -> None:
    angle = np.array([[axis.angle_rad for axis in side] for side in (problem.start, problem.end)])
    depths = view.depths_rad(np.array([0.0, duration_s]), angle)
    for side, depth in zip(("begins", "ends"), depths.T, strict=True):
        worst = int(np.argmax(depth))
        if depth[worst] > 0.0:
            raise InfeasibleSlew(
                f"the slew {side} {math.degrees(depth[worst]):.2f} deg inside the cone about "
                f"{view.cones[worst].about}",
                limit="keep_out",
            )


def _around(
    problem: SlewProblem, view: KeepOutView, straight: SlewSolution, *, thorough: bool
) -> _Detour | None:
    """Both sides first; where neither leads on, the way that flooding the angles finds.

    Where that is dear or fails too, guesses that wander.
    """
    spline = graded_ocp(SPANS)
    found = _solutions(problem, view, straight, spline, _both_sides(view, straight, spline))
    if not any(one.off_rows or math.isfinite(one.cost) for one in found):
        way = passage(problem, view, straight.duration_s)
        if way.impossible:
            raise InfeasibleSlew(
                f"no motion within the limits leads around the cone about "
                f"{entered(straight.profiles, view).about} in {straight.duration_s:.1f} s; give "
                "the slew more time, the cone a smaller half angle, or choose other times",
                limit="keep_out",
            )
        if way.angle_rad is not None:
            aside = _off(straight, spline, way.t_s, way.angle_rad)
            found += _solutions(problem, view, straight, spline, (aside,))
    if thorough and min(one.cost for one in found) > DEAR * straight.jerk_squared_integral:
        found += _solutions(problem, view, straight, spline, _wandering(spline))
    if any(one.off_rows for one in found) and not any(math.isfinite(one.cost) for one in found):
        found += _on_rows(problem, view, straight, min(found, key=lambda one: not one.off_rows))
    best = min(found, key=lambda one: one.cost)
    if not math.isfinite(best.cost):
        return None
    return best._replace(iterations=sum(one.iterations for one in found))


def _on_rows(
    problem: SlewProblem, view: KeepOutView, straight: SlewSolution, near: _Detour
) -> list[_Detour]:
    """Again from one that rows can't carry: with acceleration to spare, then with jerk on rows."""
    rows = rows_in(straight.duration_s)
    bases = [(graded_ocp(SPANS), SPARED)]
    if rows <= ROWS_ALL_FREE_MAX:
        bases.append((on_all_rows(rows), 1.0))
    found: list[_Detour] = []
    for spline, share in bases:
        at_s = spline.greville * straight.duration_s
        path = np.stack([profile.evaluate(at_s)[0] for profile in near.profiles], axis=1)
        aside = _off(straight, spline, at_s, path)
        found += _solutions(problem, view, straight, spline, (aside,), share)
        if math.isfinite(found[-1].cost):
            break
    return found


def _solutions(
    problem: SlewProblem,
    view: KeepOutView,
    straight: SlewSolution,
    spline: SplineOcp,
    asides: tuple[Array, ...],
    share: float = 1.0,
) -> list[_Detour]:
    """One per guess; share: of the acceleration limit."""
    limits = tuple(
        replace(axis, acceleration_max_rad_s2=share * axis.acceleration_max_rad_s2)
        for axis in problem.limits
    )
    return [_solved(problem, view, straight, spline, limits, aside) for aside in asides]


def _off(straight: SlewSolution, spline: SplineOcp, t_s: Array, angle_rad: Array) -> Array:
    at_s = spline.greville * straight.duration_s
    path = [np.interp(at_s, t_s, angle_rad[:, axis]) for axis in range(2)]
    return np.asarray(np.stack(path) - straight.motion(at_s)[0].T)


def _solved(
    problem: SlewProblem,
    view: KeepOutView,
    straight: SlewSolution,
    spline: SplineOcp,
    limits: tuple[AxisLimits, ...],
    aside_rad: Array,
) -> _Detour:
    """From one guess; the cost is infinite where the result is not good."""
    T = straight.duration_s
    rows = rows_in(T)
    states = list(zip(problem.start, problem.end, strict=True))
    moves = [abs(end.angle_rad - start.angle_rad) for start, end in states]
    scale_rad = max(*moves, *(cone.half_angle_rad for cone in view.cones), 0.1)
    posed = [
        spline.pose(*ends, limit, T, scale_rad=scale_rad, avoid_modes=problem.avoid_modes)
        for ends, limit in zip(states, limits, strict=True)
    ]
    axes = (posed[0], posed[1])
    ocp = detour_ocp(spline, len(view.cones), calm=bool(problem.avoid_modes))
    guess = np.stack(
        [
            spline.guess(axis, profile, aside)
            for axis, profile, aside in zip(axes, straight.profiles, aside_rad, strict=True)
        ]
    )
    margin_rad, iterations, profiles = MARGIN_RAD, 0, straight.profiles
    for _ in range(PASSES):
        margins = _margins(problem, view, ocp.tau, T, margin_rad)
        profiles, used = ocp.solve(view.platform, axes, view.cones, margins, guess)
        iterations += used
        depth_rad = entered(profiles, view).depth_rad
        if depth_rad <= -TOUCH_RAD or depth_rad > HOPELESS_RAD:
            break
        margin_rad += max(depth_rad, 0.0) + MARGIN_GROWTH_RAD
        guess = np.stack(
            [
                spline.guess(axis, profile, np.zeros(spline.free_count))
                for axis, profile in zip(axes, profiles, strict=True)
            ]
        )
    keeps = depth_rad <= -TOUCH_RAD and all(
        obeys(profile, *ends, limit)
        for profile, ends, limit in zip(profiles, states, problem.limits, strict=True)
    )
    fits = keeps and all(
        reproduces(profile, rows, limit)
        for profile, limit in zip(profiles, problem.limits, strict=True)
    )
    return _Detour(
        profiles=(profiles[0], profiles[1]),
        cost=sum(profile.jerk_squared_integral for profile in profiles) if fits else math.inf,
        off_rows=keeps and not fits,
        iterations=iterations,
    )


def _margins(
    problem: SlewProblem, view: KeepOutView, tau: Array, duration_s: float, margin_rad: float
) -> Array:
    """Beside each cone at each instant, less near an end that is nearer to the cone itself."""
    angle = np.array([[axis.angle_rad for axis in side] for side in (problem.start, problem.end)])
    gap = -view.depths_rad(np.array([0.0, duration_s]), angle) / 2.0
    rising = gap[:, :1] + margin_rad / MARGIN_RISE * tau
    falling = gap[:, 1:] + margin_rad / MARGIN_RISE * (1.0 - tau)
    return np.minimum(margin_rad, np.minimum(rising, falling))


def _both_sides(view: KeepOutView, straight: SlewSolution, spline: SplineOcp) -> tuple[Array, ...]:
    """How far to step aside at the spline's `greville` instants, (2, k), to either side."""
    T = straight.duration_s
    tau = (np.arange(POINTS) + 0.5) / POINTS
    angle, rate, _, _ = straight.motion(tau * T)
    depth = view.depths_rad(tau * T, angle).max(axis=0)
    worst = int(np.argmax(depth))
    middle = float(np.clip(tau[worst], NEAR_ENDS, 1.0 - NEAR_ENDS))
    speed = float(np.linalg.norm(rate[worst]))
    ahead = rate[worst] / speed if speed > 0.0 else np.array([1.0, 0.0])
    across = np.array([-ahead[1], ahead[0]])

    def aside(direction: Array) -> Array:
        bump = _bump(tau, middle)
        tried = angle + (ASIDE_RAD[:, None] * bump)[:, :, None] * direction
        flat = view.depths_rad(np.tile(tau * T, len(ASIDE_RAD)), tried.reshape(-1, 2))
        deepest = flat.max(axis=0).reshape(len(ASIDE_RAD), -1).max(axis=1)
        outside = np.flatnonzero(deepest < 0.0)
        size = ASIDE_RAD[outside[0] if outside.size else int(np.argmin(deepest))]
        return np.asarray(np.outer(size * direction, _bump(spline.greville, middle)))

    return aside(across), aside(-across)


def _wandering(spline: SplineOcp) -> tuple[Array, ...]:
    """Smooth excursions of any kind, the same ones every time."""
    rng = np.random.default_rng(0)
    waves = np.sin(np.pi * np.outer([1, 2, 3], spline.greville))
    sizes = rng.normal(size=(WANDERINGS, 2, 3)) * WANDERING_RAD / np.array([1.0, 2.0, 3.0])
    return tuple(sizes @ waves)


def _bump(tau: Array, middle: float) -> Array:
    x = np.minimum(tau / middle, (1.0 - tau) / (1.0 - middle))
    return np.asarray(x * x * x * (10.0 - x * (15.0 - 6.0 * x)))
