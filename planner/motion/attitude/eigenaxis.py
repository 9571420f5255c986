"""Baseline slews about the Euler axis, jerk-limited, with ends that move blended in.

sigma = (1 - s) sigma_start(t) + s sigma_end(t) in Rodrigues parameters from the attitude halfway,
the two ends' motions continued with constant rate and acceleration, s the share of the slew.
Between ends at rest it is the exact optimum about the axis.
"""

import math
from dataclasses import dataclass

import numpy as np
from ruckig import InputParameter, Ruckig, Trajectory
from scipy.interpolate import PPoly

from planner.base import effort
from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.mrp import BodyMotion, MrpCurve, MrpMotion, MrpState, body_motion, mrp_state
from planner.base.rotation import Rotation, continuous
from planner.motion.attitude.ocp import SpanMotion
from planner.motion.attitude.problem import BodySlewProblem


@dataclass(frozen=True, kw_only=True)
class EigenaxisOptions:
    """How the quickest blend that keeps the limits is looked for."""

    tolerance: float = 1e-6  # of the limits, on the samples
    samples: int = 400  # of a slew: its jerk's steps are 7, its bulges some dozens long
    attempts: int = 60
    longest: float = 1.3  # times as long at once, 1.002 at least: 0.2 % accuracy
    shortest: float = 1.002
    runaway: float = 3.0  # ends that are continued for longer swing a blend too far
    least_rad: float = 1e-4  # turned at least, so that there is a profile to blend by
    look: float = 150.0  # of `effort`: to look at a slew so much longer


OPTIONS = EigenaxisOptions()


def quickest_angle(
    angle_rad: float, rate_rad_s: float, acceleration_rad_s2: float, jerk_rad_s3: float
) -> PPoly:
    """The angle by time, from rest to rest, of the least time within these limits."""
    motion = InputParameter(1)
    motion.current_position, motion.target_position = [0.0], [angle_rad]
    motion.max_velocity, motion.max_acceleration = [rate_rad_s], [acceleration_rad_s2]
    motion.max_jerk = [jerk_rad_s3]
    found = Trajectory(1)
    Ruckig(1).calculate(motion, found)
    profile = found.profiles[0][0]
    # Of the ends, of which there is one more than of the pieces, each piece takes its first.
    jerks, accelerations = np.array(profile.j), np.array(profile.a[:-1])
    pieces = [jerks / 6.0, accelerations / 2.0, profile.v[:-1], profile.p[:-1]]
    return PPoly(pieces, np.concatenate([[0.0], np.cumsum(profile.t)]))


def smoothest_angle(angle_rad: float, duration_s: float) -> PPoly:
    """The angle by time, from rest to rest, of the least squared jerk without limits."""
    powers = angle_rad * np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])
    return PPoly((powers / duration_s ** np.arange(5, -1, -1))[:, None], [0.0, duration_s])


def blended(start: MrpState, end: MrpState, angle_at: PPoly, angle_rad: float) -> MrpCurve:
    """sigma by time, of a slew by angle_rad as angle_at turns it, the ends' motions blended in."""
    span_s = float(angle_at.x[-1])
    (s0, v0, a0), (s1, v1, a1) = start, end

    def mrp_at(t_s: Array) -> MrpMotion:
        t = np.asarray(t_s, dtype=float)
        s, d1, d2, d3 = (x[:, None] for x in _share_of_way(angle_rad, angle_at, t))
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

    return mrp_at


def _share_of_way(
    angle_rad: float, angle_at: PPoly, t_s: Array
) -> tuple[Array, Array, Array, Array]:
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


@dataclass(frozen=True, eq=False, kw_only=True)
class EigenaxisSlew:
    """q_middle: `q_eci_from_body` halfway, from which sigma counts.  angle_at: without the ends'
    motions."""

    q_middle: Rotation
    mrp_at: MrpCurve
    angle_at: PPoly

    @property
    def duration_s(self) -> float:
        return float(self.angle_at.x[-1])

    def motion(self, t_s: Array) -> tuple[Array, BodyMotion]:
        """q_eci_from_body_xyzw (n, 4), neighbours of like sign, and body rates at instants (n,)."""
        curve = self.mrp_at(t_s)
        return continuous(self.q_middle * Rotation.from_mrp(curve.mrp)), body_motion(curve)

    def on_spans(self, widths_s: Array) -> SpanMotion:
        """The motion where spans begin and end, to begin an OCP at."""
        t_s = np.append(0.0, np.cumsum(widths_s)) * (self.duration_s / float(widths_s.sum()))
        q, body = self.motion(t_s)
        jerk = self.motion((t_s[1:] + t_s[:-1]) / 2.0)[1].jerk_body_rad_s3
        return SpanMotion(widths_s, q, *body[:2], np.stack([jerk, jerk], axis=1))


def eigenaxis_slew(
    problem: BodySlewProblem, row: int, *, duration_s: float | None = None, smooth: bool = False
) -> EigenaxisSlew:
    """The blend onto one row of the goal; its duration the least about the axis, or the given one.

    smooth: of least jerk instead of least time about the axis.
    """
    there = problem.arriving_at(row)
    q_start = Rotation.from_quat(problem.start.position[0])
    q_end = Rotation.from_quat(there.goal.position[0])
    turn = (q_start.inv() * q_end).as_rotvec()
    angle_rad = max(float(np.linalg.norm(turn)), OPTIONS.least_rad)
    axis_body = turn / angle_rad
    about = np.array(problem.limits.about(axis_body / max(float(np.linalg.norm(axis_body)), 1e-12)))
    angle_at = quickest_angle(angle_rad, *about)
    if duration_s is not None and smooth:
        angle_at = smoothest_angle(angle_rad, duration_s)
    elif duration_s is not None:
        stretch = duration_s / float(angle_at.x[-1])
        scaled = [
            piece / stretch**power for piece, power in zip(angle_at.c, (3, 2, 1, 0), strict=True)
        ]
        angle_at = PPoly(np.array(scaled), angle_at.x * stretch)
    q_middle = q_start * Rotation.from_rotvec(0.5 * turn)
    ends = []
    for q, motion in ((q_start, problem.start), (q_end, there.goal)):
        mrp = np.asarray((q_middle.inv() * q).as_mrp())
        ends.append(mrp_state(mrp, motion.rate_rad_s[0], motion.acceleration_rad_s2[0]))
    return EigenaxisSlew(
        q_middle=q_middle, mrp_at=blended(ends[0], ends[1], angle_at, angle_rad), angle_at=angle_at
    )


def over_limits(problem: BodySlewProblem, slew: EigenaxisSlew) -> Array:
    """The most used shares of rate, acceleration and jerk, on samples, (3,)."""
    t_s = np.linspace(0.0, slew.duration_s, OPTIONS.samples)
    return np.asarray(np.max(problem.limits.shares(slew.motion(t_s)[1]), axis=0))


def quickest_eigenaxis(problem: BodySlewProblem) -> tuple[EigenaxisSlew, int, bool]:
    """The quickest blend found, the row of the goal it is for, and whether it keeps the limits.

    Its duration is that of the row or less, and cones are left aside.
    """
    first, last = problem.first_arrival_row, problem.last_arrival_row
    row, duration_s = first, None
    at_rest_s = eigenaxis_slew(problem, first).duration_s
    for _ in range(OPTIONS.attempts):
        effort.charge(OPTIONS.look)
        slew = eigenaxis_slew(problem, row, duration_s=duration_s)
        needed = min(max(math.ceil(slew.duration_s * ROWS_PER_S - 1e-6), first), last)
        if needed != row:  # the goal has moved on: its attitude at the arrival is another
            row = needed
            slew = eigenaxis_slew(
                problem,
                row,
                duration_s=max(slew.duration_s, row / ROWS_PER_S) if duration_s else None,
            )
        used = over_limits(problem, slew)
        most = float(np.max(used ** (1.0 / np.arange(1, 4))))
        keeps = bool(np.all(used <= 1.0 + OPTIONS.tolerance))
        if keeps or slew.duration_s > OPTIONS.runaway * at_rest_s + last / ROWS_PER_S:
            return slew, row, keeps
        duration_s = slew.duration_s * min(max(most, OPTIONS.shortest), OPTIONS.longest)
    return slew, row, False
