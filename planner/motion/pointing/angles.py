"""Axis angles, rates and accelerations that point a two-axis platform along a direction."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask, cross
from planner.world.platforms import TwoAxisPlatform


class BranchAngles(NamedTuple):
    """Both ways to point along n directions.

    angle_rad: shape (2, n, 2): branch, direction, axis in the platform's order, each in
    (-pi, pi]; NaN where unreachable.  reachable: (n,).
    """

    angle_rad: Array
    reachable: Mask


def axis_angles(platform: TwoAxisPlatform, los_platform: Array) -> BranchAngles:
    """Angles that bring the zero direction onto each line of sight.

    los_platform: unit vectors in the platform frame, shape (n, 3).  Hard stops are not
    applied.  Where the line of sight lies in the plane of the two axes the branches meet
    and, on the outer axis itself, the outer angle is arbitrary: see `singular_margin_rad`.
    Source: Paden-Kahan subproblem 2 (Murray, Li, Sastry 1994, sec. 3.3), which for
    perpendicular axes intersects the cones of Sumarokov 2016, p. 88.
    """
    # Numba takes 0.2 s to import, which only work should pay.
    from planner.motion.pointing.reach import axes_each, reach_of

    angle_rad = axes_each(reach_of(platform), np.array(los_platform, np.float64, order="C"))
    return BranchAngles(angle_rad, ~np.isnan(angle_rad[0, :, 0]))


def within_stops(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """Angles, shape (..., 2), whole turns away, as near as can be to mid-travel."""
    middle_rad = [0.5 * (a.angle_min_rad + a.angle_max_rad) for a in platform.axis_limits]
    return np.asarray(angle_rad - math.tau * np.round((angle_rad - middle_rad) / math.tau))


def axis_motion(
    platform: TwoAxisPlatform,
    angle_rad: Array,
    los_platform: Array,
    los_rate_platform_per_s: Array,
    los_acceleration_platform_per_s2: Array,
) -> tuple[Array, Array]:
    """Axis rates and accelerations that follow a moving line of sight.

    angle_rad: (n, 2), angles that point along los_platform (n, 3), whose first and second
    time derivatives follow.  Returns rate_rad_s and acceleration_rad_s2, shape (n, 2).
    They grow as the inverse of the sine of `singular_margin_rad`.
    Source: T' = J q' with J = [w1 x T, w2 x T] solved in closed form, and its derivative.
    """
    outer, inner = carried_axes(platform, angle_rad)
    determinant = np.sum(los_platform * cross(outer, inner), axis=1)

    def solve_axes(tangent_platform: Array) -> Array:
        radial = np.sum(tangent_platform * los_platform, axis=1)
        outer_part = np.sum(inner * los_platform, axis=1) * radial - np.sum(
            inner * tangent_platform, axis=1
        )
        inner_part = (
            np.sum(outer * tangent_platform, axis=1) - np.sum(outer * los_platform, axis=1) * radial
        )
        return np.asarray(np.stack([outer_part, inner_part], axis=1) / determinant[:, None])

    rate_rad_s = solve_axes(los_rate_platform_per_s)
    outer_rate, inner_rate = rate_rad_s[:, :1], rate_rad_s[:, 1:]
    inner_axis_rate = outer_rate * cross(outer, inner)
    carried = outer_rate * cross(outer, los_rate_platform_per_s) + inner_rate * (
        cross(inner_axis_rate, los_platform) + cross(inner, los_rate_platform_per_s)
    )
    return rate_rad_s, solve_axes(los_acceleration_platform_per_s2 - carried)


def boresight_platform(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """The boresight: R(outer, a) R(inner, b) zero, unit vectors, shape (n, 3).

    angle_rad: (n, 2).  Source: Sumarokov 2016, eq. 11.
    """
    outer, inner = platform.axes_platform
    zero = np.broadcast_to(_zero_direction(platform), (len(angle_rad), 3))
    return _rotate_about(outer, angle_rad[:, 0], _rotate_about(inner, angle_rad[:, 1], zero))


def carried_axes(platform: TwoAxisPlatform, angle_rad: Array) -> tuple[Array, Array]:
    """Outer and inner axis in the platform frame, unit vectors (n, 3) each, at angles (n, 2)."""
    outer, inner = platform.axes_platform
    shape = (len(angle_rad), 3)
    turned = _rotate_about(outer, angle_rad[:, 0], np.broadcast_to(inner, shape))
    return np.broadcast_to(outer, shape), turned


def singular_margin_rad(platform: TwoAxisPlatform, angle_rad: Array, los_platform: Array) -> Array:
    """Angle between the line of sight and the plane of the two axes, shape (n,), in [0, pi/2].

    At zero the branches meet and the axes can't follow a general motion.  With
    perpendicular axes and the zero direction across the inner one, as on the HRC, it is the
    angle between the line of sight and the outer axis.
    """
    outer, inner = carried_axes(platform, angle_rad)
    normal = cross(outer, inner)
    sine = np.abs(np.sum(los_platform * normal, axis=1)) / np.linalg.norm(normal, axis=1)
    return np.asarray(np.arcsin(np.minimum(sine, 1.0)))


def keyholes_rad(platform: TwoAxisPlatform) -> tuple[float, float]:
    """Inner angles, ascending in [-pi, pi), at which `singular_margin_rad` is zero."""
    outer, inner = platform.axes_platform
    zero = np.asarray(platform.zero_direction_platform)
    normal = np.cross(outer, inner)
    at_rad = math.atan2(-float(normal @ zero), float(normal @ np.cross(inner, zero)))
    low, high = sorted((one + math.pi) % math.tau - math.pi for one in (at_rad, at_rad + math.pi))
    return low, high


def cosine_coefficients(platform: TwoAxisPlatform, directions_platform: Array) -> Array:
    """(n, 9): the boresight's cosine with (n, 3) unit vectors is the sum over i, j of
    entry 3 i + j times (1, cos a, sin a)[i] times (1, cos b, sin b)[j].

    Source: Rodrigues' formula, applied for the inner and the outer axis.
    """
    parts = np.einsum("nx,jix->nij", directions_platform, _boresight_parts(platform))
    return np.asarray(parts.reshape(-1, 9))


@lru_cache(maxsize=8)
def _boresight_parts(platform: TwoAxisPlatform) -> Array:
    """(3, 3, 3): vectors [j, i, xyz] of the boresight beside the (j, i) parts of the angles."""
    outer, inner = platform.axes_platform

    def split_vector(axis: Array, vector_platform: Array) -> list[Array]:
        along = (axis @ vector_platform) * axis
        return [along, vector_platform - along, cross(axis, vector_platform)]

    by_inner = split_vector(inner, _zero_direction(platform))
    return np.array([split_vector(outer, part) for part in by_inner])


def _zero_direction(platform: TwoAxisPlatform) -> Array:
    zero = np.array(platform.zero_direction_platform)
    return np.asarray(zero / np.linalg.norm(zero))


def _rotate_about(axis: Array, angle_rad: Array, directions: Array) -> Array:
    """Rodrigues' formula: `directions` (n, 3) turned by angle_rad (n,) about `axis` (3,)."""
    cosine, sine = np.cos(angle_rad)[:, None], np.sin(angle_rad)[:, None]
    along = (directions @ axis)[:, None] * axis
    return np.asarray(cosine * (directions - along) + sine * cross(axis, directions) + along)
