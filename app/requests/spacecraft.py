"""Reads a request for an imaging session."""

import json
from typing import Any

from app.requests.json_reader import JsonReader
from planner.spacecraft.geojson import requests_from_features
from planner.spacecraft.opportunity_request import ImagingOpportunityRequest
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.vehicle.definition import SPACECRAFT


def _with_plain_requests(document: object) -> object:
    if not isinstance(document, dict) or not isinstance(document.get("requests"), dict):
        return document
    return document | {"requests": requests_from_features(json.dumps(document["requests"]))}


_READER = JsonReader(ImagingPlanRequest, plain=_with_plain_requests)
_SEARCH_READER = JsonReader(ImagingOpportunityRequest, plain=_with_plain_requests)


def read_spacecraft_request(body: bytes) -> ImagingPlanRequest:
    """The session a JSON text describes; `requests` may be a GeoJSON FeatureCollection.

    Raises InvalidRequest with the fields at fault, InvalidMessage for what is no GeoJSON.
    """
    return _READER.read(body)


read_kept_spacecraft_request = _READER.read_kept


def read_imaging_opportunity_request(body: bytes) -> ImagingOpportunityRequest:
    """What is to be imaged, and when it is searched for; raises as above."""
    return _SEARCH_READER.read(body)


def spacecraft_request_json_schema(ref_template: str) -> dict[str, Any]:
    """JSON Schema of the request; its `$defs` hold what it refers to by `ref_template`."""
    return _with_features(_READER.json_schema(ref_template))


def imaging_opportunity_json_schema(ref_template: str) -> dict[str, Any]:
    """The same of a search."""
    return _with_features(_SEARCH_READER.json_schema(ref_template))


def _with_features(schema: dict[str, Any]) -> dict[str, Any]:
    schema["properties"]["spacecraft"]["enum"] = list(SPACECRAFT)
    features = {
        "type": "object",
        "description": "GeoJSON FeatureCollection: each Feature's properties are a request's "
        "other fields (mode, name, priority, ...)",
        "required": ["features"],
    }
    schema["properties"]["requests"] = {"anyOf": [schema["properties"]["requests"], features]}
    return schema
