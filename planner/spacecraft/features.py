"""Requests as a GeoJSON FeatureCollection."""

from planner.base.errors import InvalidMessage


def requests_from_features(collection: dict[str, object]) -> list[dict[str, object]]:
    """Fields of each request of a FeatureCollection, in the features' order.

    A Feature's properties are a request's other fields (mode, name, priority, ...); what comes
    out is plain data for the request's schema to check.  Raises InvalidMessage.
    """
    features = collection.get("features")
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
