"""A ground station as a target: the platform points at it to send what its memory holds."""

import math
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import spec
from planner.world.frames.geodesy import HeightM, LatitudeDeg, LongitudeDeg, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg, place_text
from planner.world.targets.refraction import Refraction


@spec
class StationTarget(EarthFixedTarget):
    """A ground station's antenna, in WGS84 geodetic coordinates; nothing is imaged meanwhile.

    The antenna of the platform looks where its camera does.  Neglects what vapour bends radio waves
    beside light.

    latitude_deg: of its antenna. E.g. `78.23`.
    longitude_deg: of its antenna. E.g. `15.4`.
    height_m: of its antenna above the WGS84 ellipsoid, not above sea level. E.g. `480.0`.
    """

    rests_on_earth: ClassVar[bool] = True
    images: ClassVar[bool] = False
    mode: Literal["station"] = "station"
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM = 0.0
    min_elevation_deg: ElevationDeg = 5.0
    refraction: Refraction = "none"

    @property
    def label(self) -> str:
        """Its place."""
        return f"station at {place_text(self.latitude_deg, self.longitude_deg)}"

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3), the same point n times."""
        return np.broadcast_to(self._r_itrf_m, (len(instants.t_s), 3))

    @cached_property
    def _r_itrf_m(self) -> Array:
        return itrf_from_geodetic(
            math.radians(self.latitude_deg), math.radians(self.longitude_deg), self.height_m
        )
