"""The slew of least squared jerk within all limits, solved axis by axis."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from planner.arrays import Array
from planner.slew.braking import braked_ends
from planner.slew.closed_forms import LONGEST_S, least_jerk_profile, quickest_profile, with_wait
from planner.slew.feasibility import axis_refusal, verdict
from planner.slew.problem import AxisSlew, SlewProblem, within
from planner.slew.solution import AxisProfile, SlewSolution, obeys
from planner.slew.spline_ocp import SplineOcp

SPANS = 48
STEEP_SPANS = 60
FINER_SPANS = 120
STEEPNESS = 2.5
FREE_SAMPLES = 33  # enough to tell which knots to try first
QUICKEST_SHARE = 1.01  # below this multiple of the least time the exact profile is flown
THIN_SHARE = 0.003  # of the rate limit in hand: the hull of any knots fails, so brake first


class AxisSolution(NamedTuple):
    """status says by which method the profile was found."""

    profile: AxisProfile
    status: str
    iterations: int


def optimal_slew(problem: SlewProblem) -> SlewSolution:
    """The slew with the least integral of squared jerk, every limit kept at every instant.

    Up to 1.01 of an axis's least time its exact least-time profile is flown.  Every profile is
    accepted on its own exact extremes, whatever the solver says.  Structural modes to spare
    cost extra, above 1.01 of the least time.  Raises InfeasibleSlew.
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
        iterations=sum(axis.iterations for axis in axes),
        wall_s=time.perf_counter() - began_s,
        violations=(),
        end_error_rad=(0.0,) * len(axes),
    )


def _solve_axis(name: str, slew: AxisSlew) -> AxisSolution:
    """Raises InfeasibleSlew."""
    if slew.duration_s > LONGEST_S:
        return _solve_with_wait(name, slew)
    found = _smoothest(slew)
    if isinstance(found, str):
        raise axis_refusal(name, slew, found)
    return found


def _solve_with_wait(name: str, slew: AxisSlew) -> AxisSolution:
    """Smoothly to rest, a wait, and smoothly on: within rounding as smooth as using the hours.

    The knots of one spline over hours would be too far apart to gather speed between stops.
    """
    rest, part_s = slew.start.at_rest(), LONGEST_S / 2.0
    to_rest = on = None
    if slew.start != rest:
        to_rest = _solve_axis(name, replace(slew, end=rest, duration_s=part_s))
    if slew.end != rest:
        on = _solve_axis(name, replace(slew, start=rest, duration_s=part_s))
    parts = [part for part in (to_rest, on) if part is not None]
    profile = with_wait(
        rest, to_rest.profile if to_rest else None, on.profile if on else None, slew.duration_s
    )
    return AxisSolution(
        profile,
        ", a wait, ".join(part.status for part in parts) or "at rest",
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
    smoothest = least_jerk_profile(start, end, slew.duration_s)
    if not slew.avoid_modes and obeys(smoothest, start, end, limits):
        return AxisSolution(smoothest, "closed form", 0)
    found = verdict(start, end, limits, slew.duration_s)
    if found.limit is not None:
        return found.limit
    if found.profile is not None and _is_quickest(slew):
        return AxisSolution(found.profile, "least time", 0)
    return _by_solver(slew, found.profile) or "angle"


def _is_quickest(slew: AxisSlew) -> bool:
    quickest = quickest_profile(slew.start, slew.end, slew.limits)
    return quickest is not None and slew.duration_s <= QUICKEST_SHARE * quickest.duration_s


@lru_cache(maxsize=8)
def graded_ocp(spans: int) -> SplineOcp:
    """Quintics on knots five times denser at the ends, where the jerk must turn quickly.

    Made once per process, as its sibling is.
    """
    x = np.linspace(0.0, 1.0, spans + 1)
    return _quintic_ocp(0.2 * x + 0.4 * (1.0 - np.cos(np.pi * x)))


@lru_cache(maxsize=8)
def steep_ocp(spans: int) -> SplineOcp:
    """Quintics on knots a hundred times denser at the ends: to brake first, then take time."""
    x = np.linspace(-1.0, 1.0, spans + 1)
    return _quintic_ocp((1.0 + np.tanh(STEEPNESS * x) / np.tanh(STEEPNESS)) / 2.0)


def _quintic_ocp(breakpoints_tau: Array) -> SplineOcp:
    breakpoints_tau[0], breakpoints_tau[-1] = 0.0, 1.0
    return SplineOcp(breakpoints_tau, degree=5)


Knots = tuple[Callable[[int], SplineOcp], int, str]
GRADED: Knots = (graded_ocp, SPANS, "optimal")
STEEP: Knots = (steep_ocp, STEEP_SPANS, "optimal on steep knots")
FINER: Knots = (steep_ocp, FINER_SPANS, "optimal on finer steep knots")


def _by_solver(slew: AxisSlew, feasible: AxisProfile | None) -> AxisSolution | None:
    """On the first knots whose profile obeys; where a stop turns the axis back, steep ones first.

    Between the stops the graded knots cost under 1e-3 of the least integral.  Against a stop
    the hull of a few coarse spans keeps the axis away from it: steep knots leave a few
    per cent, where graded ones leave tens when the time is long.
    feasible: a motion that obeys, taken when none is found.
    """
    start, end, limits = slew.start, slew.end, slew.limits
    iterations = 0
    is_thin = braked_ends(slew, THIN_SHARE) is not None
    if is_thin and (braked := _with_braked_ends(slew)):
        return braked
    free = least_jerk_profile(start, end, slew.duration_s)
    angle = free.evaluate(np.linspace(0.0, slew.duration_s, FREE_SAMPLES))[0]
    meets_stop = angle.min() < limits.angle_min_rad or angle.max() > limits.angle_max_rad
    for ocp, spans, status in (STEEP, GRADED, FINER) if meets_stop else (GRADED, STEEP, FINER):
        result = ocp(spans).solve(slew)
        iterations += result.iterations
        if obeys(result.profile, start, end, limits):
            modes = ", modes spared" if slew.avoid_modes else ""
            return AxisSolution(result.profile, status + modes, iterations)
    braked = None if is_thin else _with_braked_ends(slew)
    if braked is not None:
        return braked._replace(iterations=iterations + braked.iterations)
    if slew.avoid_modes:
        return _by_solver(replace(slew, avoid_modes=()), feasible)
    if feasible is not None:
        return AxisSolution(feasible, "feasible, not the smoothest", iterations)
    return None


def _with_braked_ends(slew: AxisSlew) -> AxisSolution | None:
    """Braked at the ends where the rate comes near its limit, and the smoothest between.

    A hull that must hold a rate whose peak all but touches the limit leaves no motion at all.
    """
    ends = braked_ends(slew)
    if ends is None:
        return None
    free = smoothest_motion(ends.free)
    if free is None:
        return None
    profile = ends.around(free.profile)
    if not obeys(profile, slew.start, slew.end, slew.limits):
        return None
    return AxisSolution(profile, f"{free.status}, braked at the ends", free.iterations)
