"""The paper's cubic slew and what it breaks: the baseline."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.commands import ROWS_PER_S
from planner.motion.slew.closed_forms import quintic_coefficients
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.motion.slew.solution import AxisProfile, SlewSolution, violations
from planner.world.platforms import AxisLimits
from planner.world.scenario import SlewOptions


@dataclass(frozen=True, kw_only=True)
class PaperSplineOptions:
    """The paper's spline, and how closely its filter is followed."""

    rate_share: float = 2.0 / 3.0  # effective 2 of 3 deg/s, Sumarokov 2016, p. 91
    acceleration_share: float = 0.8  # effective 0.8 of 1 deg/s2, ibid.
    knots_per_lag: int = 8  # quintic pieces follow the filter's exponential to 1e-9 of its size
    settled_lags: int = 24  # e^-24: then the exponential is below rounding


OPTIONS = PaperSplineOptions()


def paper_slew(problem: SlewProblem, options: SlewOptions) -> SlewSolution:
    """The cubic between both states over the duration, through the first-order filter if asked.

    Limits are not enforced: the paper's method has no means to; what it breaks is in
    `violations`, and `end_error_rad` is what the filter's lag leaves at the end.
    Source: Sumarokov 2016, eq. 12-14 (the printed a0 read as in the tests), filter p. 91,
    low-pass as it must be for a continuous acceleration.
    """
    began_s = time.perf_counter()
    profiles = paper_profiles(problem.start, problem.end, problem.duration_s, options)
    broken = [
        violation
        for name, profile, limits in zip(problem.axis_names, profiles, problem.limits, strict=True)
        for violation in violations(name, profile, limits)
    ]
    last_rad = [float(profile.end_values[1, 0]) for profile in profiles]
    return SlewSolution(
        problem=problem,
        profiles=profiles,
        status=("cubic",) * len(profiles),
        runs=(None,) * len(profiles),
        iterations=0,
        wall_s=time.perf_counter() - began_s,
        violations=tuple(broken),
        end_error_rad=tuple(
            angle - end.angle_rad for angle, end in zip(last_rad, problem.end, strict=True)
        ),
        settling_s=filter_lag_s(options),
    )


def paper_profiles(
    start: Sequence[AxisState], end: Sequence[AxisState], duration_s: float, options: SlewOptions
) -> tuple[AxisProfile, ...]:
    """The motion of each axis, as `paper_slew` says."""
    lag_s = filter_lag_s(options)
    if not lag_s:
        return tuple(cubic_profile(a, b, duration_s) for a, b in zip(start, end, strict=True))
    aim_ahead_s = lag_s if options.filter_lag_compensation else 0.0
    return tuple(
        _filter_cubic(a, _extrapolate_state(b, aim_ahead_s), duration_s, lag_s)
        for a, b in zip(start, end, strict=True)
    )


def filter_lag_s(options: SlewOptions) -> float:
    """The time constant of the filter; 0 without one."""
    if options.filter_cutoff_hz is None:
        return 0.0
    return 1.0 / (2.0 * math.pi * options.filter_cutoff_hz)


def in_paper_time(problem: SlewProblem) -> SlewProblem:
    """The problem with the paper's own duration, in whole command steps, where that is less.

    The problem itself where an axis moves at the start and so can't wait for it.
    """
    if any(state.at_rest() != state for state in problem.start):
        return problem
    rows = math.ceil(paper_duration_s(problem) * ROWS_PER_S)
    return replace(problem, duration_s=min(problem.duration_s, max(rows, 1) / ROWS_PER_S))


def paper_duration_s(problem: SlewProblem) -> float:
    """The paper's estimate of the slew's duration, the longest of the axes.

    Source: Sumarokov 2016, eq. 12-13, with its effective rate and acceleration.
    """
    return max(
        _axis_duration_s(start, end, limits)
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    )


def _axis_duration_s(start: AxisState, end: AxisState, limits: AxisLimits) -> float:
    v = OPTIONS.rate_share * limits.rate_max_rad_s
    a = OPTIONS.acceleration_share * limits.acceleration_max_rad_s2
    delta = end.angle_rad - start.angle_rad
    towards = math.copysign(v, delta) if delta else 0.0
    return abs(delta) / v + abs(start.rate_rad_s - towards) / a + abs(towards - end.rate_rad_s) / a


def cubic_profile(start: AxisState, end: AxisState, duration_s: float) -> AxisProfile:
    """The cubic with the angles and rates of both ends; accelerations jump there.

    Source: Sumarokov 2016, eq. 14.
    """
    T = duration_s
    delta = end.angle_rad - start.angle_rad
    a0 = (T * (end.rate_rad_s + start.rate_rad_s) - 2.0 * delta) / T**3
    a1 = (3.0 * (delta - start.rate_rad_s * T) - T * (end.rate_rad_s - start.rate_rad_s)) / T**2
    return AxisProfile(
        breakpoints_s=np.array([0.0, T]),
        coefficients=np.array([[start.angle_rad, start.rate_rad_s, a1, a0]]),
    )


def _extrapolate_state(state: AxisState, ahead_s: float) -> AxisState:
    v, a = state.rate_rad_s, state.acceleration_rad_s2
    return AxisState(
        angle_rad=state.angle_rad + ahead_s * (v + ahead_s * a / 2.0),
        rate_rad_s=v + ahead_s * a,
        acceleration_rad_s2=a,
    )


def _filter_cubic(start: AxisState, aim: AxisState, duration_s: float, lag_s: float) -> AxisProfile:
    """The cubic from where the filter's input stands to the aim, as the filter puts it out.

    The filter has followed the axis at its start rate, so its input leads the axis by
    rate x lag and the output begins at the axis's own angle and rate.  lag y' + y = x is
    solved exactly, a cubic plus an exponential; quintic pieces carry the exponential.
    """
    v0 = start.rate_rad_s
    leading = AxisState(angle_rad=start.angle_rad + v0 * lag_s, rate_rad_s=v0)
    x = cubic_profile(leading, aim, duration_s).coefficients[0]
    steady = np.array(
        [
            x[0] - lag_s * x[1] + 2.0 * lag_s**2 * x[2] - 6.0 * lag_s**3 * x[3],
            x[1] - 2.0 * lag_s * x[2] + 6.0 * lag_s**2 * x[3],
            x[2] - 3.0 * lag_s * x[3],
            x[3],
        ]
    )
    transient = start.angle_rad - steady[0]
    settled_s = min(OPTIONS.settled_lags * lag_s, duration_s)
    count = max(math.ceil(settled_s / lag_s * OPTIONS.knots_per_lag), 1)
    knots_s = np.linspace(0.0, settled_s, count + 1)
    if settled_s < duration_s:
        knots_s = np.append(knots_s, duration_s)
    decay = transient * np.exp(-knots_s / lag_s)
    if settled_s < duration_s:
        decay[-2:] = 0.0
    motion = np.stack([decay, -decay / lag_s, decay / lag_s**2])
    pieces = quintic_coefficients(np.diff(knots_s), tuple(motion[:, :-1]), tuple(motion[:, 1:]))
    coefficients = np.stack(pieces, axis=1)
    t = knots_s[:-1]
    coefficients[:, 0] += steady[0] + t * (steady[1] + t * (steady[2] + t * steady[3]))
    coefficients[:, 1] += steady[1] + t * (2.0 * steady[2] + 3.0 * t * steady[3])
    coefficients[:, 2] += steady[2] + 3.0 * t * steady[3]
    coefficients[:, 3] += steady[3]
    return AxisProfile(breakpoints_s=knots_s, coefficients=coefficients)
