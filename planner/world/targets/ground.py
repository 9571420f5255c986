"""A point on the ground as a target."""

import math
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Literal, Self

from planner.base.arrays import Array
from planner.base.assumed import Assumed
from planner.base.spec import spec
from planner.world.frames.geodesy import HeightM, LatitudeDeg, LongitudeDeg, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg, place_text
from planner.world.targets.gazetteer import town_near
from planner.world.targets.refraction import Refraction
from planner.world.targets.terrain import Terrain, require_one_height


@spec
class GroundTarget(EarthFixedTarget):
    """A point fixed to the Earth, in WGS84 geodetic coordinates.

    height_m: above the WGS84 ellipsoid, not above sea level; unless given, the terrain's, 0 without
    one. E.g. `620.0`.
    terrain: heights of the ground; unless given, the request's.

    Source: Sumarokov 2016, eq. 8.
    """

    rests_on_earth: ClassVar[bool] = True
    mode: Literal["ground"] = "ground"
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM | None = None
    terrain: Terrain | None = None
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    def __post_init__(self) -> None:
        super().__post_init__()
        require_one_height(self.height_m, self.terrain)
        _ = self.ground_height_m  # found now, so that a place without a height is refused

    def standing_on(self, terrain: Terrain) -> Self:
        """Unless it says its height."""
        is_told = self.height_m is not None or self.terrain is not None
        return self if is_told else replace(self, terrain=terrain)

    def with_heights(self) -> Self:
        """With the terrain's height, if it stands on terrain."""
        if self.terrain is None:
            return self
        return replace(self, height_m=self.ground_height_m, terrain=None)

    @cached_property
    def ground_height_m(self) -> float:
        """Above the ellipsoid."""
        if self.terrain is None:
            return self.height_m or 0.0
        return self.terrain.height_m(self.latitude_deg, self.longitude_deg)

    def assumed(self, field: str) -> Assumed | None:
        """The height that the terrain has there."""
        if self.terrain is None:
            return None
        return Assumed(
            field=f"{field}.height_m",
            detail=f"{self.ground_height_m:.1f} m above the ellipsoid, of the terrain",
            members={"height_m": self.ground_height_m},
        )

    @cached_property
    def label(self) -> str:
        """Its place, and a town that people know where there is one."""
        place = place_text(self.latitude_deg, self.longitude_deg)
        town = town_near(self.latitude_deg, self.longitude_deg)
        return f"near {town} ({place})" if town else place

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3), the same point n times."""
        return self._r_itrf_m[None].repeat(len(instants.t_s), axis=0)

    @cached_property
    def _r_itrf_m(self) -> Array:
        return itrf_from_geodetic(
            math.radians(self.latitude_deg), math.radians(self.longitude_deg), self.ground_height_m
        )
