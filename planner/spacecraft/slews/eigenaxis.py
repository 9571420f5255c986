"""Baseline slews about the Euler axis, accelerating, coasting, braking.

With `jerk=True` the angle follows the jerk-limited time optimum (Ruckig), else the paper's
bang-coast-bang.  Moving ends are blended in: sigma = (1 - s) sigma_start(t) + s sigma_end(t),
the two ends' motions continued with constant rate and acceleration, s the share of the slew.
"""

import math
import time

import numpy as np
from scipy.interpolate import PPoly

from planner.base import effort
from planner.base.mrp import MrpCurve
from planner.motion.attitude.eigenaxis import blended, quickest_angle
from planner.spacecraft.slews.slew_problem import (
    LIMIT_TOLERANCE,
    AttitudeSlew,
    AttitudeSlewProblem,
    loads,
)

STRETCH = 150.0  # of `effort`: to look at a slew so much longer


def eigenaxis_slew(
    problem: AttitudeSlewProblem, duration_s: float | None = None, *, jerk: bool = True
) -> AttitudeSlew:
    """The quickest slew of this kind, or the one that takes duration_s.

    Rest-to-rest it is the exact optimum about the Euler axis; with moving ends time is
    stretched until every limit holds (never shorter than needed, 0.2 % accuracy).
    """
    begun = time.perf_counter()
    stretch_factor = 1.0
    mrp_at, span_s = _sigma_curve(problem, stretch_factor, jerk)
    if duration_s is not None:
        mrp_at, span_s = _sigma_curve(problem, duration_s / span_s, jerk)
    else:
        for _ in range(80):
            effort.charge(STRETCH)
            over = loads(problem, mrp_at, span_s).share_of(problem.limits, torque_rate=jerk)
            if over <= 1.0 + LIMIT_TOLERANCE:
                break
            stretch_factor *= min(max(over**0.5, 1.002), 1.3)
            mrp_at, span_s = _sigma_curve(problem, stretch_factor, jerk)
    return AttitudeSlew(
        q_middle_from_eci=problem.q_middle_from_eci,
        mrp_at=mrp_at,
        duration_s=span_s,
        method="eigenaxis",
        status="closed form",
        solve_s=time.perf_counter() - begun,
        loads=loads(problem, mrp_at, span_s),
    )


def _sigma_curve(
    problem: AttitudeSlewProblem, stretch_factor: float, jerk: bool
) -> tuple[MrpCurve, float]:
    """sigma by time, and the duration."""
    angle_rad = problem.angle_rad()
    rotation_rad = problem.q_start_from_end.as_rotvec()
    axis_body = rotation_rad / angle_rad if angle_rad > 1e-9 else np.array([0.0, 0.0, 1.0])
    limits = problem.limits
    inertia_kg_m2 = float(np.linalg.norm(problem.inertia_kg_m2 * axis_body))
    axis_rate_rad_s = limits.rate_axis_rad_s / float(np.max(np.abs(axis_body)))
    about_axis = (
        max(angle_rad, 1e-4),
        min(limits.rate_rad_s, axis_rate_rad_s) / stretch_factor,
        limits.torque_n_m / inertia_kg_m2 / stretch_factor**2,
    )
    jerk_rad_s3 = limits.torque_rate_n_m_s / inertia_kg_m2 / stretch_factor**3
    angle_at = quickest_angle(*about_axis, jerk_rad_s3) if jerk else _bang_coast_bang(*about_axis)
    return blended(*problem.ends_mrp(), angle_at, about_axis[0]), float(angle_at.x[-1])


def _bang_coast_bang(angle_rad: float, rate_rad_s: float, acceleration_rad_s2: float) -> PPoly:
    """The slew with any jerk."""
    ramp_s = min(rate_rad_s / acceleration_rad_s2, math.sqrt(angle_rad / acceleration_rad_s2))
    top_rad_s = acceleration_rad_s2 * ramp_s
    brake_s = max(angle_rad / top_rad_s, ramp_s)
    ramp_rad = 0.5 * top_rad_s * ramp_s
    pieces = [
        [0.5 * acceleration_rad_s2, 0.0, -0.5 * acceleration_rad_s2],
        [0.0, top_rad_s, top_rad_s],
        [0.0, ramp_rad, angle_rad - ramp_rad],
    ]
    return PPoly(pieces, [0.0, ramp_s, brake_s, brake_s + ramp_s])
