"""Bending of a ray by the standard atmosphere, to the ground or past the limb.

The judge's own air (the printed bases of the U.S. Standard Atmosphere 1976, Ciddor's index)
and its own quadratures of Bouguer's law, n r sin(zenith angle) = p, layer by layer.
Spherical layers about the mean radius; dry air at 550 nm.  The day's air differs by some 5 %.
"""

from functools import cache

import numpy as np

from planner.base.arrays import Array

EARTH_RADIUS_M = 6371008.8  # IUGG mean radius
TOP_M = 120e3  # a ray bends less than 1e-4 arcsec above; isothermal from 86 km

# USSA 1976, table 4 and table I: geopotential height (m), temperature (K), pressure (Pa) at the
# base of each layer, and its lapse rate (K/m).
_BASE_M = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3, 84852.0])
_BASE_K = np.array([288.15, 216.65, 216.65, 228.65, 270.65, 270.65, 214.65, 186.946])
_BASE_PA = np.array([101325.0, 22632.06, 5474.889, 868.0187, 110.9063, 66.93887, 3.956420, 0.37338])
_LAPSE_K_M = np.array([-6.5e-3, 0.0, 1e-3, 2.8e-3, 0.0, -2.8e-3, -2e-3, 0.0])
_GEOPOTENTIAL_RADIUS_M = 6356766.0
_G_OVER_R_K_M = 9.80665 * 28.9644 / 8314.32
_AIR_GAS_CONSTANT = 8314.32 / 28.9644  # J/(kg K)
# Ciddor 1996, Appl. Opt. 35, 1566, eq. 1, at 1/0.55^2 um^-2: dry air, 15 C, 101325 Pa
_STANDARD_AIR = 1e-8 * (
    5792105.0 / (238.0185 - 1.0 / 0.55**2) + 167917.0 / (57.362 - 1.0 / 0.55**2)
)
_PER_DENSITY = _STANDARD_AIR / 1.2250

# The layers' edges as heights, from below the Dead Sea to the top.
_EDGES_M = np.append(
    _GEOPOTENTIAL_RADIUS_M * _BASE_M[1:] / (_GEOPOTENTIAL_RADIUS_M - _BASE_M[1:]), TOP_M
)
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(12)
_NEWTON_PASSES = 4
_LOWEST_RAY_M = np.arange(0.0, 118e3, 250.0)  # log-linear in between: 2e-4 of the bending


def refractivity(height_m: Array) -> tuple[Array, Array]:
    """n - 1 and its derivative by height (1/m), shape of height_m."""
    over = _GEOPOTENTIAL_RADIUS_M / (_GEOPOTENTIAL_RADIUS_M + height_m)
    geopotential_m = height_m * over
    layer = np.maximum(np.searchsorted(_BASE_M, geopotential_m, side="right") - 1, 0)
    above_m, lapse, base_k = geopotential_m - _BASE_M[layer], _LAPSE_K_M[layer], _BASE_K[layer]
    kelvin = base_k + lapse * above_m
    # (1 + x)^(-g/(R lapse)) with x = lapse above/T, as an exponential that stands lapse = 0
    x = lapse * above_m / base_k
    log1p_over_x = np.where(np.abs(x) > 1e-9, np.log1p(x) / np.where(x == 0.0, 1.0, x), 1.0)
    pascal = _BASE_PA[layer] * np.exp(-_G_OVER_R_K_M * above_m / base_k * log1p_over_x)
    n_minus_1 = _PER_DENSITY * pascal / (_AIR_GAS_CONSTANT * kelvin)
    return n_minus_1, -n_minus_1 * (_G_OVER_R_K_M + lapse) / kelvin * over**2


def lift_to_ground_rad(zenith_rad: Array, range_m: Array, height_m: Array) -> Array:
    """How far from nadir the air lifts a target seen by a carrier above the air, shape (n,).

    zenith_rad, range_m: of the carrier, geometric, seen from the target height_m above the
    ellipsoid.  The ray that joins them: its p makes the angle at the Earth's centre, the
    integral of p/(r sqrt(n^2 r^2 - p^2)), theirs.
    Source: Born and Wolf 1999, 3.2.2, eq. 11.
    """
    r_target = EARTH_RADIUS_M + height_m
    across_m, up_m = range_m * np.sin(zenith_rad), r_target + range_m * np.cos(zenith_rad)
    r_sat, at_centre_rad = np.hypot(across_m, up_m), np.arctan2(across_m, up_m)

    edges_m = np.maximum(np.append(-np.inf, _EDGES_M), height_m[:, None])
    thick_m = np.diff(edges_m)[:, :, None]
    at_m = (edges_m[:, :-1, None] + thick_m * (0.5 + 0.5 * _NODE)).reshape(len(height_m), -1)
    dr = (thick_m * (0.5 * _WEIGHT)).reshape(len(height_m), -1)
    r = EARTH_RADIUS_M + at_m
    n2_r2 = ((1.0 + refractivity(at_m)[0]) * r) ** 2

    straight_p = r_target * np.sin(zenith_rad)
    r_top = EARTH_RADIUS_M + TOP_M
    p = straight_p
    for _ in range(_NEWTON_PASSES):
        climb2 = n2_r2 - (p * p)[:, None]
        swept = dr / (r * np.sqrt(climb2))
        sweep_rad = p * np.sum(swept, axis=1) + np.arccos(p / r_sat) - np.arccos(p / r_top)
        slope = np.sum(swept * n2_r2 / climb2, axis=1)
        slope += 1.0 / np.sqrt(r_top**2 - p * p) - 1.0 / np.sqrt(r_sat**2 - p * p)
        p = p - (sweep_rad - at_centre_rad) / slope
    return np.asarray(np.arcsin(p / r_sat) - np.arcsin(straight_p / r_sat))


def limb_bending_rad(line_height_m: Array) -> tuple[Array, Array]:
    """Angle by which a ray turns between space and space, and its slope by height (rad/m), (n,).

    line_height_m: least height of the ray's straight continuation at the carrier, that is
    p less the Earth's radius; exponential below 1.77 km, where the rays meet the sea.
    """
    height_m, log_bending = _limb_table()
    k = np.clip(np.searchsorted(height_m, line_height_m) - 1, 0, len(height_m) - 2)
    slope = np.diff(log_bending)[k] / np.diff(height_m)[k]
    bending_rad = np.exp(log_bending[k] + slope * (line_height_m - height_m[k]))
    return bending_rad, slope * bending_rad


@cache
def _limb_table() -> tuple[Array, Array]:
    """Heights of lines and the logarithm of their bending.

    With r = lowest + w^2 the integrand of -2 p n'/(n sqrt(n^2 r^2 - p^2)) is smooth.
    """
    lowest_m = _LOWEST_RAY_M[:, None]
    p = (1.0 + refractivity(lowest_m)[0]) * (EARTH_RADIUS_M + lowest_m)
    edges = np.sqrt(np.maximum(np.append(-np.inf, _EDGES_M) - lowest_m, 0.0))
    width = np.diff(edges)[:, :, None]
    w = (edges[:, :-1, None] + width * (0.5 + 0.5 * _NODE)).reshape(len(lowest_m), -1)
    dw = (width * (0.5 * _WEIGHT)).reshape(len(lowest_m), -1)
    height_m = lowest_m + w * w
    n_minus_1, slope = refractivity(height_m)
    n = 1.0 + n_minus_1
    climb = np.sqrt((n * (EARTH_RADIUS_M + height_m)) ** 2 - p * p)
    turned = np.zeros_like(w)
    np.divide(-slope * 4.0 * w * dw, n * climb, out=turned, where=climb > 0.0)
    return (p[:, 0] - EARTH_RADIUS_M), np.log(p[:, 0] * np.sum(turned, axis=1))
