"""WGS84 geodetic coordinates against ITRF positions.

WGS84 is taken identical to ITRF (they agree to centimetres).
"""

from typing import Annotated

import erfa
import numpy as np
from numpy.typing import ArrayLike

from planner.base.arrays import Array
from planner.base.spec import About, Within

# What a request may give of a place.
LatitudeDeg = Annotated[float, Within(-90.0, 90.0), About("Geodetic, WGS84; north positive.")]
LongitudeDeg = Annotated[float, Within(-180.0, 360.0), About("WGS84; east positive.")]
HeightM = Annotated[
    float, Within(-1000.0, 100e3), About("Above the WGS84 ellipsoid, not above sea level.")
]

WGS84_A_M = 6378137.0  # NGA.STND.0036, table 3.1
WGS84_F = 1.0 / 298.257223563  # NGA.STND.0036, table 3.1
WGS84_B_M = WGS84_A_M * (1.0 - WGS84_F)
MU_EARTH_M3_S2 = 3.986004418e14  # IERS Conventions 2010, table 1.1


def itrf_from_geodetic(
    latitude_rad: ArrayLike, longitude_rad: ArrayLike, height_m: ArrayLike
) -> Array:
    """ITRF position, shape (..., 3) of the inputs' common shape; height above the ellipsoid.

    Source: SOFA's gd2gce, by ERFA.
    """
    return np.asarray(erfa.gd2gce(WGS84_A_M, WGS84_F, longitude_rad, latitude_rad, height_m))


def geodetic_from_itrf(r_itrf_m: Array) -> tuple[Array, Array, Array]:
    """Geodetic latitude, longitude in (-pi, pi] (rad) and height (m), each of shape (...).

    Good to 3e-7 m at 400 km, 2e-5 m at 2000 km and 1 mm farther out, down to 50 km from the
    Earth's centre.  At the poles the longitude is that of the x, y left by rounding.
    Source: Fukushima 2006, by ERFA's gc2gde.
    """
    longitude, latitude, height = erfa.gc2gde(WGS84_A_M, WGS84_F, r_itrf_m)
    return np.asarray(latitude), np.asarray(longitude), np.asarray(height)


def up_itrf(latitude_rad: ArrayLike, longitude_rad: ArrayLike) -> Array:
    """Outward normal of the ellipsoid, unit vectors of shape (..., 3)."""
    return np.asarray(erfa.s2c(longitude_rad, latitude_rad))


def c_enu_from_itrf(latitude_rad: ArrayLike, longitude_rad: ArrayLike) -> Array:
    """Rotation matrices to local east, north, up axes, shape (..., 3, 3)."""
    latitude, longitude = np.broadcast_arrays(latitude_rad, longitude_rad)
    east = np.stack([-np.sin(longitude), np.cos(longitude), np.zeros_like(longitude)], axis=-1)
    up = up_itrf(latitude, longitude)
    return np.stack([east, np.cross(up, east), up], axis=-2)
