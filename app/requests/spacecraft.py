"""Reads requests for an imaging session."""

from typing import Any

from app.requests.json_reader import JsonReader
from planner.base.errors import InvalidMessage
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.vehicle import SPACECRAFT


def _with_plain_requests(document: object) -> object:
    """A FeatureCollection's features as requests, in their order, for the schema to check."""
    if not isinstance(document, dict) or not isinstance(document.get("requests"), dict):
        return document
    features = document["requests"].get("features")
    if not isinstance(features, list) or not features:
        raise InvalidMessage("a FeatureCollection with at least one feature is needed")
    requests = []
    for number, feature in enumerate(features):
        match feature:
            case {"properties": dict(properties), "geometry": dict(geometry)}:
                requests.append({**properties, "geometry": geometry})
            case _:
                raise InvalidMessage(
                    f"features.{number} needs `properties` with mode and name, and a `geometry`",
                    field=f"features.{number}",
                )
    return document | {"requests": requests}


def _add_features(schema: dict[str, Any]) -> None:
    schema["properties"]["spacecraft"]["enum"] = list(SPACECRAFT)
    features = {
        "type": "object",
        "description": "GeoJSON FeatureCollection: each Feature's properties are a request's "
        "other fields (mode, name, priority, ...)",
        "required": ["features"],
    }
    schema["properties"]["requests"] = {"anyOf": [schema["properties"]["requests"], features]}


# `requests` may be a GeoJSON FeatureCollection; InvalidMessage for what is no GeoJSON.
SPACECRAFT_READER = JsonReader(ImagingPlanRequest, _with_plain_requests, _add_features)

read_spacecraft_request = SPACECRAFT_READER.read
