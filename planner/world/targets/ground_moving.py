"""A target that moves over the ground at a steady course and speed."""

import math
from datetime import datetime
from typing import Annotated, Literal

from planner.base.arrays import Array
from planner.base.spec import Within, spec
from planner.world.frames.geodesic import geodesic_end
from planner.world.frames.geodesy import HeightM, LatitudeDeg, LongitudeDeg, itrf_from_geodetic
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s, utc_text
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg, place_text
from planner.world.targets.refraction import Refraction

LEAD_MAX_S = 2.0 * DAY_S  # a ship on a long leg; nothing goes straight on for longer


@spec
class MovingGroundTarget(EarthFixedTarget):
    """A ship, vehicle or aircraft known at an epoch, going straight on along a geodesic.

    A vessel that holds its compass course instead leaves the geodesic by distance^2 tan(latitude) /
    (2 Earth radii): 8 m after 10 km at 45 deg.

    epoch: time at which it was at the place given; UTC, within two days of the session.
    latitude_deg, longitude_deg: its place at the epoch, WGS84; north and east positive.
    height_m: above the ellipsoid, not above sea level; it stays.
    course_deg: at the epoch, clockwise from north; at a pole north is that of the longitude given.
    speed_m_s: over the ellipsoid's surface, in the aircraft's case its ground speed.
    """

    mode: Literal["ground_moving"] = "ground_moving"
    epoch: datetime
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM = 0.0
    course_deg: Annotated[float, Within(-180.0, 360.0)]
    speed_m_s: Annotated[float, Within(0.0, 10e3)]
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    @property
    def label(self) -> str:
        """Where it was at its epoch."""
        return f"moving from {place_text(self.latitude_deg, self.longitude_deg)}"

    def require_known(self, name: str, start_utc: datetime, stop_utc: datetime) -> None:
        """Refuse to look at it too far from its epoch; `name` is this target's own."""
        lead_s = max(abs(elapsed_s(utc, self.epoch)) for utc in (start_utc, stop_utc))
        if lead_s > LEAD_MAX_S:
            raise ValueError(
                f"{name}.epoch ({utc_text(self.epoch)}) is {lead_s / 3600.0:.1f} h from when it is "
                f"to be looked at; past {LEAD_MAX_S / 3600.0:.0f} h nothing goes straight on: give "
                "a newer position"
            )

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3)."""
        since_s = instants.since_s(self.epoch)
        latitude_rad, longitude_rad = geodesic_end(
            math.radians(self.latitude_deg),
            math.radians(self.longitude_deg),
            math.radians(self.course_deg),
            self.speed_m_s * since_s,
        )
        return itrf_from_geodetic(latitude_rad, longitude_rad, self.height_m)
