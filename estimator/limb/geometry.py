"""The limb of an ellipsoid, as seen from a craft.

A ray d from r grazes the ellipsoid x'Ex = 1 where d'Md = 0, with
M = E r r'E - (r'Er - 1) E; inside the disc d'Md > 0.  Source: Christian 2017, "Accurate
planetary limb localization for image-based spacecraft navigation", eq. 10-14; the limb at
height h is that of the ellipsoid with both axes longer by h.  Straight rays: refraction
lifts the limb by 0.2 km at 17 km height, inside the scatter of its effective height.
"""

from functools import cached_property

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import up_itrf


class Limb:
    """The limb of an ellipsoid of revolution about ITRF Z, seen from one position.

    r_itrf_m: the craft, shape (3,).  Directions are unit vectors in ITRF axes from the craft;
    azimuths are about geocentric nadir, from `axes_itrf[0]` (east) to `axes_itrf[1]` (north).
    """

    def __init__(self, r_itrf_m: Array, a_m: float, b_m: float) -> None:
        self.r_itrf_m = np.asarray(r_itrf_m, dtype=float)
        self.range_m = float(np.linalg.norm(self.r_itrf_m))
        self.a_m, self.b_m = a_m, b_m
        self.nadir_itrf: Array = -self.r_itrf_m / self.range_m
        self.nadir_geodetic_itrf = self._geodetic_nadir()
        east_itrf = np.cross([0.0, 0.0, 1.0], self.r_itrf_m)
        if np.linalg.norm(east_itrf) < 1.0:
            east_itrf = np.array([1.0, 0.0, 0.0])
        east_itrf /= np.linalg.norm(east_itrf)
        self.axes_itrf: Array = np.stack([east_itrf, np.cross(-self.nadir_itrf, east_itrf)])

    def quadric(self, height_m: float | Array) -> Array:
        """E of the ellipsoid grown by the height: diagonal, shape (..., 3)."""
        a = np.asarray(self.a_m + height_m)
        b = np.asarray(self.b_m + height_m)
        return np.stack([a**-2, a**-2, b**-2], axis=-1)

    def cone(self, height_m: float) -> Array:
        """M, shape (3, 3)."""
        e = self.quadric(height_m)
        er = e * self.r_itrf_m
        return np.asarray(np.outer(er, er) - (self.r_itrf_m @ er - 1.0) * np.diag(e))

    def directions_itrf(self, azimuth_rad: Array, height_m: float) -> Array:
        """The limb at azimuths (n,), shape (n, 3)."""
        cone = self.cone(height_m)
        across_itrf = np.column_stack([np.cos(azimuth_rad), np.sin(azimuth_rad)]) @ self.axes_itrf
        nn = self.nadir_itrf @ cone @ self.nadir_itrf
        ne = across_itrf @ cone @ self.nadir_itrf
        ee = np.sum((across_itrf @ cone) * across_itrf, axis=1)
        tangent = (-ne - np.sqrt(ne**2 - nn * ee)) / ee
        direction_itrf = self.nadir_itrf + tangent[:, None] * across_itrf
        # Nadir and the level direction are square to each other.
        return np.asarray(direction_itrf / np.sqrt(1.0 + tangent**2)[:, None])

    def azimuth_rad(self, direction_itrf: Array) -> Array:
        """Azimuths of directions (n, 3), shape (n,)."""
        east, north = self.axes_itrf @ direction_itrf.T
        return np.asarray(np.arctan2(north, east))

    def touch_points_m(self, direction_itrf: Array, height_m: float) -> Array:
        """Points (n, 3) nearest to the body along limb rays (n, 3)."""
        e = self.quadric(height_m)
        reach = -(direction_itrf @ (e * self.r_itrf_m)) / np.sum(e * direction_itrf**2, axis=1)
        return np.asarray(self.r_itrf_m + reach[:, None] * direction_itrf)

    def touch_range_m(self, height_m: float) -> float:
        """Distance from the craft to its limb, a sphere's: differs by 0.5 % around the limb."""
        return float(np.sqrt(self.range_m**2 - (self.mean_radius_m + height_m) ** 2))

    @cached_property
    def mean_radius_m(self) -> float:
        """Radius of the sphere whose limb has the mean angular radius, limb height zero."""
        azimuth = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
        cosine = self.directions_itrf(azimuth, 0.0) @ self.nadir_geodetic_itrf
        return float(self.range_m * np.sin(np.mean(np.arccos(cosine))))

    def sun_elevation_rad(self, direction_itrf: Array, height_m: float, sun_itrf: Array) -> Array:
        """Elevation of the Sun (a unit vector) at the limb points seen along (n, 3), shape (n,)."""
        normal = self.quadric(height_m) * self.touch_points_m(direction_itrf, height_m)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        return np.asarray(np.arcsin(np.clip(normal @ sun_itrf, -1.0, 1.0)))

    def _geodetic_nadir(self) -> Array:
        # Bowring's iteration on the foot point's parametric latitude; exact for a sphere.
        x, z = float(np.hypot(*self.r_itrf_m[:2])), float(self.r_itrf_m[2])
        a, b = self.a_m, self.b_m
        parametric = np.arctan2(a * z, b * x)
        for _ in range(4):
            geodetic = np.arctan2(
                z + (a * a - b * b) / b * np.sin(parametric) ** 3,
                x - (a * a - b * b) / a * np.cos(parametric) ** 3,
            )
            parametric = np.arctan2(b * np.sin(geodetic), a * np.cos(geodetic))
        longitude = np.arctan2(self.r_itrf_m[1], self.r_itrf_m[0])
        return -up_itrf(geodetic, longitude)
