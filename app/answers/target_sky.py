"""The pass in the target's sky, as in pass tables: rise, culmination and set."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from app.answers.ranges import ElevationDeg, Signed, TurnDeg
from planner.base.arrays import Array, Indices

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


def sky_columns(sky: "TargetSky", rows: Indices) -> dict[str, dict[str, Any]]:
    """By event and the names of a `SkyPointOut`, of windows on the Earth, `t_s` for the time."""
    return {
        event: {
            "t_s": sky.t_s[rows, n],
            "azimuth_deg": _turns_deg(sky.azimuth_rad[rows, n]),
            "elevation_deg": np.degrees(sky.elevation_rad[rows, n]),
            "sun_azimuth_deg": _turns_deg(sky.sun_azimuth_rad[rows, n]),
            "sun_elevation_deg": np.degrees(sky.sun_elevation_rad[rows, n]),
            "local_solar_time": [f'"{_clock(one)}"' for one in sky.solar_time_s[rows, n].tolist()],
        }
        for n, event in enumerate(_EVENTS)
    }


def place_columns(sky: "TargetSky", rows: Indices) -> dict[str, Array]:
    """By the names of a `PlaceOut`, of windows on the Earth."""
    return {
        "latitude_deg": np.degrees(sky.latitude_rad[rows, 1]),
        "longitude_deg": np.degrees(sky.longitude_rad[rows, 1]),
        "height_m": np.round(sky.height_m[rows, 1], 3),
    }


_OF_EVENT = ("azimuth_deg", "elevation_deg")
_AT_CULMINATION = ("local_solar_time", "sun_azimuth_deg", "sun_elevation_deg")
PASS_COLUMNS = (
    "target",
    *(part for event in _EVENTS for part in (event, *(f"{event}_{angle}" for angle in _OF_EVENT))),
    "duration_s",
    "range_km",
    "off_nadir_deg",
    *_AT_CULMINATION,
)


def pass_cells(window: Mapping[str, Any]) -> list[Any]:
    """Its line of a pass table, by `PASS_COLUMNS`; empty cells for targets in space."""
    sky = window["sky"] or {}
    line = {
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
    return [line.get(name) for name in PASS_COLUMNS]


def _turns_deg(angle_rad: Array) -> Array:
    """In 0..360, the latter excluded."""
    return np.asarray(np.round(np.degrees(angle_rad), DECIMALS) % 360.0)


def _clock(since_midnight_s: float) -> str:
    """To the second, which is 15 arcsec of the Sun."""
    whole_s = round(since_midnight_s) % 86400
    return f"{whole_s // 3600:02d}:{whole_s // 60 % 60:02d}:{whole_s % 60:02d}"
