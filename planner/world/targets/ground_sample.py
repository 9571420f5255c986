"""Ground sample distance along the lean of the line of sight."""

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import WGS84_A_M


def sample_along_m(sine_of_elevation: Array, range_m: Array, pixel_rad: float) -> Array:
    """Lengths of pixels (n,) at these ranges; NaN where one reaches the horizon and has no end.

    The ground falls away by x^2 / 2R at a distance x beyond the target, so that half a pixel p is
    filled by ground only where sin(e) > p/2 + sqrt(p range / R): 0.06 deg for 0.68 arcsec from a
    low orbit.  Above, the length is that on a plane: 1.4 times too short at that limit, 0.05 % at
    0.25 deg.  Refraction and terrain are neglected.
    """
    least_sine = 0.5 * pixel_rad + np.sqrt(pixel_rad * range_m / WGS84_A_M)
    ends = sine_of_elevation > least_sine
    return np.where(ends, range_m * pixel_rad / np.where(ends, sine_of_elevation, 1.0), np.nan)
