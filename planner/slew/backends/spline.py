"""Which cubic does the paper fly, and what does it break? The baseline."""

import math
import time

import numpy as np

from planner.arrays import Array
from planner.commands import ROWS_PER_S
from planner.platforms import AxisLimits
from planner.scenario import SlewOptions
from planner.slew.problem import AxisState, SlewProblem
from planner.slew.solution import AxisProfile, SlewSolution, violations

RATE_SHARE = 2.0 / 3.0  # effective 2 of 3 deg/s, Sumarokov 2016, p. 91
ACCELERATION_SHARE = 0.8  # effective 0.8 of 1 deg/s2, ibid.
KNOTS_PER_LAG = 8  # quintic pieces follow the filter's exponential to 1e-9 of its size
SETTLED_LAGS = 24  # e^-24: then the exponential is below rounding


def solve(problem: SlewProblem, options: SlewOptions) -> SlewSolution:
    """The cubic between both states over the duration, through the first-order filter if asked.

    The objective plays no part, except that "minimum_time" takes the paper's own duration, in
    whole command steps, where the axes are at rest and so can wait for it.
    Limits are not enforced: the paper's method has no means to; what it breaks is in
    `violations`, and `end_error_rad` is what the filter's lag leaves at the end.
    Source: Sumarokov 2016, eq. 12-14 (the printed a0 read as in the tests), filter p. 91,
    low-pass as it must be for a continuous acceleration.
    """
    began_s = time.perf_counter()
    duration_s = problem.duration_s
    at_rest = all(state.at_rest() == state for state in problem.start)
    if problem.objective == "minimum_time" and at_rest:
        rows = math.ceil(paper_duration_s(problem) * ROWS_PER_S)
        duration_s = min(duration_s, max(rows, 1) / ROWS_PER_S)
    lag_s = 0.0
    if options.filter_cutoff_hz is not None:
        lag_s = 1.0 / (2.0 * math.pi * options.filter_cutoff_hz)
    aim_ahead_s = lag_s if options.filter_lag_compensation else 0.0
    profiles = [
        _filtered(start, _continued(end, aim_ahead_s), duration_s, lag_s)
        if lag_s
        else cubic_profile(start, end, duration_s)
        for start, end in zip(problem.start, problem.end, strict=True)
    ]
    broken = [
        violation
        for name, profile, limits in zip(problem.axis_names, profiles, problem.limits, strict=True)
        for violation in violations(name, profile, limits)
    ]
    reached = [float(profile.evaluate(np.array([duration_s]))[0][0]) for profile in profiles]
    return SlewSolution(
        problem=problem,
        backend="spline",
        profiles=tuple(profiles),
        status=("cubic",) * len(profiles),
        iterations=0,
        wall_s=time.perf_counter() - began_s,
        violations=tuple(broken),
        end_error_rad=tuple(
            angle - end.angle_rad for angle, end in zip(reached, problem.end, strict=True)
        ),
        settling_s=lag_s,
    )


def paper_duration_s(problem: SlewProblem) -> float:
    """The paper's estimate of the slew's duration, the longest of the axes.

    Source: Sumarokov 2016, eq. 12-13, with its effective rate and acceleration.
    """
    return max(
        _axis_duration_s(start, end, limits)
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    )


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


def _axis_duration_s(start: AxisState, end: AxisState, limits: AxisLimits) -> float:
    v = RATE_SHARE * limits.rate_max_rad_s
    a = ACCELERATION_SHARE * limits.acceleration_max_rad_s2
    delta = end.angle_rad - start.angle_rad
    towards = math.copysign(v, delta) if delta else 0.0
    return abs(delta) / v + abs(start.rate_rad_s - towards) / a + abs(towards - end.rate_rad_s) / a


def _continued(state: AxisState, ahead_s: float) -> AxisState:
    v, a = state.rate_rad_s, state.acceleration_rad_s2
    return AxisState(
        angle_rad=state.angle_rad + ahead_s * (v + ahead_s * a / 2.0),
        rate_rad_s=v + ahead_s * a,
        acceleration_rad_s2=a,
    )


def _filtered(start: AxisState, aim: AxisState, duration_s: float, lag_s: float) -> AxisProfile:
    """The cubic from where the filter's input stands to the aim, as the filter puts it out.

    The filter has followed the axis at its start rate, so its input leads the axis by
    rate x lag and the output begins at the axis's own angle and rate.  lag y' + y = x is
    solved exactly, a cubic plus an exponential; quintic pieces carry the exponential.
    """
    v0 = start.rate_rad_s
    led = AxisState(angle_rad=start.angle_rad + v0 * lag_s, rate_rad_s=v0)
    x = cubic_profile(led, aim, duration_s).coefficients[0]
    steady = np.array(
        [
            x[0] - lag_s * x[1] + 2.0 * lag_s**2 * x[2] - 6.0 * lag_s**3 * x[3],
            x[1] - 2.0 * lag_s * x[2] + 6.0 * lag_s**2 * x[3],
            x[2] - 3.0 * lag_s * x[3],
            x[3],
        ]
    )
    transient = start.angle_rad - steady[0]
    settled_s = min(SETTLED_LAGS * lag_s, duration_s)
    count = max(math.ceil(settled_s / lag_s * KNOTS_PER_LAG), 1)
    knots = np.linspace(0.0, settled_s, count + 1)
    if settled_s < duration_s:
        knots = np.append(knots, duration_s)
    decay = transient * np.exp(-knots / lag_s)
    if settled_s < duration_s:
        decay[-2:] = 0.0
    coefficients = _quintic_pieces(knots, decay, -decay / lag_s, decay / lag_s**2)
    t = knots[:-1]
    coefficients[:, 0] += steady[0] + t * (steady[1] + t * (steady[2] + t * steady[3]))
    coefficients[:, 1] += steady[1] + t * (2.0 * steady[2] + 3.0 * t * steady[3])
    coefficients[:, 2] += steady[2] + 3.0 * t * steady[3]
    coefficients[:, 3] += steady[3]
    return AxisProfile(breakpoints_s=knots, coefficients=coefficients)


def _quintic_pieces(knots: Array, value: Array, slope: Array, curvature: Array) -> Array:
    """(k, 6) power coefficients of the quintic Hermite pieces through (k + 1) knots."""
    h = np.diff(knots)
    c0, c1, c2 = value[:-1], slope[:-1], curvature[:-1] / 2.0
    d0 = value[1:] - c0 - h * (c1 + h * c2)
    d1 = (slope[1:] - c1 - 2.0 * h * c2) * h
    d2 = (curvature[1:] - 2.0 * c2) * h**2
    c3 = (10.0 * d0 - 4.0 * d1 + d2 / 2.0) / h**3
    c4 = (-15.0 * d0 + 7.0 * d1 - d2) / h**4
    c5 = (6.0 * d0 - 3.0 * d1 + d2 / 2.0) / h**5
    return np.stack([c0, c1, c2, c3, c4, c5], axis=1)
