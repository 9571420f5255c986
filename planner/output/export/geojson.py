"""A plan's map as GeoJSON.  Source: RFC 7946."""

import json
from datetime import datetime
from typing import Any

from planner.output.export.map_features import MapFeature, PlanMap
from planner.output.export.map_shapes import Areas, Lines, Point, Shape
from planner.output.export.plan_map import map_of
from planner.world.frames.time_scales import utc_text
from planner.world.plan import FlightPlan


def write_geojson(plan: FlightPlan, created_utc: datetime) -> bytes:
    """The ground track, where the boresight went, each session's swath, footprints and target."""
    return geojson_of(map_of(plan, created_utc))


def geojson_of(shown: PlanMap) -> bytes:
    """A FeatureCollection; properties say `kind`, `name`, `start` and `stop`."""
    collection = {
        "type": "FeatureCollection",
        "name": shown.name,
        "notes": list(shown.notes),
        "features": [_feature(feature) for feature in shown.features],
    }
    return json.dumps(collection, allow_nan=False, separators=(",", ":")).encode()


def _feature(feature: MapFeature) -> dict[str, Any]:
    times = {"start": feature.start_utc, "stop": feature.stop_utc}
    told = {name: utc_text(moment) for name, moment in times.items() if moment is not None}
    return {
        "type": "Feature",
        "geometry": _geometry(feature.shape),
        "properties": {"kind": feature.kind, "name": feature.name, **told, **feature.facts},
    }


def _geometry(shape: Shape) -> dict[str, Any]:
    """The simple kind where there is one part."""
    if isinstance(shape, Point):
        place = [shape.longitude_deg, shape.latitude_deg, shape.height_m]
        return {"type": "Point", "coordinates": place}
    if isinstance(shape, Lines):
        return _one_or_many("LineString", [part.tolist() for part in shape.parts_deg])
    assert isinstance(shape, Areas)
    return _one_or_many("Polygon", [[ring.tolist()] for ring in shape.rings_deg])


def _one_or_many(kind: str, parts: list[Any]) -> dict[str, Any]:
    if len(parts) == 1:
        return {"type": kind, "coordinates": parts[0]}
    return {"type": f"Multi{kind}", "coordinates": parts}
