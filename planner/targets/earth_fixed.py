"""How is a target seen that belongs to the Earth's surface?"""

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from planner.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.frames.time_scales import Instants
from planner.orbits import OrbitStates
from planner.targets.apparent import SPEED_OF_LIGHT_M_S, ApparentDirection, aberrated

LIGHT_TIME_PASSES = 2  # each pass shrinks the error by v/c: 2.5 m, then 4 um, after the first


class EarthFixedTarget(ABC):
    """A target given by its ITRF position.

    min_elevation_deg: the carrier must stand at least this high in the target's sky over
    the whole session, measured from the plane of the ellipsoid, without refraction.
    """

    min_elevation_deg: float

    @abstractmethod
    def r_target_itrf_m(self, instants: Instants) -> NDArray[np.float64]:
        """Position at the n instants, shape (n, 3)."""

    def apparent(self, instants: Instants, states: OrbitStates) -> ApparentDirection:
        """Light time and aberration in the geocentric frame; clearance is elevation to spare.

        Neglects refraction (7.6 m on the ground at 30 deg elevation), the target's own
        motion over the Earth during the light time (3 ms), and the offset of the platform
        from the carrier's reference point.
        Source: Sumarokov 2016, eq. 9.
        """
        c_itrf_from_eci_ = c_itrf_from_eci(instants)
        r_target_itrf_m = self.r_target_itrf_m(instants)
        r_target_eci_m = np.einsum("nji,nj->ni", c_itrf_from_eci_, r_target_itrf_m)
        omega_earth_eci_rad_s = OMEGA_EARTH_RAD_S * c_itrf_from_eci_[:, 2, :]
        v_target_eci_m_s = np.cross(omega_earth_eci_rad_s, r_target_eci_m)

        los_eci_m = r_target_eci_m - states.r_sat_eci_m
        range_m = np.linalg.norm(los_eci_m, axis=1)
        up_eci = np.einsum(
            "nji,nj->ni", c_itrf_from_eci_, up_itrf(*geodetic_from_itrf(r_target_itrf_m)[:2])
        )
        elevation_rad = np.arcsin(-np.sum(los_eci_m * up_eci, axis=1) / range_m)
        for _ in range(LIGHT_TIME_PASSES):
            light_time_s = np.linalg.norm(los_eci_m, axis=1, keepdims=True) / SPEED_OF_LIGHT_M_S
            los_eci_m = r_target_eci_m - light_time_s * v_target_eci_m_s - states.r_sat_eci_m
        direction_eci = los_eci_m / np.linalg.norm(los_eci_m, axis=1, keepdims=True)
        return ApparentDirection(
            direction_eci=aberrated(direction_eci, states.v_sat_eci_m_s),
            range_m=range_m,
            clearance_rad=elevation_rad - math.radians(self.min_elevation_deg),
        )

    def hidden_because(self, clearance_rad: float) -> str:
        """Says the elevation against the least one allowed."""
        elevation_deg = math.degrees(clearance_rad) + self.min_elevation_deg
        return (
            f"the carrier stands at {elevation_deg:.2f} deg elevation in the target's sky, "
            f"below the {self.min_elevation_deg:g} deg asked for"
        )
