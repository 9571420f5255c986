"""The density of the upper air: Harris-Priester, for mean solar activity."""

from importlib.resources import files

import numpy as np

from planner.base.arrays import Array

BULGE_LAG_RAD = np.deg2rad(30.0)  # Montenbruck & Gill 2000, 3.5.2
BULGE_EXPONENT = 2.0  # for low inclinations; 6 for polar orbits: Montenbruck & Gill 2000, 3.5.2
HEIGHT_MIN_M = 1e5

_TABLE = np.loadtxt(
    str(files("planner.world.orbits") / "data" / "harris_priester.csv"), delimiter=","
)
_HEIGHT_M = _TABLE[:, 0] * 1e3
_LOG_DENSITY = np.log(_TABLE[:, 1:] * 1e-12)


def thickest_kg_m3(height_m: Array) -> Array:
    """Density under the bulge by height above the ellipsoid, any shape; that of the table's ends
    beyond them.
    """
    return np.asarray(np.exp(np.interp(height_m, _HEIGHT_M, _LOG_DENSITY[:, 1])))


def density_kg_m3(r_eci_m: Array, height_m: Array, r_sun_eci_m: Array) -> Array:
    """Density at n positions, shape (n,); nothing above 1000 km, that of 100 km below it.

    r_eci_m, r_sun_eci_m: shape (n, 3).  height_m: above the ellipsoid, shape (n,).
    The bulge trails the Sun by two hours of local time.  Leaves out the solar cycle and
    magnetic storms, which halve or double the density.
    Source: Montenbruck & Gill 2000, eq. 3.100-3.104.
    """
    c, s = np.cos(BULGE_LAG_RAD), np.sin(BULGE_LAG_RAD)
    x, y, z = (r_sun_eci_m / np.linalg.norm(r_sun_eci_m, axis=1, keepdims=True)).T
    bulge = np.stack([c * x - s * y, s * x + c * y, z], axis=1)
    cos_angle = np.einsum("ni,ni->n", r_eci_m, bulge) / np.linalg.norm(r_eci_m, axis=1)
    weight = (0.5 + 0.5 * cos_angle) ** (BULGE_EXPONENT / 2.0)
    night, day = (np.exp(np.interp(height_m, _HEIGHT_M, column)) for column in _LOG_DENSITY.T)
    density = night + (day - night) * weight
    return np.where(height_m > _HEIGHT_M[-1], 0.0, density)
