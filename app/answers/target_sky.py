"""The pass in the target's sky, as in pass tables: rise, culmination and set."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from app.answers.ranges import ElevationDeg, Signed, TurnDeg
from planner.base.arrays import Array
from planner.base.csv_cells import csv_lines
from planner.world.frames.time_scales import Instants

if TYPE_CHECKING:
    from planner.planning.opportunities.windows import TargetSky

DECIMALS = 6  # 1e-6 deg is 4 milliarcsec
LongitudeDeg = Annotated[float, Field(json_schema_extra={"minimum": -180.0, "maximum": 180.0})]
_EVENTS = ("rise", "culmination", "set")


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


def skies_out(start_utc: datetime, sky: "TargetSky") -> list[TargetSkyOut | None]:
    """One per window, None for targets in space."""
    columns = {
        "at": Instants(start_utc, sky.t_s.ravel()).utc_text(3),
        "azimuth_deg": _turns_deg(sky.azimuth_rad).ravel().tolist(),
        "elevation_deg": _degrees(sky.elevation_rad).ravel().tolist(),
        "sun_azimuth_deg": _turns_deg(sky.sun_azimuth_rad).ravel().tolist(),
        "sun_elevation_deg": _degrees(sky.sun_elevation_rad).ravel().tolist(),
        "local_solar_time": map(_clock, np.nan_to_num(sky.solar_time_s.ravel()).tolist()),
    }
    rows = zip(*columns.values(), strict=True)
    points = [SkyPointOut(**dict(zip(columns, row, strict=True))) for row in rows]
    return [
        TargetSkyOut(**dict(zip(_EVENTS, points[3 * window : 3 * window + 3], strict=True)))
        if is_on_earth
        else None
        for window, is_on_earth in enumerate(~np.isnan(sky.azimuth_rad[:, 0]))
    ]


def places_out(sky: "TargetSky") -> list[PlaceOut | None]:
    """One per window, None for targets in space."""
    places = zip(
        _degrees(sky.latitude_rad[:, 1]).tolist(),
        _degrees(sky.longitude_rad[:, 1]).tolist(),
        (np.round(sky.height_m[:, 1], 3) + 0.0).tolist(),
        strict=True,
    )
    return [
        None
        if np.isnan(latitude_deg)
        else PlaceOut(latitude_deg=latitude_deg, longitude_deg=longitude_deg, height_m=height_m)
        for latitude_deg, longitude_deg, height_m in places
    ]


def pass_table_csv(windows: Iterable[Mapping[str, Any]]) -> bytes:
    """One line per window, as answered; empty cells for targets in space."""
    lines = map(_line, windows)
    rows = ([line.get(name) for name in _COLUMNS] for line in lines)
    return csv_lines([_COLUMNS, *rows]).encode()


_OF_EVENT = ("azimuth_deg", "elevation_deg")
_AT_CULMINATION = ("local_solar_time", "sun_azimuth_deg", "sun_elevation_deg")
_COLUMNS = (
    "target",
    *(part for event in _EVENTS for part in (event, *(f"{event}_{angle}" for angle in _OF_EVENT))),
    "duration_s",
    "range_km",
    "off_nadir_deg",
    *_AT_CULMINATION,
)


def _line(window: Mapping[str, Any]) -> dict[str, Any]:
    sky = window["sky"] or {}
    return {
        "target": window["target"],
        "rise": window["rise"],
        "culmination": window["highest_at"],
        "set": window["set"],
        **{f"{event}_{a}": point[a] for event, point in sky.items() for a in _OF_EVENT},
        "duration_s": window["duration_s"],
        "range_km": window["closest"]["range_km"],
        "off_nadir_deg": window["closest"]["off_nadir_deg"],
        **{name: sky["culmination"][name] for name in _AT_CULMINATION if sky},
    }


def _degrees(angle_rad: Array) -> Array:
    return np.asarray(np.round(np.degrees(angle_rad), DECIMALS) + 0.0)  # no -0.0


def _turns_deg(angle_rad: Array) -> Array:
    """In 0..360, the latter excluded."""
    return _degrees(angle_rad) % 360.0


def _clock(since_midnight_s: float) -> str:
    """To the second, which is 15 arcsec of the Sun."""
    whole_s = round(since_midnight_s) % 86400
    return f"{whole_s // 3600:02d}:{whole_s // 60 % 60:02d}:{whole_s % 60:02d}"
