"""Reads requests for an imaging session."""

from typing import Any

from app.requests.json_reader import JsonReader
from planner.spacecraft.features import requests_from_features
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.vehicle import SPACECRAFT


def _with_plain_requests(document: object) -> object:
    if not isinstance(document, dict) or not isinstance(document.get("requests"), dict):
        return document
    return document | {"requests": requests_from_features(document["requests"])}


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
