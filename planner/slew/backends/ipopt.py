"""Which motion within all limits is the smoothest, or the quickest? The optimal control backend."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.commands import COMMAND_STEP_S
from planner.platforms import AxisLimits, StructuralMode
from planner.scenario import SlewOptions
from planner.slew.backends.spline_ocp import SplineOcp
from planner.slew.braking import braked_ends
from planner.slew.feasibility import AxisVerdict, infeasible, next_duration_s, verdict
from planner.slew.least_jerk import least_jerk_profile
from planner.slew.problem import AxisState, SlewProblem, within
from planner.slew.quickest import LONGEST_S, quickest_profile, resting
from planner.slew.solution import AxisProfile, SlewSolution, obeys

SPANS = 48
STEEP_SPANS = 60
FINER_SPANS = 120
STEEPNESS = 2.5
FREE_SAMPLES = 33  # enough to tell which knots to try first
QUICKEST_SHARE = 1.01  # below this multiple of the least time the exact profile is flown
THIN_SHARE = 0.003  # of the rate limit in hand: the hull of any knots fails, so brake first
GAP_PASSES = 8  # each pass leaves one gap of one axis behind; an axis has two at most


class AxisSolution(NamedTuple):
    """status says which rung of the ladder gave the profile."""

    profile: AxisProfile
    status: str
    iterations: int


def solve(problem: SlewProblem, options: SlewOptions) -> SlewSolution:
    """The slew with the least integral of squared jerk, every limit kept at every instant.

    "minimum_time" first shortens the duration to the least that all axes share; an axis with
    time to spare still moves smoothly.  Up to 1.01 of an axis's least time its exact
    least-time profile is flown.  Every profile is accepted on its own exact extremes,
    whatever the solver says.  Structural modes to spare cost extra, above 1.01 of the least
    time.  Raises InfeasibleSlew.
    Neglects coupling between the axes, which share nothing but the duration: cones to keep
    out of are left to `planner.detour.detour`.
    """
    del options  # the optimal control problem has no options beyond its limits
    began_s = time.perf_counter()
    duration_s = problem.duration_s
    if problem.objective == "minimum_time":
        duration_s = shared_minimum_s(problem)
    axes = [solve_axis(problem, axis, duration_s) for axis in range(len(problem.axis_names))]
    return SlewSolution(
        problem=problem,
        backend="ocp",
        profiles=tuple(axis.profile for axis in axes),
        status=tuple(axis.status for axis in axes),
        iterations=sum(axis.iterations for axis in axes),
        wall_s=time.perf_counter() - began_s,
        violations=(),
        end_error_rad=(0.0,) * len(axes),
    )


def solve_axis(problem: SlewProblem, axis: int, duration_s: float) -> AxisSolution:
    """One axis in exactly duration_s.  Raises InfeasibleSlew."""
    if duration_s > LONGEST_S:
        return _with_a_rest(problem, axis, duration_s)
    found = _motion(
        problem.start[axis],
        problem.end[axis],
        problem.limits[axis],
        duration_s,
        problem.avoid_modes,
    )
    if isinstance(found, str):
        raise infeasible(problem, axis, duration_s, found)
    return found


def _motion(
    start: AxisState,
    end: AxisState,
    limits: AxisLimits,
    duration_s: float,
    modes: tuple[StructuralMode, ...],
) -> AxisSolution | str:
    """The smoothest motion in exactly duration_s, or the limit that forbids any."""
    smoothest = least_jerk_profile(start, end, duration_s)
    if not modes and obeys(smoothest, start, end, limits):
        return AxisSolution(smoothest, "closed form", 0)
    found = verdict(start, end, limits, duration_s)
    if found.limit is not None:
        return found.limit
    if found.profile is not None and _is_quickest(start, end, limits, duration_s):
        return AxisSolution(found.profile, "least time", 0)
    return _climb(start, end, limits, duration_s, found, modes) or "angle"


def _with_a_rest(problem: SlewProblem, axis: int, duration_s: float) -> AxisSolution:
    """Smoothly to rest, a wait, and smoothly on: within rounding as smooth as using the hours.

    The knots of one spline over hours would be too far apart to gather speed between stops.
    """
    start, end = problem.start[axis], problem.end[axis]
    rest = AxisState(angle_rad=start.angle_rad)
    stills = tuple(AxisState(angle_rad=state.angle_rad) for state in problem.start)
    to_rest = on = None
    if start != rest:
        to_rest = solve_axis(replace(problem, end=stills), axis, LONGEST_S / 2.0)
    if end != rest:
        on = solve_axis(replace(problem, start=stills), axis, LONGEST_S / 2.0)
    parts = [part for part in (to_rest, on) if part is not None]
    profile = resting(
        rest, to_rest.profile if to_rest else None, on.profile if on else None, duration_s
    )
    return AxisSolution(
        profile,
        ", a wait, ".join(part.status for part in parts) or "at rest",
        sum(part.iterations for part in parts),
    )


def shared_minimum_s(problem: SlewProblem) -> float:
    """The least duration, at most problem.duration_s, in which every axis can slew.

    Exact where no stop is in the way.  Where one is, durations are tried in steps of 1 %.
    Raises InfeasibleSlew.
    """
    states = list(zip(problem.start, problem.end, problem.limits, strict=True))
    shared_s = 0.0
    while shared_s <= problem.duration_s:
        for _ in range(GAP_PASSES):
            longest_s = shared_s
            for axis, (start, end, limits) in enumerate(states):
                next_s = next_duration_s(start, end, limits, longest_s)
                if next_s is None:
                    raise infeasible(problem, axis, problem.duration_s, "duration")
                longest_s = max(longest_s, next_s)
            if longest_s <= shared_s:
                break
            shared_s = longest_s
        if all(can_slew(start, end, limits, shared_s) for start, end, limits in states):
            break
        shared_s *= QUICKEST_SHARE
    if shared_s > problem.duration_s:
        axis = max(range(len(states)), key=lambda k: next_duration_s(*states[k], 0.0) or 0.0)
        raise infeasible(problem, axis, problem.duration_s, "duration")
    return shared_s


def can_slew(start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float) -> bool:
    """Whether an axis can slew in exactly duration_s; the solver is asked only near the stops."""
    found = verdict(start, end, limits, duration_s)
    if found.profile is not None:
        return True
    return found.limit is None and _climb(start, end, limits, duration_s, found) is not None


@lru_cache(maxsize=8)
def graded_ocp(spans: int) -> SplineOcp:
    """Quintics on knots five times denser at the ends, where the jerk must turn quickly.

    Made once per process, as its sibling is.
    """
    x = np.linspace(0.0, 1.0, spans + 1)
    return SplineOcp(_exact_ends(0.2 * x + 0.4 * (1.0 - np.cos(np.pi * x))), degree=5)


@lru_cache(maxsize=8)
def steep_ocp(spans: int) -> SplineOcp:
    """Quintics on knots a hundred times denser at the ends: to brake first, then take time."""
    x = np.linspace(-1.0, 1.0, spans + 1)
    return SplineOcp(
        _exact_ends((1.0 + np.tanh(STEEPNESS * x) / np.tanh(STEEPNESS)) / 2.0), degree=5
    )


def _exact_ends(breakpoints: NDArray[np.float64]) -> NDArray[np.float64]:
    breakpoints[0], breakpoints[-1] = 0.0, 1.0
    return breakpoints


Rung = tuple[Callable[[int], SplineOcp], int, str]
GRADED: Rung = (graded_ocp, SPANS, "optimal")
STEEP: Rung = (steep_ocp, STEEP_SPANS, "optimal on steep knots")
FINER: Rung = (steep_ocp, FINER_SPANS, "optimal on finer steep knots")


def _climb(
    start: AxisState,
    end: AxisState,
    limits: AxisLimits,
    duration_s: float,
    found: AxisVerdict,
    avoid_modes: tuple[StructuralMode, ...] = (),
) -> AxisSolution | None:
    """The first rung whose profile obeys; where a stop turns the axis back, steep knots first.

    Between the stops the graded knots cost under 1e-3 of the least integral.  Against a stop
    the hull of a few coarse spans keeps the axis away from it: steep knots leave a few
    per cent, where graded ones leave tens when the time is long.
    """
    iterations = 0
    thin = braked_ends(start, end, limits, THIN_SHARE)
    if thin and (braked := _braked_motion(start, end, limits, duration_s, avoid_modes)):
        return braked
    free = least_jerk_profile(start, end, duration_s)
    angle = free.evaluate(np.linspace(0.0, duration_s, FREE_SAMPLES))[0]
    stopped = angle.min() < limits.angle_min_rad or angle.max() > limits.angle_max_rad
    for ocp, spans, status in (STEEP, GRADED, FINER) if stopped else (GRADED, STEEP, FINER):
        result = ocp(spans).solve(start, end, limits, duration_s, avoid_modes)
        iterations += result.iterations
        if obeys(result.profile, start, end, limits):
            calm = ", modes spared" if avoid_modes else ""
            return AxisSolution(result.profile, status + calm, iterations)
    braked = None if thin else _braked_motion(start, end, limits, duration_s, avoid_modes)
    if braked is not None:
        return braked._replace(iterations=iterations + braked.iterations)
    if avoid_modes:
        return _climb(start, end, limits, duration_s, found)
    if found.profile is not None:
        return AxisSolution(found.profile, "feasible, not the smoothest", iterations)
    return None


def motion_between(
    start: AxisState,
    end: AxisState,
    limits: AxisLimits,
    duration_s: float,
    avoid_modes: tuple[StructuralMode, ...] = (),
) -> AxisSolution | None:
    """The smoothest motion in exactly duration_s, None where there is none."""
    if duration_s <= 0.0 or not (within(start, limits) and within(end, limits)):
        return None
    found = _motion(start, end, limits, duration_s, avoid_modes)
    return None if isinstance(found, str) else found


def _braked_motion(
    start: AxisState,
    end: AxisState,
    limits: AxisLimits,
    duration_s: float,
    avoid_modes: tuple[StructuralMode, ...] = (),
) -> AxisSolution | None:
    """Braked at the ends where the rate comes near its limit, and the smoothest between.

    A hull that must hold a rate whose peak all but touches the limit leaves no motion at all.
    """
    ends = braked_ends(start, end, limits)
    if ends is None:
        return None
    free_s = duration_s - ends.rows * COMMAND_STEP_S
    solution = motion_between(ends.start, ends.end, limits, free_s, avoid_modes)
    if solution is None:
        return None
    profile = ends.around(solution.profile)
    if not obeys(profile, start, end, limits):
        return None
    return AxisSolution(profile, f"{solution.status}, braked at the ends", solution.iterations)


def _is_quickest(start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float) -> bool:
    quickest = quickest_profile(start, end, limits)
    return quickest is not None and duration_s <= QUICKEST_SHARE * quickest.duration_s
