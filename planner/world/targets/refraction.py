"""Refraction of what the carrier sees, on the ground and beyond the limb.

Spherical layers of the U.S. Standard Atmosphere; the weather changes it by some 5 %.
Rays obey Bouguer's law: n r sin(zenith angle) is constant along a ray.
"""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from planner.base.arrays import Array
from planner.world.targets.standard_atmosphere import TOP_M, refractivity

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Refraction = Literal["none", "standard"]

LOWEST_ELEVATION_DEG = 5.0  # of a ground target: below, the layers' own shape matters
EARTH_RADIUS_M = 6371e3  # mean radius; the ellipsoid's bends differ by 0.4 % of the effect


@dataclass(frozen=True, kw_only=True)
class RefractionOptions:
    """How refraction is tabulated."""

    height_nodes: int = 48  # of a quadrature over the height of the air
    # each shrinks the error by 3e-4 / cos^2 zenith angle: 0.04 at 5 deg
    displacement_passes: int = 4
    overhead_rad: float = 1e-6  # the raised height is even in the zenith angle, so it is flat there


OPTIONS = RefractionOptions()


def raised_m(zenith_rad: Array, range_m: Array, height_m: Array) -> Array:
    """How much higher a target seems to a carrier above the air, shape (n,).

    zenith_rad, range_m: geometric zenith angle and distance of the carrier, seen from the
    target.  height_m: the target's, above the ellipsoid.
    The straight continuation of the ray that arrives at the carrier passes this far above the
    target: 2.3 m / cos^2(zenith angle) at sea level.  Good down to 5 deg elevation.
    Source: Noerdlinger 1999, ISPRS J. Photogramm. 54, 360, with the integral over the
    layers instead of his fit.
    """
    z = np.maximum(zenith_rad, OPTIONS.overhead_rad)
    r_target = EARTH_RADIUS_M + height_m
    sat_across, sat_up = range_m * np.sin(z), r_target + range_m * np.cos(z)
    # The air thins out upwards: nodes crowd at the target.
    node, weight = np.polynomial.legendre.leggauss(OPTIONS.height_nodes)
    thickness = TOP_M - height_m[:, None]
    height = height_m[:, None] + thickness * ((node + 1.0) / 2.0) ** 2
    dr = weight * thickness * (node + 1.0) / 2.0
    r = EARTH_RADIUS_M + height
    n_minus_1 = refractivity(height)
    beyond_rad = np.zeros_like(z)
    for _ in range(OPTIONS.displacement_passes):
        # The straight line meets the target's sphere this angle beyond the target.
        across, up = -r_target * np.sin(beyond_rad), r_target * np.cos(beyond_rad)
        impact = (sat_across * up - sat_up * across) / np.hypot(sat_across - across, sat_up - up)
        straight = np.sqrt(r**2 - impact[:, None] ** 2)
        bent2_excess = n_minus_1 * (2.0 + n_minus_1) * r**2
        bent = np.sqrt(straight**2 + bent2_excess)
        lag_per_m = np.sum(bent2_excess / (r * straight * bent * (straight + bent)) * dr, axis=1)
        beyond_rad = impact * lag_per_m
    across, up = -r_target * np.sin(beyond_rad), r_target * np.cos(beyond_rad)
    return np.asarray(up - r_target - across * (sat_up - up) / (sat_across - across))


def bending_rad(line_height_m: ArrayLike) -> Array:
    """Angle by which the air turns a ray from space back into space, shape of the argument.

    line_height_m: least height of the ray's straight continuation at the carrier; below
    1.8 km the ray meets the ground.  Source: Born and Wolf 1999, 3.2.2, by quadrature.
    """
    log_bending = _log_bending_of_height()
    low, high = log_bending.x[0], log_bending.x[-1]
    height = np.asarray(line_height_m)
    inside = np.clip(height, low, high)
    return np.asarray(np.exp(log_bending(inside) + log_bending(high, 1) * (height - inside)))


def bending_spline() -> Array:
    """Nodes of height and, highest power first, the logarithm's coefficients after each, (5, k)."""
    spline = _log_bending_of_height()
    return np.concatenate([spline.x[None], np.pad(spline.c, ((0, 0), (0, 1)))])


@cache
def _log_bending_of_height() -> "CubicSpline":
    """Smooth through nodes 2 km apart, so that the layers' edges leave no kink in a rate."""
    from scipy.interpolate import CubicSpline  # takes 0.15 s, wanted by few plans

    height = np.linspace(0.0, TOP_M + 60e3, 9001)
    n = 1.0 + refractivity(height)
    x = n * (EARTH_RADIUS_M + height)
    slope = np.gradient(np.log(n), x)
    line_height = np.append(x[0] - EARTH_RADIUS_M, np.arange(4e3, TOP_M + 1.0, 2e3))
    s = np.linspace(0.0, np.sqrt(2.0 * EARTH_RADIUS_M * 60e3), 4001)
    b = EARTH_RADIUS_M + line_height[:, None]
    along = np.sqrt(b**2 + s**2)
    bending = -2.0 * b[:, 0] * np.trapezoid(np.interp(along, x, slope) / along, s, axis=1)
    return CubicSpline(line_height, np.log(bending))
