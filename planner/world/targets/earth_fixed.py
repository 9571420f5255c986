"""Targets that belong to the Earth's surface, and how they are seen."""

import math
from abc import abstractmethod
from typing import Annotated

import numpy as np

from planner.base.arrays import Array, cross
from planner.base.spec import Within
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets.apparent import (
    SPEED_OF_LIGHT_M_S,
    ApparentDirection,
    VisibleTarget,
    aberrate,
)
from planner.world.targets.refraction import LOWEST_ELEVATION_DEG, Refraction, raised_m

ElevationDeg = Annotated[float, Within(0.0, 90.0)]
LIGHT_TIME_PASSES = 2  # each pass shrinks the error by v/c: 2.5 m, then 4 um, after the first


class EarthFixedTarget(VisibleTarget):
    """A target given by its ITRF position, at rest or moving over the Earth.

    min_elevation_deg: the carrier must stand at least this high in the target's sky over
    the whole session, measured from the plane of the ellipsoid, without refraction.
    refraction: "standard" aims where the standard atmosphere makes the target appear.
    """

    min_elevation_deg: float
    refraction: Refraction

    @property
    def is_geometric(self) -> bool:
        """Whether it is looked at where it is, without light time and aberration."""
        return False

    def __post_init__(self) -> None:
        if self.refraction == "standard" and self.min_elevation_deg < LOWEST_ELEVATION_DEG:
            raise ValueError(
                f"refraction 'standard' is modelled from {LOWEST_ELEVATION_DEG:g} deg elevation "
                f"up; raise min_elevation_deg from {self.min_elevation_deg:g} to that"
            )

    @abstractmethod
    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Position at the n instants, shape (n, 3)."""

    def apparent(self, instants: Instants, states: OrbitStates) -> ApparentDirection:
        """Light time and aberration in the geocentric frame; clearance is elevation to spare.

        Neglects the offset of the platform from the carrier's reference point and, unless
        asked for, refraction: at 30 deg elevation 8.0 m across the line of sight, which is
        16.1 m along the ground.  Source: Sumarokov 2016, eq. 9.
        """
        c = c_itrf_from_eci(instants)
        r_target_itrf_m = self.r_target_itrf_m(instants)
        r_target_eci_m = _to_eci(c, r_target_itrf_m)
        los_eci_m = r_target_eci_m - states.r_sat_eci_m
        range_m = np.linalg.norm(los_eci_m, axis=1)
        latitude_rad, longitude_rad, height_m = geodetic_from_itrf(r_target_itrf_m)
        up_eci = _to_eci(c, up_itrf(latitude_rad, longitude_rad))
        sine = -np.sum(los_eci_m * up_eci, axis=1) / range_m
        elevation_rad = np.arcsin(np.clip(sine, -1.0, 1.0))  # overhead it may round to more than 1

        raised_eci_m = np.zeros_like(los_eci_m)
        if self.refraction == "standard":
            raised = raised_m(math.pi / 2.0 - elevation_rad, range_m, height_m)
            raised_eci_m = raised[:, None] * up_eci
        clearance_rad = elevation_rad - math.radians(self.min_elevation_deg)
        if self.is_geometric:
            return ApparentDirection(
                direction_eci=los_eci_m / range_m[:, None],
                range_m=range_m,
                clearance_rad=clearance_rad,
            )
        omega_earth_eci_rad_s = OMEGA_EARTH_RAD_S * c[:, 2, :]
        for _ in range(LIGHT_TIME_PASSES):
            light_time_s = np.linalg.norm(los_eci_m, axis=1) / SPEED_OF_LIGHT_M_S
            emitted = Instants(instants.epoch_utc, instants.t_s - light_time_s)
            # Where it was over the Earth then, and the Earth turned back: 3 ms, 1.4 m.
            r_target_eci_m = _to_eci(c, self.r_target_itrf_m(emitted))
            turned_m = light_time_s[:, None] * cross(omega_earth_eci_rad_s, r_target_eci_m)
            los_eci_m = r_target_eci_m - turned_m - states.r_sat_eci_m
        seen_eci_m = los_eci_m + raised_eci_m
        direction_eci = seen_eci_m / np.linalg.norm(seen_eci_m, axis=1, keepdims=True)
        return ApparentDirection(
            direction_eci=aberrate(direction_eci, states.v_sat_eci_m_s),
            range_m=range_m,
            clearance_rad=clearance_rad,
        )

    def hidden_because(self, clearance_rad: float) -> str:
        """Says the elevation against the least one allowed."""
        elevation_deg = math.degrees(clearance_rad) + self.min_elevation_deg
        return (
            f"the carrier stands at {elevation_deg:.2f} deg elevation in the target's sky, "
            f"below the {self.min_elevation_deg:g} deg asked for"
        )


def place_text(latitude_deg: float, longitude_deg: float) -> str:
    """The place as maps search for it, to 11 m."""
    return f"{latitude_deg:.4f}, {longitude_deg:.4f}"


def _to_eci(c: Array, vector_itrf: Array) -> Array:
    return np.asarray(np.einsum("nji,nj->ni", c, vector_itrf))
