"""The pass in the target's sky, as in pass tables: rise, culmination and set."""

from dataclasses import dataclass

from planner.base.answer_members import ElevationDeg, LongitudeDeg, Signed, TurnDeg


@dataclass(frozen=True, kw_only=True)
class SkyPointOut:
    """The carrier and the Sun in the target's sky at one instant, without refraction.

    at: time of the point; UTC.
    azimuth_deg: of the carrier, clockwise from north.
    elevation_deg: of the carrier.
    sun_azimuth_deg: of the Sun's centre, clockwise from north.
    sun_elevation_deg: of the Sun's centre: day above 0.
    local_solar_time: apparent, as a sundial at the target shows it, in hours, minutes and seconds.
    """

    at: str
    azimuth_deg: TurnDeg
    elevation_deg: ElevationDeg
    sun_azimuth_deg: TurnDeg
    sun_elevation_deg: ElevationDeg
    local_solar_time: str


@dataclass(frozen=True, kw_only=True)
class TargetSkyOut:
    """A pass in the target's sky, as pass tables have it.

    rise: as the window opens.
    culmination: highest point of the carrier within the window.
    set: as the window closes.
    """

    rise: SkyPointOut
    culmination: SkyPointOut
    set: SkyPointOut


@dataclass(frozen=True, kw_only=True)
class PlaceOut:
    """Place of the target as the carrier culminates.

    latitude_deg: geodetic, WGS84; north positive.
    longitude_deg: WGS84; east positive.
    height_m: above the WGS84 ellipsoid.
    """

    latitude_deg: ElevationDeg
    longitude_deg: LongitudeDeg
    height_m: Signed
