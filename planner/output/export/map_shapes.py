"""Lines and areas of the globe as maps draw them: cut where the longitude starts anew.

Source: RFC 7946, sections 3.1.6 and 3.1.9.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import c_enu_from_itrf, itrf_from_geodetic

DECIMALS = 6  # 0.1 m
_TURN_DEG, _HALF_DEG = 360.0, 180.0


@dataclass(frozen=True, eq=False)
class Point:
    """A point; longitude and latitude in degrees, height above the ellipsoid."""

    longitude_deg: float
    latitude_deg: float
    height_m: float


@dataclass(frozen=True, eq=False)
class Lines:
    """Parts of a line, each (k, 2): longitude within -180..180 and latitude, in degrees."""

    parts_deg: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Areas:
    """Rings without holes, counter-clockwise and closed, each (k, 2) as of `Lines`."""

    rings_deg: tuple[Array, ...]


Shape = Point | Lines | Areas


def line(latitude_rad: Array, longitude_rad: Array) -> Lines:
    """Through places, (n,) each, that are less than half a turn of longitude apart."""
    return Lines(tuple(_cut_line(_unwrapped(latitude_rad, longitude_rad))))


def areas(rings_rad: Sequence[tuple[Array, Array]]) -> Areas:
    """Inside rings of places, latitudes and longitudes, (n,) each, open or closed.

    A ring about a pole is led along the map's edge over the pole.
    """
    return Areas(tuple(part for ring in rings_rad for part in _cut_ring(_unwrapped(*ring))))


def hull(latitude_rad: Array, longitude_rad: Array) -> tuple[Array, Array]:
    """Latitudes and longitudes of the smallest convex ring about places, (n,) each.

    Convex on the map that shows great circles as straight lines; for places within a quarter of
    the globe.
    """
    # SciPy's geometry takes 0.1 s to import, which only a map should pay.
    from scipy.spatial import ConvexHull

    r_itrf = itrf_from_geodetic(latitude_rad, longitude_rad, 0.0)
    middle = r_itrf.mean(axis=0)
    middle_rad = np.arcsin(middle[2] / np.linalg.norm(middle)), np.arctan2(middle[1], middle[0])
    east, north, up = c_enu_from_itrf(*middle_rad) @ r_itrf.T
    around = ConvexHull(np.stack([east / up, north / up], axis=1)).vertices
    return latitude_rad[around], longitude_rad[around]


def _unwrapped(latitude_rad: Array, longitude_rad: Array) -> Array:
    """Longitude and latitude in degrees, (n, 2), neighbours within half a turn."""
    return np.degrees(np.stack([np.unwrap(longitude_rad), latitude_rad], axis=1))


def _cut_line(place_deg: Array) -> Iterator[Array]:
    sheet = np.floor((place_deg[:, 0] + _HALF_DEG) / _TURN_DEG).astype(int).tolist()
    first = 0
    start: list[Array] = []
    for k in np.flatnonzero(np.diff(sheet)).tolist():
        edge_deg = _TURN_DEG * max(sheet[k], sheet[k + 1]) - _HALF_DEG
        share = (edge_deg - place_deg[k, 0]) / (place_deg[k + 1, 0] - place_deg[k, 0])
        crossing = np.array(
            [[edge_deg, place_deg[k, 1] + share * (place_deg[k + 1, 1] - place_deg[k, 1])]]
        )
        yield _shifted(np.concatenate([*start, place_deg[first : k + 1], crossing]), sheet[k])
        first, start = k + 1, [crossing]
    yield _shifted(np.concatenate([*start, place_deg[first:]]), sheet[-1])


def _cut_ring(place_deg: Array) -> Iterator[Array]:
    round_deg = np.unwrap(np.append(place_deg[:, 0], place_deg[0, 0]), period=_TURN_DEG)
    turns_deg = round_deg[-1] - place_deg[0, 0]
    if abs(turns_deg) > _HALF_DEG:
        pole_deg = np.copysign(90.0, place_deg[:, 1].mean())
        last = np.array([[place_deg[0, 0] + turns_deg, place_deg[0, 1]]])
        over = np.array([[last[0, 0], pole_deg], [place_deg[0, 0], pole_deg]])
        place_deg = np.concatenate([place_deg, last, over])
    lowest, highest = (
        math.floor((end_deg + _HALF_DEG) / _TURN_DEG)
        for end_deg in (place_deg[:, 0].min(), place_deg[:, 0].max())
    )
    for sheet in range(lowest, highest + 1):
        west_deg = _TURN_DEG * sheet - _HALF_DEG
        part = _east_of(place_deg, west_deg)
        part = _east_of(part * [-1.0, 1.0], -west_deg - _TURN_DEG) * [-1.0, 1.0]
        if len(part) >= 3:
            yield _shifted(_closed(part), sheet)


def _east_of(ring_deg: Array, west_deg: float) -> Array:
    """The part of a ring (n, 2) beyond a meridian.  Source: Sutherland, Hodgman 1974."""
    kept: list[Array] = []
    for here, after in zip(ring_deg, np.roll(ring_deg, -1, axis=0), strict=True):
        inside, next_inside = here[0] >= west_deg, after[0] >= west_deg
        if inside:
            kept.append(here)
        if inside != next_inside:
            share = (west_deg - here[0]) / (after[0] - here[0])
            kept.append(here + share * (after - here))
    return np.array(kept).reshape(-1, 2)


def _closed(ring_deg: Array) -> Array:
    """Counter-clockwise, the first place again at the end."""
    x, y = ring_deg.T
    twice = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    ring_deg = ring_deg if twice >= 0.0 else ring_deg[::-1]
    return np.concatenate([ring_deg, ring_deg[:1]])


def _shifted(place_deg: Array, sheet_index: int) -> Array:
    """Longitudes within -180..180, rounded."""
    return np.round(place_deg - [_TURN_DEG * sheet_index, 0.0], DECIMALS) + 0.0  # no -0.0
