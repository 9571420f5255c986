"""A platform's angles, stops and masks, compiled, for one direction at a time."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.compiled import compiled, inlined, lean
from planner.base.vectors import (
    Vector,
    cross,
    dot,
    norm,
    plus,
    scaled,
    vector_of,
    wrapped,
)
from planner.world.platforms import TwoAxisPlatform
from planner.world.platforms.polygon_kernel import nearest_side

Pair = tuple[float, float]
Arc = tuple[float, float]
"""Sine and cosine of an angle, times any length."""


class Reach(NamedTuple):
    """A platform: its axes and stops, what they can do, and its masks.

    outer, inner, zero: unit vectors.  normal: outer x inner; square_sine, cosine, along_cosine:
    what else of them never changes.  limits: by axis rate, acceleration and jerk.
    side_parameters: of all masks (m, 15): those of their polygons, margin and number, in order.
    """

    outer: Vector
    inner: Vector
    zero: Vector
    normal: Vector
    square_sine: float
    cosine: float
    along_cosine: float
    low: Pair
    high: Pair
    limits: tuple[Vector, Vector]
    side_parameters: Array


@lru_cache(maxsize=8)
def reach_of(platform: TwoAxisPlatform) -> Reach:
    """The platform as compiled code takes it."""
    outer, inner = platform.axes_platform
    zero = np.array(platform.zero_direction_platform)
    zero /= np.linalg.norm(zero)
    normal = np.cross(outer, inner)
    sides = []
    for number, mask in enumerate(platform.masks):
        side = mask.polygon.side_parameters
        sides.append(np.hstack([side, np.tile([mask.margin_rad, number], (len(side), 1))]))
    low, high = (
        tuple(float(getattr(axis, name)) for axis in platform.axis_limits)
        for name in ("angle_min_rad", "angle_max_rad")
    )
    limits = [
        (axis.rate_max_rad_s, axis.acceleration_max_rad_s2, axis.jerk_max_rad_s3)
        for axis in platform.axis_limits
    ]
    return Reach(
        outer=_as_vector(outer),
        inner=_as_vector(inner),
        zero=_as_vector(zero),
        normal=_as_vector(normal),
        square_sine=float(normal @ normal),
        cosine=float(outer @ inner),
        along_cosine=float(inner @ zero),
        low=(low[0], low[1]),
        high=(high[0], high[1]),
        limits=(limits[0], limits[1]),
        side_parameters=np.concatenate(sides) if sides else np.empty((0, 15)),
    )


def _as_vector(axis_platform: Array) -> Vector:
    x, y, z = axis_platform.tolist()
    return x, y, z


@inlined
def _about(axis: Vector, start: Vector, end: Vector) -> Arc:
    return dot(cross(start, end), axis), dot(start, end) - dot(start, axis) * dot(end, axis)


@inlined
def turn_between(one: Arc, other: Arc) -> float:
    """From one angle to another, in [-pi, pi]; of a few degrees by the series of the arctangent."""
    sine, cosine = other[0] * one[1] - other[1] * one[0], other[1] * one[1] + other[0] * one[0]
    slope = sine / cosine
    square = slope * slope
    if not (square < 0.0025 and cosine > 0.0):  # the next term is below 2e-17 of the angle
        return math.atan2(sine, cosine)
    tail = 1.0 / 7.0 - square * (1.0 / 9.0 - square * (1.0 / 11.0 - square / 13.0))
    return slope * (1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square * tail)))


@inlined
def arcs_at(g: Reach, los: Vector, sign: float) -> tuple[Arc, Arc]:
    """The pair of angles that has the inner axis on one side; sign: 1 or -1."""
    along = dot(los, g.outer)
    a = (along - g.cosine * g.along_cosine) / g.square_sine
    b = (g.along_cosine - g.cosine * along) / g.square_sine
    off = math.sqrt((1.0 - a * a - b * b - 2.0 * a * b * g.cosine) / g.square_sine)
    turned_zero = plus(plus(scaled(a, g.outer), b, g.inner), sign * off, g.normal)
    return _about(g.outer, turned_zero, los), _about(g.inner, g.zero, turned_zero)


@inlined
def pair_at(g: Reach, los: Vector, sign: float) -> Pair:
    """The same in radians."""
    outer, inner = arcs_at(g, los, sign)
    return math.atan2(outer[0], outer[1]), math.atan2(inner[0], inner[1])


@lean
def axes_at(g: Reach, los: Vector) -> tuple[Pair, Pair]:
    """Both pairs of angles, as `planner.motion.pointing.angles.axis_angles` tells them."""
    return pair_at(g, los, 1.0), pair_at(g, los, -1.0)


@compiled
def axes_each(g: Reach, los_platform: Array) -> Array:
    """The same for directions (n, 3): by branch, direction and axis, (2, n, 2)."""
    angle_rad = np.empty((2, len(los_platform), 2))
    for k in range(len(los_platform)):
        one, two = axes_at(g, vector_of(los_platform, k, 0))
        for axis in range(2):
            angle_rad[0, k, axis], angle_rad[1, k, axis] = one[axis], two[axis]
    return angle_rad


@inlined
def off_stop(g: Reach, axis: int, angle_rad: float) -> float:
    """From the nearer stop, moved by whole turns to mid-travel; negative beyond."""
    middle = 0.5 * (g.low[axis] + g.high[axis])
    return 0.5 * (g.high[axis] - g.low[axis]) - abs(wrapped(angle_rad - middle))


@inlined
def off_stops(g: Reach, pair: Pair) -> float:
    """From the nearest stop of both axes, and far beyond where unreachable."""
    margin = min(off_stop(g, 0, pair[0]), off_stop(g, 1, pair[1]))
    return margin if margin == margin and pair[1] == pair[1] else -math.pi


@inlined
def turned(axis: Vector, angle_rad: float, v: Vector) -> Vector:
    """Rodrigues' formula."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return plus(plus(scaled(c, v), s, cross(axis, v)), (1.0 - c) * dot(v, axis), axis)


@lean
def off_masks(g: Reach, los: Vector) -> float:
    """How far off the nearest mask's margin."""
    sides, nearest, first = g.side_parameters, math.inf, 0
    while first < len(sides):
        last = first + 1
        while last < len(sides) and sides[last, 14] == sides[first, 14]:
            last += 1
        depth = nearest_side(sides, first, last, los)[0]
        nearest = min(nearest, -depth - sides[first, 13])
        first = last
    return nearest


@inlined
def braking(rate_rad_s: float, acceleration_rad_s2: float, limit: Vector) -> float:
    """How far an axis still moves that speeds up and is braked as hard as rows of a table let it:
    that takes a row more of motion at most.

    Source: Biagiotti, Melchiorri 2008, "Trajectory Planning for Automatic Machines", 3.4.
    """
    brake, jerk = limit[1], limit[2]
    ramp_s = acceleration_rad_s2 / jerk
    peak = rate_rad_s + 0.5 * acceleration_rad_s2 * ramp_s
    ramp = ramp_s * (rate_rad_s + acceleration_rad_s2 * ramp_s / 3.0)
    brake_s = 2.0 * math.sqrt(peak / jerk)
    if peak >= brake**2 / jerk:
        brake_s = peak / brake + brake / jerk
    return ramp + peak * (0.5 * brake_s + 1.0 / ROWS_PER_S)


@inlined
def off_plane(g: Reach, los: Vector) -> float:
    """Greatest where the line of sight is nearest to the plane of the axes: less its sine."""
    sine, cosine = arcs_at(g, los, 1.0)[0]
    normal = plus(scaled(cosine, g.normal), sine, cross(g.outer, g.normal))
    value = -abs(dot(los, normal)) / norm(normal)
    return value if value == value else 0.0


@lean
def axis_rates(g: Reach, angle_rad: float, los: Vector, rate_rad_s: Vector) -> tuple[float, float]:
    """As `planner.motion.pointing.angles.axis_motion`."""
    inner = turned(g.outer, angle_rad, g.inner)
    determinant, radial = dot(los, cross(g.outer, inner)), dot(rate_rad_s, los)
    return (
        (dot(inner, los) * radial - dot(inner, rate_rad_s)) / determinant,
        (dot(g.outer, rate_rad_s) - dot(g.outer, los) * radial) / determinant,
    )
