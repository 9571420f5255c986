"""Baseline slews about the Euler axis, accelerating, coasting, braking.

With `jerk=True` the angle follows the jerk-limited time optimum (Ruckig), else the paper's
bang-coast-bang.  Moving ends are blended in: sigma = (1 - s) sigma_start(t) + s sigma_end(t),
the two ends' motions continued with constant rate and acceleration, s the share of the slew.
"""

import math
import time
from typing import NamedTuple

import numpy as np
from ruckig import InputParameter, Ruckig, Trajectory
from scipy.interpolate import PPoly

from planner.base import effort
from planner.base.arrays import Array
from planner.base.mrp import MrpCurve, MrpMotion
from planner.spacecraft.slews.slew_problem import (
    LIMIT_TOLERANCE,
    AttitudeSlew,
    AttitudeSlewProblem,
    loads,
)

STRETCH = 150.0  # of `effort`: to look at a slew so much longer


class AngleLimits(NamedTuple):
    """The whole angle of a slew and what it may be turned with."""

    angle_rad: float
    rate_rad_s: float
    acceleration_rad_s2: float
    jerk_rad_s3: float


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
    about_axis = AngleLimits(
        max(angle_rad, 1e-4),
        min(limits.rate_rad_s, axis_rate_rad_s) / stretch_factor,
        limits.torque_n_m / inertia_kg_m2 / stretch_factor**2,
        limits.torque_rate_n_m_s / inertia_kg_m2 / stretch_factor**3,
    )
    angle_at, span_s = _ruckig_profile(about_axis) if jerk else _bang_coast_bang(about_axis)
    (s0, v0, a0), (s1, v1, a1) = problem.ends_mrp()

    def mrp_at(t_s: Array) -> MrpMotion:
        t = np.asarray(t_s, dtype=float)
        s, d1, d2, d3 = (x[:, None] for x in _blend(about_axis.angle_rad, angle_at, t))
        x, y = t[:, None], t[:, None] - span_s
        p, p1, p2 = s0 + v0 * x + 0.5 * a0 * x**2, v0 + a0 * x, a0
        r, r1, r2 = s1 + v1 * y + 0.5 * a1 * y**2, v1 + a1 * y, a1
        gap, gap1, gap2 = r - p, r1 - p1, r2 - p2
        return MrpMotion(
            p + s * gap,
            p1 + d1 * gap + s * gap1,
            p2 + d2 * gap + 2.0 * d1 * gap1 + s * gap2,
            d3 * gap + 3.0 * d2 * gap1 + 3.0 * d1 * gap2,
        )

    return mrp_at, span_s


def _ruckig_profile(limits: AngleLimits) -> tuple[PPoly, float]:
    motion = InputParameter(1)
    motion.current_position, motion.target_position = [0.0], [limits.angle_rad]
    motion.max_velocity, motion.max_acceleration = [limits.rate_rad_s], [limits.acceleration_rad_s2]
    motion.max_jerk = [limits.jerk_rad_s3]
    found = Trajectory(1)
    Ruckig(1).calculate(motion, found)
    profile = found.profiles[0][0]
    # Of the ends, of which there is one more than of the pieces, each piece takes its first.
    jerks, accelerations = np.array(profile.j), np.array(profile.a[:-1])
    pieces = [jerks / 6.0, accelerations / 2.0, profile.v[:-1], profile.p[:-1]]
    return PPoly(pieces, np.concatenate([[0.0], np.cumsum(profile.t)])), float(found.duration)


def _bang_coast_bang(limits: AngleLimits) -> tuple[PPoly, float]:
    """The slew with any jerk."""
    angle_rad, acceleration = limits.angle_rad, limits.acceleration_rad_s2
    ramp_s = min(limits.rate_rad_s / acceleration, math.sqrt(angle_rad / acceleration))
    top_rad_s = acceleration * ramp_s
    brake_s = max(angle_rad / top_rad_s, ramp_s)
    ramp_rad = 0.5 * top_rad_s * ramp_s
    pieces = [
        [0.5 * acceleration, 0.0, -0.5 * acceleration],
        [0.0, top_rad_s, top_rad_s],
        [0.0, ramp_rad, angle_rad - ramp_rad],
    ]
    return PPoly(pieces, [0.0, ramp_s, brake_s, brake_s + ramp_s]), brake_s + ramp_s


def _blend(angle_rad: float, angle_at: PPoly, t_s: Array) -> tuple[Array, Array, Array, Array]:
    """Share of the way in sigma, with three derivatives, for the angle p turned of angle_rad.

    s = (tan((p - angle/2)/4) / tan(angle/8) + 1)/2 makes the blend a pure rotation by p.
    """
    p, v, a, j = (angle_at(t_s, order) for order in range(4))
    y = np.tan((p - 0.5 * angle_rad) / 4.0)
    g = 0.5 / math.tan(angle_rad / 8.0)
    y1 = (1.0 + y**2) / 4.0
    y2 = y * y1 / 2.0
    y3 = (y1**2 + y * y2) / 2.0
    return (
        g * y + 0.5,
        g * y1 * v,
        g * (y2 * v**2 + y1 * a),
        g * (y3 * v**3 + 3.0 * y2 * v * a + y1 * j),
    )
