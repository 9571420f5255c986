"""How does the baseline turn?  About the Euler axis, accelerating, coasting, braking.

With `jerk=True` the angle follows the jerk-limited time optimum (Ruckig), else the paper's
bang-coast-bang.  Moving ends are blended in: sigma = (1 - s) sigma_start(t) + s sigma_end(t),
the two ends' motions continued with constant rate and acceleration, s the share of the turn.
"""

import math
import time
from collections.abc import Callable

import numpy as np
from ruckig import InputParameter, Ruckig, Trajectory

from planner import effort
from planner.arrays import Array
from planner.spacecraft.turns.turn_problem import LIMIT_TOLERANCE, Turn, TurnProblem, loads

Curve = Callable[[Array], tuple[Array, Array, Array, Array]]
STRETCH = 150.0  # of `planner.effort`: to look at a turn so much longer


def eigenaxis_turn(
    problem: TurnProblem, duration_s: float | None = None, *, jerk: bool = True
) -> Turn:
    """The quickest turn of this kind, or the one that takes duration_s.

    Rest-to-rest it is the exact optimum about the Euler axis; with moving ends time is
    stretched until every limit holds (never shorter than needed, 0.2 % accuracy).
    """
    begun = time.perf_counter()
    stretch = 1.0
    curve, span_s = _curve(problem, stretch, jerk)
    if duration_s is not None:
        stretch *= duration_s / span_s
        curve, span_s = _curve(problem, stretch, jerk)
    else:
        for _ in range(80):
            effort.spend(STRETCH)
            over = _overload(problem, curve, span_s, jerk)
            if over <= 1.0 + LIMIT_TOLERANCE:
                break
            stretch *= min(max(over**0.5, 1.002), 1.3)
            curve, span_s = _curve(problem, stretch, jerk)
    return Turn(
        middle=problem.middle(),
        sigma=curve,
        duration_s=span_s,
        method="eigenaxis",
        status="closed form",
        solve_s=time.perf_counter() - begun,
        loads=loads(problem, curve, span_s),
    )


def _overload(problem: TurnProblem, curve: Curve, span_s: float, jerk: bool) -> float:
    found = loads(problem, curve, span_s)
    if jerk:
        return found.share_of(problem.limits)
    limits = problem.limits
    return max(
        found.rate_rad_s / limits.rate_rad_s,
        float(np.max(found.rate_axis_rad_s)) / limits.rate_axis_rad_s,
        found.torque_n_m / limits.torque_n_m,
        found.momentum_n_m_s / limits.momentum_sphere_n_m_s,
    )


def _curve(problem: TurnProblem, stretch: float, jerk: bool) -> tuple[Curve, float]:
    angle = problem.angle_rad()
    across = (problem.start.attitude.inv() * problem.end.attitude).as_rotvec()
    axis = across / angle if angle > 1e-9 else np.array([0.0, 0.0, 1.0])
    limits = problem.limits
    moved = float(np.linalg.norm(problem.inertia_kg_m2 * axis))
    rate = min(limits.rate_rad_s, limits.rate_axis_rad_s / float(np.max(np.abs(axis)))) / stretch
    acceleration = limits.torque_n_m / moved / stretch**2
    if jerk:
        share, span_s = _ruckig(
            max(angle, 1e-4), rate, acceleration, limits.torque_rate_n_m_s / moved / stretch**3
        )
    else:
        share, span_s = _bang_coast_bang(max(angle, 1e-4), rate, acceleration)
    s0, v0, a0, s1, v1, a1 = problem.ends_mrp()

    def sigma(t_s: Array) -> tuple[Array, Array, Array, Array]:
        t = np.asarray(t_s, dtype=float)
        s, d1, d2, d3 = (x[:, None] for x in share(t))
        x, y = t[:, None], t[:, None] - span_s
        p, p1, p2 = s0 + v0 * x + 0.5 * a0 * x**2, v0 + a0 * x, a0
        r, r1, r2 = s1 + v1 * y + 0.5 * a1 * y**2, v1 + a1 * y, a1
        gap, gap1, gap2 = r - p, r1 - p1, r2 - p2
        return (
            p + s * gap,
            p1 + d1 * gap + s * gap1,
            p2 + d2 * gap + 2.0 * d1 * gap1 + s * gap2,
            d3 * gap + 3.0 * d2 * gap1 + 3.0 * d1 * gap2,
        )

    return sigma, span_s


Share = Callable[[Array], tuple[Array, Array, Array, Array]]


def _ruckig(angle: float, rate: float, acceleration: float, jerk: float) -> tuple[Share, float]:
    asked = InputParameter(1)
    asked.current_position, asked.target_position = [0.0], [angle]
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = [rate], [acceleration], [jerk]
    found = Trajectory(1)
    Ruckig(1).calculate(asked, found)
    profile = found.profiles[0][0]
    durations = np.array(profile.t)
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    jerks, accelerations = np.array(profile.j), np.array(profile.a)
    rates, angles = np.array(profile.v), np.array(profile.p)

    def share(t: Array) -> tuple[Array, Array, Array, Array]:
        k = np.clip(np.searchsorted(starts[1:], t, side="right"), 0, 6)
        u = t - starts[k]
        j, a, v, p = jerks[k], accelerations[k], rates[k], angles[k]
        return _in_sigma(
            angle,
            p + u * (v + u * (a / 2.0 + u * j / 6.0)),
            v + u * (a + u * j / 2.0),
            a + u * j,
            j,
        )

    return share, float(found.duration)


def _bang_coast_bang(angle: float, rate: float, acceleration: float) -> tuple[Share, float]:
    ramp = min(rate / acceleration, math.sqrt(angle / acceleration))
    top = acceleration * ramp
    span_s = angle / top + ramp

    def share(t: Array) -> tuple[Array, Array, Array, Array]:
        left = span_s - t
        p = np.where(
            t < ramp,
            0.5 * acceleration * t**2,
            np.where(left < ramp, angle - 0.5 * acceleration * left**2, top * (t - 0.5 * ramp)),
        )
        v = np.minimum(top, acceleration * np.minimum(t, left))
        a = np.where(t < ramp, acceleration, np.where(left <= ramp, -acceleration, 0.0))
        return _in_sigma(angle, p, v, a, np.zeros_like(t))

    return share, span_s


def _in_sigma(
    angle: float, p: Array, v: Array, a: Array, j: Array
) -> tuple[Array, Array, Array, Array]:
    """Share of the way in sigma, with derivatives, for the angle p(t) turned of `angle`.

    s = (tan((p - angle/2)/4) / tan(angle/8) + 1)/2 makes the blend a pure rotation by p.
    """
    y = np.tan((p - 0.5 * angle) / 4.0)
    g = 0.5 / math.tan(angle / 8.0)
    y1 = (1.0 + y**2) / 4.0
    y2 = y * y1 / 2.0
    y3 = (y1**2 + y * y2) / 2.0
    return (
        g * y + 0.5,
        g * y1 * v,
        g * (y2 * v**2 + y1 * a),
        g * (y3 * v**3 + 3.0 * y2 * v * a + y1 * j),
    )
