"""Distance of a line of sight into space from the Earth's limb, and its refraction there."""

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F, geodetic_from_itrf
from planner.world.targets.refraction import bending_rad, bending_slope_m
from planner.world.targets.standard_atmosphere import TOP_M

REFRACTION_PASSES = 12  # Newton from the dark side; 5 suffice 10 km above the ground


def limb_clearance_rad(
    direction_itrf: Array, r_sat_itrf_m: Array, grazing_altitude_m: float
) -> Array:
    """Angle by which directions clear the ellipsoid raised by an altitude, shape (n,).

    direction_itrf: unit vectors, (n, 3).  Measured in the plane of direction and geocentre;
    negative where the raised Earth hides the direction.  Exact for the ellipsoid whose axes
    are longer by the altitude (within 0.2 % of the altitude of the true parallel surface).
    """
    semi_axes_m = np.array([1.0, 1.0, 1.0 - WGS84_F]) * WGS84_A_M + grazing_altitude_m
    # Scaled by the axes the ellipsoid is a unit sphere; lines and tangents stay such.
    r_scaled = r_sat_itrf_m / semi_axes_m
    distance = np.linalg.norm(r_scaled, axis=1, keepdims=True)
    down_scaled = -r_scaled / distance
    aside_scaled = _unit_across(direction_itrf / semi_axes_m, down_scaled)
    sin_dip = np.minimum(1.0 / distance, 1.0)  # a carrier below the altitude sees nothing
    limb_scaled = np.sqrt(1.0 - sin_dip**2) * down_scaled + sin_dip * aside_scaled
    limb_itrf = limb_scaled * semi_axes_m
    return _from_nadir_rad(direction_itrf, r_sat_itrf_m) - _from_nadir_rad(limb_itrf, r_sat_itrf_m)


def refract(direction_itrf: Array, r_sat_itrf_m: Array) -> Array:
    """Where a source at infinity seems to stand, seen through the limb, unit vectors (n, 3).

    The air lifts it away from nadir by the bending of the ray that reaches the carrier; the
    Moon, being near, by 0.6 % less.
    """
    height_m = line_height_m(direction_itrf, r_sat_itrf_m)
    if not np.any(height_m < TOP_M):
        return direction_itrf
    down = -r_sat_itrf_m / np.linalg.norm(r_sat_itrf_m, axis=1, keepdims=True)
    aside = _unit_across(direction_itrf, down)
    true_rad = _from_nadir_rad(direction_itrf, r_sat_itrf_m)
    seen_rad = true_rad
    seen_itrf = direction_itrf
    for _ in range(REFRACTION_PASSES):
        to_limb_m = -np.sum(seen_itrf * r_sat_itrf_m, axis=1)
        # Lines that meet the ground are hidden whatever the air does; its law ends there.
        height_m = np.maximum(height_m, 0.0)
        excess_rad = seen_rad - true_rad - bending_rad(height_m)
        seen_rad = seen_rad - excess_rad / (1.0 - bending_slope_m(height_m) * np.abs(to_limb_m))
        seen_itrf = np.cos(seen_rad)[:, None] * down + np.sin(seen_rad)[:, None] * aside
        height_m = line_height_m(seen_itrf, r_sat_itrf_m)
    return np.where((height_m < TOP_M)[:, None], seen_itrf, direction_itrf)


def line_height_m(direction_itrf: Array, r_sat_itrf_m: Array) -> Array:
    """Least height above the ellipsoid along a straight line of sight, shape (n,).

    Infinite where the line only climbs.  Within 2 m for lines that pass below 100 km.
    """
    semi_axes_m = np.array([1.0, 1.0, 1.0 - WGS84_F]) * WGS84_A_M
    line, start = direction_itrf / semi_axes_m, r_sat_itrf_m / semi_axes_m
    lowest_m = -np.sum(line * start, axis=1) / np.sum(line * line, axis=1)
    height = geodetic_from_itrf(r_sat_itrf_m + lowest_m[:, None] * direction_itrf)[2]
    return np.where(lowest_m > 0.0, height, np.inf)


def _unit_across(v: Array, axis: Array) -> Array:
    """Direction of the part of `v` across the unit v `axis`; any where it has none."""
    across = v - np.sum(v * axis, axis=1, keepdims=True) * axis
    size = np.linalg.norm(across, axis=1, keepdims=True)
    spare = np.cross(axis, np.roll(axis, 1, axis=1) + np.array([0.0, 0.0, 1.0]))
    spare /= np.linalg.norm(spare, axis=1, keepdims=True)
    scale = np.linalg.norm(v, axis=1, keepdims=True)
    none = size < 1e-12 * scale
    return np.where(none, spare, across / np.where(none, 1.0, size))


def _from_nadir_rad(direction: Array, r_sat_m: Array) -> Array:
    """Angle from the geocentre's direction, accurate at 0 and pi too."""
    across = np.linalg.norm(np.cross(direction, r_sat_m), axis=1)
    return np.asarray(np.arctan2(across, -np.sum(direction * r_sat_m, axis=1)))
