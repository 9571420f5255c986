"""Arcs over the ground in the plane through two points and the Earth's centre."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F, up_itrf


@dataclass(frozen=True, kw_only=True)
class PlaneArc:
    """The arc from P0 to P1 along the ellipsoid's section through its centre (geodetic, rad, m).

    Scanned evenly by its share, the speed over ground is even to 0.03 % (500 km) and better for
    shorter arcs.
    """

    latitude_rad: tuple[float, float]
    longitude_rad: tuple[float, float]
    height_m: float

    def length_m(self) -> float:
        """Along the ground from P0 to P1."""
        r, _ = self.point_itrf(np.linspace(0.0, 1.0, 65))
        return float(np.sum(np.linalg.norm(np.diff(r, axis=0), axis=1)))

    def point_itrf(self, share: Array) -> tuple[Array, Array]:
        """Position (m) and its derivative by the share of the arc, ITRF, (n, 3) each.

        Shares outside 0..1 continue the arc: where a slew joins and leaves it.
        """
        flat = np.array([1.0, 1.0, 1.0 / (1.0 - WGS84_F) ** 2]) / WGS84_A_M**2
        up = up_itrf(np.array(self.latitude_rad), np.array(self.longitude_rad))
        ends = up / flat
        ends /= np.linalg.norm(ends, axis=1, keepdims=True)
        angle = 2.0 * np.arcsin(0.5 * np.linalg.norm(ends[1] - ends[0]))
        u = np.asarray(share)[:, None]
        d = (np.sin((1.0 - u) * angle) * ends[0] + np.sin(u * angle) * ends[1]) / np.sin(angle)
        d1 = (
            angle
            * (np.cos(u * angle) * ends[1] - np.cos((1.0 - u) * angle) * ends[0])
            / np.sin(angle)
        )
        q = np.sum(flat * d * d, axis=1, keepdims=True)
        q1 = np.sum(flat * d * d1, axis=1, keepdims=True)
        normal = flat * d
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal, normal1 = normal / length, flat * d1 / length
        normal1 = normal1 - normal * np.sum(normal * normal1, axis=1, keepdims=True)
        return (
            d / np.sqrt(q) + self.height_m * normal,
            d1 / np.sqrt(q) - d * q1 / q**1.5 + self.height_m * normal1,
        )
