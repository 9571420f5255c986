"""The Earth's limb and the refraction there, compiled, for one direction at a time.

Directions are unit vectors in ITRF axes; spline_coefficients: as of `refraction.bending_spline`.
"""

import math

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled, lean
from planner.base.vectors import (
    Vector,
    angle_between,
    cross,
    dot,
    norm,
    plus,
    scaled,
    unit,
    vector_of,
)
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M, WGS84_F
from planner.world.targets.standard_atmosphere import TOP_M

REFRACTION_PASSES = 12  # Newton from the dark side; 5 suffice 10 km above the ground


@lean
def above_limb(d: Vector, r_sat: Vector, grazing_m: float) -> float:
    """As `earth_limb.limb_clearance_rad` says; a carrier below the altitude sees nothing.

    Scaled by its axes the ellipsoid is a unit sphere; lines and tangents stay such.
    """
    a, b = WGS84_A_M + grazing_m, WGS84_B_M + grazing_m
    start = r_sat[0] / a, r_sat[1] / a, r_sat[2] / b
    distance = norm(start)
    down = scaled(-1.0 / distance, start)
    aside = _unit_across((d[0] / a, d[1] / a, d[2] / b), down)
    sine = min(1.0 / distance, 1.0)
    limb = plus(scaled(math.sqrt(1.0 - sine * sine), down), sine, aside)
    nadir = scaled(-1.0, r_sat)
    return angle_between(d, nadir) - angle_between((limb[0] * a, limb[1] * a, limb[2] * b), nadir)


@lean
def _unit_across(v: Vector, axis: Vector) -> Vector:
    """Direction of the part of `v` across the unit vector `axis`; any where it has none."""
    across = plus(v, -dot(v, axis), axis)
    if norm(across) < 1e-12 * norm(v):
        return unit(cross(axis, (axis[2], axis[0], axis[1] + 1.0)))
    return unit(across)


@lean
def refracted(spline_coefficients: Array, d: Vector, r_sat: Vector) -> Vector:
    """As `earth_limb.refract` says."""
    height_m = _line_height_m(d, r_sat)
    if not height_m < TOP_M:
        return d
    down = scaled(-1.0 / norm(r_sat), r_sat)
    aside = _unit_across(d, down)
    true_rad = angle_between(d, down)
    seen_rad, seen = true_rad, d
    for _ in range(REFRACTION_PASSES):
        to_limb_m = abs(dot(seen, r_sat))
        # Lines that meet the ground are hidden whatever the air does; its law ends there.
        bending_rad, slope = _bending(spline_coefficients, max(height_m, 0.0))
        seen_rad -= (seen_rad - true_rad - bending_rad) / (1.0 - slope * bending_rad * to_limb_m)
        seen = plus(scaled(math.cos(seen_rad), down), math.sin(seen_rad), aside)
        height_m = _line_height_m(seen, r_sat)
    return seen if height_m < TOP_M else d


@lean
def _bending(spline_coefficients: Array, height_m: float) -> tuple[float, float]:
    """The air's, rad, and the derivative of its logarithm, 1/m; as `bending_rad`."""
    k = spline_coefficients
    last = k.shape[1] - 2
    inside = min(max(height_m, k[0, 0]), k[0, last + 1])
    n = min(max(int(np.searchsorted(k[0], inside, side="right")) - 1, 0), last)
    u = inside - k[0, n]
    value = ((k[1, n] * u + k[2, n]) * u + k[3, n]) * u + k[4, n]
    slope = (3.0 * k[1, n] * u + 2.0 * k[2, n]) * u + k[3, n]
    u = k[0, last + 1] - k[0, last]
    beyond = (3.0 * k[1, last] * u + 2.0 * k[2, last]) * u + k[3, last]
    return math.exp(value + beyond * (height_m - inside)), slope


@lean
def _line_height_m(d: Vector, r_sat: Vector) -> float:
    """As `earth_limb.line_height_m` says."""
    a, b = WGS84_A_M, WGS84_B_M
    line = d[0] / a, d[1] / a, d[2] / b
    start = r_sat[0] / a, r_sat[1] / a, r_sat[2] / b
    lowest_m = -dot(line, start) / dot(line, line)
    if lowest_m <= 0.0:
        return math.inf
    x, y, z = plus(r_sat, lowest_m, d)
    across, e2 = math.sqrt(x * x + y * y), WGS84_F * (2.0 - WGS84_F)
    latitude = math.atan2(z, across * (1.0 - e2))
    for _ in range(5):
        sine = math.sin(latitude)
        normal_m = a / math.sqrt(1.0 - e2 * sine * sine)
        latitude = math.atan2(z + e2 * normal_m * sine, across)
    sine = math.sin(latitude)
    return across * math.cos(latitude) + z * sine - a * math.sqrt(1.0 - e2 * sine * sine)


@compiled
def clearances(direction_itrf: Array, r_sat_itrf_m: Array, grazing_m: float) -> Array:
    """`above_limb` of directions (n, 3) from carriers (n, 3)."""
    found_rad = np.empty(len(direction_itrf))
    for k in range(len(found_rad)):
        d, r_sat = vector_of(direction_itrf, k, 0), vector_of(r_sat_itrf_m, k, 0)
        found_rad[k] = above_limb(d, r_sat, grazing_m)
    return found_rad


@compiled
def refracted_each(spline_coefficients: Array, direction_itrf: Array, r_sat_itrf_m: Array) -> Array:
    """`refracted` of the same, (n, 3)."""
    seen = np.empty_like(direction_itrf)
    for k in range(len(seen)):
        d, r_sat = vector_of(direction_itrf, k, 0), vector_of(r_sat_itrf_m, k, 0)
        seen[k, 0], seen[k, 1], seen[k, 2] = refracted(spline_coefficients, d, r_sat)
    return seen


@compiled
def line_heights(direction_itrf: Array, r_sat_itrf_m: Array) -> Array:
    """Of the same, m, (n,)."""
    height_m = np.empty(len(direction_itrf))
    for k in range(len(height_m)):
        d, r_sat = vector_of(direction_itrf, k, 0), vector_of(r_sat_itrf_m, k, 0)
        height_m[k] = _line_height_m(d, r_sat)
    return height_m
