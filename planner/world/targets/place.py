"""A place on the ground, by its name."""

import math
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.assumed import Assumed
from planner.base.spec import spec
from planner.world.frames.geodesy import itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg
from planner.world.targets.gazetteer import Place, find_place, places_of_name
from planner.world.targets.refraction import Refraction


@spec
class PlaceTarget(EarthFixedTarget):
    """A town of 15,000 people or more by its name: one point, where GeoNames has it.

    name: as people write it, in any script and case; where several places have it, followed by
    region, country or GeoNames number, each after a comma. E.g. `"Portland, Oregon, US"`.
    """

    rests_on_earth: ClassVar[bool] = True
    mode: Literal["place"] = "place"
    name: str
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    def __post_init__(self) -> None:
        _ = self.place  # found now, so that a name that means no place is refused
        super().__post_init__()

    @cached_property
    def place(self) -> Place:
        """Where it is."""
        return find_place(self.name)

    @property
    def label(self) -> str:
        """Its name as it was given."""
        return self.name

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3), the same point n times."""
        return np.broadcast_to(self._r_itrf_m, (len(instants.t_s), 3))

    @cached_property
    def _r_itrf_m(self) -> Array:
        place = self.place
        return itrf_from_geodetic(
            math.radians(place.latitude_deg), math.radians(place.longitude_deg), place.height_m
        )

    def _others_text(self) -> str:
        count = places_of_name(self.name)
        return f"; the most populous by far of {count} of this name" if count > 1 else ""

    def assumed(self, field: str) -> Assumed:
        """Which place, and where."""
        place = self.place
        return Assumed(
            field=f"{field}.name",
            detail=f"{place.words} (GeoNames {place.geonames_id}), "
            f"{place.height_m:.0f} m above the ellipsoid" + self._others_text(),
            members={
                "mode": "ground",
                "latitude_deg": place.latitude_deg,
                "longitude_deg": place.longitude_deg,
                "height_m": place.height_m,
            },
        )
