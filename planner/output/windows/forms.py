"""Windows, as they are answered in JSON, for maps (GeoJSON, RFC 7946) and as a pass table (CSV)."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from planner.base.csv_cells import csv_lines
from planner.output.windows.rows import EVENTS

# Of `closest`, which is told as it is.
_CLOSEST = (
    "range_km",
    "off_nadir_deg",
    "ground_sample_across_m",
    "ground_sample_along_m",
    "sun_separation_deg",
    "moon_separation_deg",
)
_TOLD = ("target", "rise", "set", "duration_s", "session", "highest_at", "highest_deg")
_OF_EVENT = ("azimuth_deg", "elevation_deg")
_AT_CULMINATION = ("local_solar_time", "sun_azimuth_deg", "sun_elevation_deg")
PASS_COLUMNS = (
    "target",
    *(part for event in EVENTS for part in (event, *(f"{event}_{angle}" for angle in _OF_EVENT))),
    "duration_s",
    "range_km",
    "off_nadir_deg",
    *_AT_CULMINATION,
)


def pass_table_csv(texts: Sequence[str]) -> str:
    """A line per window, of the JSON of each with its view."""
    return csv_lines(_pass_cells(json.loads(text)) for text in texts)


def features_json(texts: Sequence[str]) -> str:
    """A Feature per window, with commas between."""
    features = (_feature(json.loads(text)) for text in texts)
    return ",".join(json.dumps(one, separators=(",", ":"), ensure_ascii=False) for one in features)


def _pass_cells(window: Mapping[str, Any]) -> list[Any]:
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


def _feature(window: Mapping[str, Any]) -> dict[str, Any]:
    """A Feature of a window as answered."""
    sky, scan = window["sky"] or {}, window.get("scan")
    return {
        "type": "Feature",
        "id": f"{window['target']}/{window['rise']}" + (f"/{scan['part']}" if scan else ""),
        "geometry": _geometry(window),
        "properties": {
            "datetime": f"{window['rise']}/{window['set']}",
            **{name: window[name] for name in _TOLD},
            **{name: window["closest"][name] for name in _CLOSEST},
            **{f"{event}_azimuth_deg": point["azimuth_deg"] for event, point in sky.items()},
            **{f"{event}_elevation_deg": point["elevation_deg"] for event, point in sky.items()},
            **{
                name: sky["culmination"][name] if sky else None
                for name in ("local_solar_time", "sun_azimuth_deg", "sun_elevation_deg")
            },
        },
    }


def _geometry(window: Mapping[str, Any]) -> Mapping[str, Any] | None:
    if scan := window.get("scan"):
        line = [_coordinates(point) for point in scan["target"]["points"]]
        return {"type": "LineString", "coordinates": line}
    place = window["place"]
    return None if place is None else {"type": "Point", "coordinates": _coordinates(place)}


def _coordinates(place: Mapping[str, float]) -> list[float]:
    return [place[name] for name in ("longitude_deg", "latitude_deg", "height_m") if name in place]
