"""Windows as GeoJSON (RFC 7946), one Feature each."""

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

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


class FeatureCollection(BaseModel):
    """GeoJSON: a Feature a window, a point or the request's own geometry, null in space.

    features: `properties` hold `target`, `datetime` (rise and set with a slash between, as STAC
    and STAPI have it), rise, set, session, the view at the closest approach, azimuths, local solar
    time and the Sun.
    """

    model_config = ConfigDict(extra="allow")

    type: str = Field(json_schema_extra={"const": "FeatureCollection"})
    features: list[dict[str, Any]]


def feature(window: Mapping[str, Any]) -> dict[str, Any]:
    """A Feature of a window as answered."""
    sky = window["sky"] or {}
    return {
        "type": "Feature",
        "id": f"{window['target']}/{window['rise']}",
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
    if given := window.get("geometry"):
        return dict(given)
    place = window["place"]
    if place is None:
        return None
    coordinates = [place[name] for name in ("longitude_deg", "latitude_deg", "height_m")]
    return {"type": "Point", "coordinates": coordinates}
