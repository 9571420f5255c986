"""Starts for the solver that lead a body direction around a cone, past either side of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.rotation import Rotation, like_signs
from planner.motion.attitude.ocp import SpanMotion
from planner.motion.attitude.problem import AvoidedCone, BodySlewProblem, depths_rad


@dataclass(frozen=True, kw_only=True)
class AroundOptions:
    """The bow that leads around a cone."""

    clear_rad: float = math.radians(
        3.0
    )  # so far outside, for the solver to begin inside its limits
    step_rad: float = 0.02  # in which the bow is widened
    instants: int = 8  # a span, at which the path is looked at
    earliest: float = 0.2  # of the time: a bow has room on either side


OPTIONS = AroundOptions()


def around_cones(problem: BodySlewProblem, begin: SpanMotion) -> Iterator[SpanMotion]:
    """The path past the cone that it enters deepest, shorter way round first; itself if none."""
    t_s = np.linspace(0.0, begin.duration_s, OPTIONS.instants * len(begin.widths_s) + 1)
    q_xyzw = begin.at(t_s).position
    worst: tuple[float, int, AvoidedCone] | None = None
    for cone in problem.cones:
        depths = depths_rad(cone, q_xyzw, centres_eci(cone, t_s))
        k = int(np.argmax(depths))
        if depths[k] > 0.0 and (worst is None or depths[k] > worst[0]):
            worst = float(depths[k]), k, cone
    if worst is None:
        yield begin
        return
    _, k, cone = worst
    centre_eci = centres_eci(cone, t_s)[k]
    seen_eci = Rotation.from_quat(q_xyzw).apply(cone.direction_body)
    along = seen_eci[min(k + 1, len(t_s) - 1)] - seen_eci[max(k - 1, 0)]
    side = np.cross(seen_eci[k], along)
    side /= max(float(np.linalg.norm(side)), 1e-12)
    shorter = -math.copysign(1.0, float(np.dot(centre_eci - seen_eci[k], side)))
    for sign in (shorter, -shorter):
        axis = np.cross(seen_eci[k], sign * side)
        way_rad = 0.0
        while way_rad < np.pi:
            there = Rotation.from_rotvec(way_rad * axis).apply(seen_eci[k])
            cosine = float(np.clip(there @ centre_eci, -1.0, 1.0))
            if math.acos(cosine) >= cone.half_rad + OPTIONS.clear_rad:
                break
            way_rad += OPTIONS.step_rad
        u = t_s / t_s[-1]
        peak = min(max(float(u[k]), OPTIONS.earliest), 1.0 - OPTIONS.earliest)
        bump = np.sin(np.pi * u ** (math.log(0.5) / math.log(peak))) ** 2
        bow = Rotation.from_rotvec(np.outer(way_rad * bump, axis))
        yield _through(t_s, (bow * Rotation.from_quat(q_xyzw)).as_quat(), begin.widths_s)


def centres_eci(cone: AvoidedCone, t_s: Array) -> Array:
    """The cone's middle at instants (m,) of the slew, unit vectors (m, 3)."""
    rows = np.arange(len(cone.centre_eci)) / ROWS_PER_S
    middle = np.stack([np.interp(t_s, rows, part) for part in cone.centre_eci.T], axis=1)
    return np.asarray(middle / np.linalg.norm(middle, axis=1, keepdims=True))


def _through(t_s: Array, q_eci_from_body_xyzw: Array, widths_s: Array) -> SpanMotion:
    """A motion through attitudes at these instants, by splines."""
    signs = like_signs(q_eci_from_body_xyzw)
    curve = CubicSpline(t_s, q_eci_from_body_xyzw * signs[:, None], bc_type="clamped")
    q, dq = curve(t_s), curve(t_s, 1)
    omega = 2.0 * (q[:, 3:] * dq[:, :3] - dq[:, 3:] * q[:, :3] - np.cross(q[:, :3], dq[:, :3]))
    turning = CubicSpline(t_s, omega)
    nodes_s = np.append(0.0, np.cumsum(widths_s))
    there = curve(nodes_s)
    there /= np.linalg.norm(there, axis=1, keepdims=True)
    alpha = turning(nodes_s, 1)
    jerk = np.diff(alpha, axis=0) / widths_s[:, None]
    return SpanMotion(widths_s, there, turning(nodes_s), alpha, np.stack([jerk, jerk], axis=1))
