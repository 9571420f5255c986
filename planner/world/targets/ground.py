"""A point on the ground as a target."""

import math
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import spec
from planner.world.frames.geodesy import HeightM, LatitudeDeg, LongitudeDeg, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg, place_text
from planner.world.targets.gazetteer import town_near
from planner.world.targets.refraction import Refraction


@spec
class GroundTarget(EarthFixedTarget):
    """A point fixed to the Earth, in WGS84 geodetic coordinates.

    Source: Sumarokov 2016, eq. 8.
    """

    rests_on_earth: ClassVar[bool] = True
    mode: Literal["ground"] = "ground"
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM = 0.0
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    @cached_property
    def label(self) -> str:
        """Its place, and a town that people know where there is one."""
        place = place_text(self.latitude_deg, self.longitude_deg)
        town = town_near(self.latitude_deg, self.longitude_deg)
        return f"near {town} ({place})" if town else place

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3), the same point n times."""
        return np.broadcast_to(self._r_itrf_m, (len(instants.t_s), 3))

    @cached_property
    def _r_itrf_m(self) -> Array:
        return itrf_from_geodetic(
            math.radians(self.latitude_deg), math.radians(self.longitude_deg), self.height_m
        )
