"""Angular distance of a line of sight from the Earth's limb, and its height above the ground."""

import numpy as np

from planner.base.arrays import Array
from planner.verification.earth_fixed import WGS84_A_M, WGS84_A_OVER_B, vertical


def limb_clearance_rad(sight_itrf: Array, r_sat_itrf_m: Array, raised_m: float) -> Array:
    """From the raised ellipsoid's limb to the line of sight, away from nadir, shape (n,).

    sight_itrf: unit vectors (n, 3).  The ellipsoid has both semi-axes longer by raised_m;
    angles lie in the plane of sight and geocentre, where the tangents d to the ellipsoid
    x M x = 1 obey (d M r)^2 = (d M d)(r M r - 1): a quadratic for the tangent's nadir angle.
    A carrier inside the raised ellipsoid has its limb at the zenith.
    """
    semi_axes_m = WGS84_A_M * np.array([1.0, 1.0, 1.0 / WGS84_A_OVER_B]) + raised_m
    r = r_sat_itrf_m / semi_axes_m
    down_itrf = -r_sat_itrf_m / _length(r_sat_itrf_m)
    from_nadir_rad, aside_itrf = _nadir_angle(sight_itrf, down_itrf)
    down, aside = down_itrf / semi_axes_m, aside_itrf / semi_axes_m

    above = np.sum(r * r, axis=1) - 1.0
    down_r, aside_r = np.sum(down * r, axis=1), np.sum(aside * r, axis=1)
    a = aside_r**2 - above * np.sum(aside * aside, axis=1)
    b = aside_r * down_r - above * np.sum(aside * down, axis=1)
    c = down_r**2 - above * np.sum(down * down, axis=1)
    # a < 0 < c outside: one tangent on either side of nadir; this side's has a positive root.
    outside = above > 0.0
    root = np.sqrt(np.where(outside, b * b - a * c, 0.0))
    limb_rad = np.where(outside, np.arctan2(b + root, -a), np.pi)
    return np.asarray(from_nadir_rad - limb_rad)


def lowest_point(sight_itrf: Array, r_sat_itrf_m: Array) -> tuple[Array, Array, Array]:
    """Of straight lines: height above the ellipsoid, way to it (n,), and the vertical there (n, 3).

    The way is negative where the line only climbs.  Within 1 m below 200 km.
    """
    way_m = -np.sum(sight_itrf * r_sat_itrf_m, axis=1)
    # Nearest to the geocentre, then to the ellipsoid: the height curves like 1/(Earth's radius).
    up_itrf, _ = vertical(r_sat_itrf_m + way_m[:, None] * sight_itrf)
    way_m = way_m - np.sum(up_itrf * sight_itrf, axis=1) * WGS84_A_M
    up_itrf, height_m = vertical(r_sat_itrf_m + way_m[:, None] * sight_itrf)
    return height_m, way_m, up_itrf


def _nadir_angle(sight_itrf: Array, down_itrf: Array) -> tuple[Array, Array]:
    """Angle from nadir (n,) and the unit vector (n, 3) across nadir on the sight's side."""
    along = np.sum(sight_itrf * down_itrf, axis=1)
    aside = sight_itrf - along[:, None] * down_itrf
    size = _length(aside)
    # Straight up or down any side is as good as another.
    other_axis = np.where(np.abs(down_itrf[:, :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    any_side = np.cross(down_itrf, other_axis)
    across = np.where(size > 1e-12, aside / np.maximum(size, 1e-12), any_side / _length(any_side))
    return np.arctan2(size[:, 0], along), across


def _length(v: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(v * v, axis=1, keepdims=True)))
