"""The GeoJSON that is read: lines and polygons on the ground."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Annotated, Literal

from planner.base.spec import Within, spec

# Longitude, latitude and, if given, height in metres: no use is made of it.
Position = tuple[Annotated[float, Within(-1000.0, 100e3)], ...]


@dataclass(frozen=True, kw_only=True)
class GeoJsonBounds:
    """What a geometry may be."""

    leg_most_km: float = 2000.0  # the shorter way round is plain, the plane's line near a geodesic
    area_least_km2: float = 1.0  # less is a line
    parts_most: int = 16  # rings of a polygon, polygons or lines together: checked pair by pair
    earth_radius_km: float = 6371.0  # of the sphere that these are measured on


BOUNDS = GeoJsonBounds()


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
            if apart_km > BOUNDS.leg_most_km:
                raise ValueError(
                    f"positions {number} and {number + 1} are {apart_km:.0f} km apart; a leg has "
                    f"at most {BOUNDS.leg_most_km:.0f} km: put positions between"
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
    return 2.0 * BOUNDS.earth_radius_km * math.asin(math.sqrt(min(half, 1.0)))


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
class GeoMultiLineString:
    """Several GeoJSON lines, each as a LineString.

    coordinates: lines, each a list of positions [longitude, latitude]. E.g.
        `[[[-12.4, 20.5], [-12.5, 21.0]], [[-12.3, 21.6], [-12.4, 22.0]]]`. [deg]
    """

    type: Literal["MultiLineString"] = "MultiLineString"
    coordinates: tuple[tuple[Position, ...], ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.coordinates) <= BOUNDS.parts_most:
            raise ValueError(f"it has 1 to {BOUNDS.parts_most} lines, not {len(self.coordinates)}")
        for line in self.coordinates:
            GeoLineString(coordinates=line)


@spec
class GeoPolygon:
    """A GeoJSON polygon, in either winding; its sides lie in planes like a line's.

    A side goes the shorter way round: from 179.8 to -179.8 over 0.4 deg.

    coordinates: closed rings of positions [longitude, latitude], WGS84, east and north positive:
        the outline, then any holes [deg]
    """

    type: Literal["Polygon"] = "Polygon"
    coordinates: tuple[tuple[Position, ...], ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.coordinates) <= BOUNDS.parts_most:
            raise ValueError(
                f"a polygon has an outline and up to {BOUNDS.parts_most - 1} holes, not "
                f"{len(self.coordinates)} rings"
            )
        rings = []
        for ring in self.coordinates:
            if not 4 <= len(ring) <= 64 or ring[0] != ring[-1]:
                raise ValueError("a ring has 4 to 64 positions and ends where it begins")
            _check_positions(ring)
            rings.append(_unwrap_longitudes((self.coordinates[0][0], *ring))[1:])
            self._require_area(rings[-1])
        for number, hole in enumerate(rings[1:], start=1):
            if not all(_is_inside(position, rings[0]) for position in hole):
                raise ValueError(f"ring {number} is no hole: it reaches out of the outline, ring 0")
            for other, before in enumerate(rings[:number]):
                if any(_legs_cross(*a, *b) for a in pairwise(hole) for b in pairwise(before)):
                    raise ValueError(f"ring {number} meets ring {other}; join them, or part them")
                if other and (_is_inside(hole[0], before) or _is_inside(before[0], hole)):
                    raise ValueError(f"ring {number} and ring {other} are holes in one another")

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
        area_km2 = abs(twice_deg2) / 2.0 * cosine * math.radians(BOUNDS.earth_radius_km) ** 2
        if area_km2 < BOUNDS.area_least_km2:
            raise ValueError(
                f"the ring encloses {area_km2:.3g} km2; an area has at least "
                f"{BOUNDS.area_least_km2:g} km2: image a line as a strip"
            )


def _is_inside(point: Position, ring: list[Position]) -> bool:
    """Whether a ray to the east crosses the ring an odd number of times."""
    return bool(
        sum(
            (a[1] > point[1]) != (b[1] > point[1])
            and point[0] < a[0] + (point[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
            for a, b in pairwise(ring)
        )
        % 2
    )


@spec
class GeoMultiPolygon:
    """Several GeoJSON polygons, each as a Polygon; what two of them share is one ground.

    coordinates: polygons, each a list of closed rings of positions [longitude, latitude]. E.g.
        `[[[[-19.8, 44.0], [-19.9, 44.4], [-19.6, 44.4], [-19.8, 44.0]]]]`. [deg]
    """

    type: Literal["MultiPolygon"] = "MultiPolygon"
    coordinates: tuple[tuple[tuple[Position, ...], ...], ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.coordinates) <= BOUNDS.parts_most:
            raise ValueError(
                f"it has 1 to {BOUNDS.parts_most} polygons, not {len(self.coordinates)}"
            )
        for polygon in self.coordinates:
            GeoPolygon(coordinates=polygon)
