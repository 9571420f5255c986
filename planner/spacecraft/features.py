"""Requests as a GeoJSON FeatureCollection."""

import json

from planner.base.errors import InvalidMessage
from planner.base.spec import is_kept

CHARACTERS_MAX = 1_000_000


def requests_from_features(text: str) -> list[dict[str, object]]:
    """Fields of each request of a FeatureCollection, in the features' order.

    A Feature's properties are a request's other fields (mode, name, priority, ...); what comes
    out is plain data for the request's schema to check.  Raises InvalidMessage.
    """
    if len(text) > CHARACTERS_MAX and not is_kept():
        raise InvalidMessage(
            f"the GeoJSON has {len(text)} characters; the most is {CHARACTERS_MAX}"
        )
    try:
        collection = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidMessage(f"this is no JSON: {error}") from None
    features = collection.get("features") if isinstance(collection, dict) else None
    if not isinstance(features, list) or not features:
        raise InvalidMessage("a FeatureCollection with at least one feature is needed")
    return [_feature_fields(number, feature) for number, feature in enumerate(features)]


def _feature_fields(number: int, feature: object) -> dict[str, object]:
    if isinstance(feature, dict):
        properties, geometry = feature.get("properties"), feature.get("geometry")
        if isinstance(properties, dict) and isinstance(geometry, dict):
            return {**properties, "geometry": geometry}
    raise InvalidMessage(
        f"features.{number} needs `properties` with mode and name, and a `geometry`",
        field=f"features.{number}",
    )
