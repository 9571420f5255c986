"""Geodesics on the ellipsoid: where one leads, and which one joins two points.

WGS84; distances along the ellipsoid's surface.  Good to 0.1 mm for courses up to `LONGEST_M`.
Source: Vincenty 1975, Survey Review 23 (176), the direct and inverse formulae.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planner.base.arrays import Array
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F

LONGEST_M = 10e6  # the inverse formula converges for every pair of points this near
_B_M = WGS84_A_M * (1.0 - WGS84_F)


@dataclass(frozen=True, kw_only=True)
class GeodesicOptions:
    """How far the series for a geodesic are iterated."""

    direct_passes: int = 8  # each shrinks the error by e^2: 1e-2
    inverse_passes: int = 50  # each shrinks it by f or better; stops by itself, after 5 as a rule
    converged_rad: float = 1e-14  # on the sphere: 0.1 um


OPTIONS = GeodesicOptions()


def geodesic_end(
    latitude_rad: float, longitude_rad: float, azimuth_rad: ArrayLike, distance_m: ArrayLike
) -> tuple[Array, Array]:
    """Latitude and longitude (rad) where courses from one point end, shape (n,).

    azimuth_rad: at the point, clockwise from north; at a pole north is that of the
    longitude given.  distance_m may be 0 or negative (astern).  Smooth in both.
    """
    azimuth, distance = np.broadcast_arrays(azimuth_rad, distance_m)
    sin_u1, cos_u1 = _reduced_latitude(latitude_rad)
    sin_a1, cos_a1 = np.sin(azimuth), np.cos(azimuth)
    sin_a = cos_u1 * sin_a1
    cos2_a = 1.0 - sin_a**2
    sigma1 = np.arctan2(sin_u1, cos_u1 * cos_a1)
    big_a, big_b = _vincenty_series(cos2_a)
    straight = distance / (_B_M * big_a)
    sigma = straight
    for _ in range(OPTIONS.direct_passes):
        cos_2m = np.cos(2.0 * sigma1 + sigma)
        sigma = straight + _delta_sigma(big_b, sigma, cos_2m)
    cos_2m = np.cos(2.0 * sigma1 + sigma)
    sin_s, cos_s = np.sin(sigma), np.cos(sigma)
    across = np.hypot(sin_a, sin_u1 * sin_s - cos_u1 * cos_s * cos_a1)
    latitude = np.arctan2(sin_u1 * cos_s + cos_u1 * sin_s * cos_a1, (1.0 - WGS84_F) * across)
    on_sphere = np.arctan2(sin_s * sin_a1, cos_u1 * cos_s - sin_u1 * sin_s * cos_a1)
    longitude = longitude_rad + on_sphere - _longitude_excess(sin_a, cos2_a, sigma, cos_2m)
    return np.asarray(latitude), np.asarray(longitude)


def geodesic_between(
    latitude_rad: float, longitude_rad: float, to_latitude_rad: float, to_longitude_rad: float
) -> tuple[float, float]:
    """Azimuth at the first point (rad, clockwise from north) and distance (m).

    Refuses points more than about `LONGEST_M` apart, where the formula may not converge.
    """
    sin_u1, cos_u1 = _reduced_latitude(latitude_rad)
    sin_u2, cos_u2 = _reduced_latitude(to_latitude_rad)
    apart = math.remainder(to_longitude_rad - longitude_rad, 2.0 * math.pi)
    on_sphere = apart
    for _ in range(OPTIONS.inverse_passes):
        east = cos_u2 * math.sin(on_sphere)
        north = cos_u1 * sin_u2 - sin_u1 * cos_u2 * math.cos(on_sphere)
        sin_s = math.hypot(east, north)
        if sin_s == 0.0:
            return 0.0, 0.0
        cos_s = sin_u1 * sin_u2 + cos_u1 * cos_u2 * math.cos(on_sphere)
        sigma = math.atan2(sin_s, cos_s)
        if sigma * WGS84_A_M > LONGEST_M:
            break
        sin_a = cos_u1 * east / sin_s
        cos2_a = 1.0 - sin_a**2
        cos_2m = cos_s - 2.0 * sin_u1 * sin_u2 / cos2_a if cos2_a > 0.0 else 0.0
        before = on_sphere
        on_sphere = apart + float(_longitude_excess(sin_a, cos2_a, sigma, cos_2m))
        if abs(on_sphere - before) < OPTIONS.converged_rad:
            big_a, big_b = _vincenty_series(cos2_a)
            distance_m = _B_M * big_a * (sigma - _delta_sigma(big_b, sigma, cos_2m))
            return math.atan2(east, north), float(distance_m)
    raise ValueError(
        f"the points are more than about {LONGEST_M / 1e3:.0f} km apart; put one in between"
    )


def _reduced_latitude(latitude_rad: float) -> tuple[float, float]:
    """Sine and cosine of the reduced latitude."""
    sin, cos = (1.0 - WGS84_F) * math.sin(latitude_rad), math.cos(latitude_rad)
    norm = math.hypot(sin, cos)
    return sin / norm, cos / norm


def _vincenty_series(cos2_a: ArrayLike) -> tuple[Array, Array]:
    """A and B, eq. 3 and 4."""
    u2 = np.asarray(cos2_a) * (WGS84_A_M**2 - _B_M**2) / _B_M**2
    big_a = 1.0 + u2 / 16384.0 * (4096.0 + u2 * (-768.0 + u2 * (320.0 - 175.0 * u2)))
    big_b = u2 / 1024.0 * (256.0 + u2 * (-128.0 + u2 * (74.0 - 47.0 * u2)))
    return big_a, big_b


def _delta_sigma(big_b: ArrayLike, sigma: ArrayLike, cos_2m: ArrayLike) -> Array:
    """Eq. 6."""
    b, c2 = np.asarray(big_b), np.asarray(cos_2m)
    sin_s, cos_s = np.sin(sigma), np.cos(sigma)
    higher = b / 6.0 * c2 * (4.0 * sin_s**2 - 3.0) * (4.0 * c2**2 - 3.0)
    return np.asarray(b * sin_s * (c2 + b / 4.0 * (cos_s * (2.0 * c2**2 - 1.0) - higher)))


def _longitude_excess(
    sin_a: ArrayLike, cos2_a: ArrayLike, sigma: ArrayLike, cos_2m: ArrayLike
) -> Array:
    """Longitude on the auxiliary sphere less that on the ellipsoid, eq. 10 and 11."""
    s, c2a, c2 = np.asarray(sin_a), np.asarray(cos2_a), np.asarray(cos_2m)
    c = WGS84_F / 16.0 * c2a * (4.0 + WGS84_F * (4.0 - 3.0 * c2a))
    inner = c2 + c * np.cos(sigma) * (2.0 * c2**2 - 1.0)
    return np.asarray((1.0 - c) * WGS84_F * s * (np.asarray(sigma) + c * np.sin(sigma) * inner))
