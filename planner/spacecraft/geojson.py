"""The GeoJSON that is read: lines and polygons, and requests as a FeatureCollection."""

import json
import math
from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import Annotated, Literal

from planner.base.errors import InvalidMessage
from planner.base.spec import Within, is_kept, spec

# Longitude, latitude and, if given, height in metres: no use is made of it.
Position = tuple[Annotated[float, Within(-1000.0, 100e3)], ...]
CHARACTERS_MAX = 1_000_000
LEG_MAX_KM = 2000.0
AREA_MIN_KM2 = 1.0
EARTH_RADIUS_KM = 6371.0


def _check_positions(positions: tuple[Position, ...]) -> None:
    for position in positions:
        if len(position) not in (2, 3) or not all(math.isfinite(x) for x in position):
            raise ValueError(f"a position is [longitude, latitude] in degrees, not {position}")
        if not (-180.0 <= position[0] <= 360.0 and -89.0 <= position[1] <= 89.0):
            raise ValueError(
                f"position {position} is off the map: longitude -180..360, latitude -89..89, "
                "in this order"
            )


@spec
class GeoLineString:
    """A GeoJSON line, in the plane through each two positions and the Earth's centre.

    So it is scanned, not straight in longitude and latitude as RFC 7946 has it: at 45 deg of
    latitude and at right angles to the meridian 70 m poleward of that in the middle of 60 km, 4
    times as much of 120 km.

    coordinates: positions [longitude, latitude], WGS84, east and north positive; between two
        the line lies in the plane through both and the Earth's centre [deg]
    """

    type: Literal["LineString"] = "LineString"
    coordinates: tuple[Position, ...]

    def __post_init__(self) -> None:
        if not 2 <= len(self.coordinates) <= 64:
            raise ValueError(f"a line has 2 to 64 positions, not {len(self.coordinates)}")
        _check_positions(self.coordinates)
        for number, (a, b) in enumerate(pairwise(self.coordinates)):
            apart_km = _apart_km(a, b)
            if apart_km < 1.0:
                raise ValueError(f"positions {number} and {number + 1} are less than 1 km apart")
            if apart_km > LEG_MAX_KM:
                raise ValueError(
                    f"positions {number} and {number + 1} are {apart_km:.0f} km apart; a leg has "
                    f"at most {LEG_MAX_KM:.0f} km: put positions between"
                )
        last = len(self.coordinates) - 1
        for i, j in _crossing_legs(_unwrap_longitudes(self.coordinates)):
            raise ValueError(
                f"the line crosses itself: leg {i} and leg {j} meet; split it into two "
                f"requests, positions 0 to {j} and {j} to {last}"
            )


def _apart_km(a: Position, b: Position) -> float:
    """Great circle on a sphere."""
    north = math.radians(b[1] - a[1])
    east = math.radians(b[0] - a[0])
    cosines = math.cos(math.radians(a[1])) * math.cos(math.radians(b[1]))
    half = math.sin(north / 2.0) ** 2 + cosines * math.sin(east / 2.0) ** 2
    return 2.0 * EARTH_RADIUS_KM * math.asin(math.sqrt(min(half, 1.0)))


def _unwrap_longitudes(line: tuple[Position, ...]) -> list[Position]:
    """The positions, none more than half a turn of longitude from the one before."""
    found = [line[0]]
    for position in line[1:]:
        turns = round((position[0] - found[-1][0]) / 360.0)
        found.append((position[0] - 360.0 * turns, position[1]))
    return found


def _crossing_legs(positions: list[Position]) -> Iterator[tuple[int, int]]:
    """Pairs of legs that meet, other than one with the next."""
    for (i, (a, b)), (j, (c, d)) in combinations(enumerate(pairwise(positions)), 2):
        if j > i + 1 and _legs_cross(a, b, c, d):
            yield i, j


def _legs_cross(a: Position, b: Position, c: Position, d: Position) -> bool:
    def side(p: Position, q: Position, r: Position) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    overlap = all(
        max(min(a[k], b[k]), min(c[k], d[k])) <= min(max(a[k], b[k]), max(c[k], d[k]))
        for k in (0, 1)
    )
    return overlap and side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0


@spec
class GeoPolygon:
    """A GeoJSON polygon without holes, in either winding; its sides lie in planes like a line's.

    A side goes the shorter way round: from 179.8 to -179.8 over 0.4 deg.

    coordinates: one closed ring of positions [longitude, latitude], WGS84, east and north positive
        [deg]
    """

    type: Literal["Polygon"] = "Polygon"
    coordinates: tuple[tuple[Position, ...], ...]

    def __post_init__(self) -> None:
        if len(self.coordinates) != 1:
            raise ValueError(f"a polygon has one ring and no holes, not {len(self.coordinates)}")
        ring = self.coordinates[0]
        if not 4 <= len(ring) <= 64 or ring[0] != ring[-1]:
            raise ValueError("a ring has 4 to 64 positions and ends where it begins")
        _check_positions(ring)
        self._require_area(_unwrap_longitudes(ring))

    def _require_area(self, ring: list[Position]) -> None:
        for i, (a, b) in enumerate(pairwise(ring)):
            if a[:2] == b[:2]:
                raise ValueError(
                    f"positions {i} and {i + 1} of the ring are the same: leave one out"
                )
        for i, j in _crossing_legs(ring):
            if (i, j) != (0, len(ring) - 2):  # which meet where the ring ends
                raise ValueError(
                    f"the ring crosses itself: side {i} and side {j} meet; give its positions in "
                    "the order in which they follow each other around the area"
                )
        cosine = math.cos(math.radians(sum(p[1] for p in ring) / len(ring)))
        twice_deg2 = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(ring))
        area_km2 = abs(twice_deg2) / 2.0 * cosine * math.radians(EARTH_RADIUS_KM) ** 2
        if area_km2 < AREA_MIN_KM2:
            raise ValueError(
                f"the ring encloses {area_km2:.3g} km2; an area has at least {AREA_MIN_KM2:g} km2: "
                "image a line as a strip"
            )


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
