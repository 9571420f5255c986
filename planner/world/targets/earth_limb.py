"""Distance of lines of sight into space from the Earth's limb, and their refraction there."""

import numpy as np

from planner.base.arrays import Array
from planner.world.targets.refraction import bending_spline

# Numba takes 0.2 s to import, which only work should pay: kernels are imported as they are asked.


def limb_clearance_rad(
    direction_itrf: Array, r_sat_itrf_m: Array, grazing_altitude_m: float
) -> Array:
    """Angle by which directions clear the ellipsoid raised by an altitude, shape (n,).

    direction_itrf: unit vectors, (n, 3).  Measured in the plane of direction and geocentre;
    negative where the raised Earth hides the direction.  Exact for the ellipsoid whose axes
    are longer by the altitude (within 0.2 % of the altitude of the true parallel surface).
    """
    from planner.world.targets.limb_kernel import clearances

    return clearances(*_rows(direction_itrf, r_sat_itrf_m), float(grazing_altitude_m))


def refract(direction_itrf: Array, r_sat_itrf_m: Array) -> Array:
    """Where a source at infinity seems to stand, seen through the limb, unit vectors (n, 3).

    The air lifts it away from nadir by the bending of the ray that reaches the carrier; the
    Moon, being near, by 0.6 % less.
    """
    from planner.world.targets.limb_kernel import refracted_each

    return refracted_each(bending_spline(), *_rows(direction_itrf, r_sat_itrf_m))


def line_height_m(direction_itrf: Array, r_sat_itrf_m: Array) -> Array:
    """Least height above the ellipsoid along a straight line of sight, shape (n,).

    Infinite where the line only climbs.  Within 2 m for lines that pass below 100 km.
    """
    from planner.world.targets.limb_kernel import line_heights

    return line_heights(*_rows(direction_itrf, r_sat_itrf_m))


def _rows(direction_itrf: Array, r_sat_itrf_m: Array) -> tuple[Array, Array]:
    """Of one shape (n, 3), as compiled code takes them."""
    direction, r_sat_m = np.broadcast_arrays(direction_itrf, r_sat_itrf_m)
    return np.array(direction, np.float64, order="C"), np.array(r_sat_m, np.float64, order="C")
