"""Parallel strips over a region of the ground, and where they cross it."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import (
    WGS84_A_M,
    c_enu_from_itrf,
    geodetic_from_itrf,
    itrf_from_geodetic,
)
from planner.world.targets.geojson import Position

Polygon = tuple[tuple[Position, ...], ...]


@dataclass(frozen=True, kw_only=True)
class StripOptions:
    """How strips are laid."""

    beside_track_deg: float = 10.0  # a side of a polygon that near the track's azimuth is taken
    rounding: float = 1e-3  # of a swath: so much more than whole ones needs no other strip


OPTIONS = StripOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class StripPattern:
    """Parallel strips over a region's bounding box in scan direction, in the plane that touches
    the ground at its middle.

    along_enu, across_enu: unit vectors.  from_m, to_m: every strip's ends along; first_aside_m:
    the first one's place across, apart_m: from one to the next.
    """

    r_middle_itrf_m: Array
    c_enu_from_itrf: Array
    along_enu: Array
    across_enu: Array
    from_m: float
    to_m: float
    first_aside_m: float
    apart_m: float
    count: int

    def aside_m(self, number: int) -> float:
        """A strip's place across."""
        return self.first_aside_m + number * self.apart_m

    def positions(
        self, along_m: Array, aside_m: float, down_m: Array | float = 0.0
    ) -> list[Position]:
        """Longitude and latitude of points in the plane, or so far below it, deg."""
        up_enu = np.array([0.0, 0.0, 1.0])
        offsets_enu_m = (
            np.outer(along_m, self.along_enu)
            + aside_m * self.across_enu
            - np.outer(np.broadcast_to(down_m, np.shape(along_m)), up_enu)
        )
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(
            self.r_middle_itrf_m + offsets_enu_m @ self.c_enu_from_itrf
        )
        return [tuple(place) for place in np.rad2deg([longitude_rad, latitude_rad]).T.tolist()]

    def corners(self, ring: tuple[Position, ...], height_m: float) -> Array:
        """Along and across of a closed ring's positions, m, (n, 2)."""
        enu_m = (places_itrf_m(ring, height_m) - self.r_middle_itrf_m) @ self.c_enu_from_itrf.T
        return np.stack([enu_m @ self.along_enu, enu_m @ self.across_enu], axis=1)


def places_itrf_m(positions: Sequence[Position], height_m: float) -> Array:
    """Positions on the ground, (n, 3)."""
    longitude_rad, latitude_rad = np.deg2rad([position[:2] for position in positions]).T
    return itrf_from_geodetic(latitude_rad, longitude_rad, height_m)


def middle_itrf_m(outlines: tuple[tuple[Position, ...], ...], height_m: float) -> Array:
    """The middle of the outlines' corners, on the ground, (3,)."""
    corners_itrf_m = np.concatenate([places_itrf_m(ring[:-1], height_m) for ring in outlines])
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(corners_itrf_m.mean(axis=0))
    return itrf_from_geodetic(latitude_rad, longitude_rad, height_m)


def strip_pattern(
    outlines: tuple[tuple[Position, ...], ...],
    height_m: float,
    azimuth_deg: float | None,
    velocity_passing: Callable[[Array], Array],
    swath_m: float,
    apart_m: float,
) -> StripPattern:
    """Strips of a width, so far apart, over closed rings.

    azimuth_deg: None for the satellite's own, by its velocity over the ground (ITRF) where it
    passes a point, or that of a side within 10 deg of it.
    """
    r_middle_itrf_m = middle_itrf_m(outlines, height_m)
    c_enu = c_enu_from_itrf(*geodetic_from_itrf(r_middle_itrf_m)[:2])
    rings_enu_m = [
        (places_itrf_m(ring[:-1], height_m) - r_middle_itrf_m) @ c_enu.T for ring in outlines
    ]
    if azimuth_deg is None:
        east, north, _ = c_enu @ velocity_passing(r_middle_itrf_m)
        azimuth_rad = _side_azimuth_rad(rings_enu_m, math.atan2(east, north))
    else:
        azimuth_rad = math.radians(azimuth_deg)
    along_enu = np.array([math.sin(azimuth_rad), math.cos(azimuth_rad), 0.0])
    across_enu = np.array([math.cos(azimuth_rad), -math.sin(azimuth_rad), 0.0])
    corners_enu_m = np.concatenate(rings_enu_m)
    along_m, across_m = corners_enu_m @ along_enu, corners_enu_m @ across_enu
    left_m, right_m = across_m.min(), across_m.max()
    more_m = max(right_m - left_m - swath_m, 0.0)
    count = 1 + math.ceil(more_m / apart_m - OPTIONS.rounding * swath_m / apart_m)
    return StripPattern(
        r_middle_itrf_m=r_middle_itrf_m,
        c_enu_from_itrf=c_enu,
        along_enu=along_enu,
        across_enu=across_enu,
        from_m=float(along_m.min()),
        to_m=float(along_m.max()),
        first_aside_m=float(0.5 * (left_m + right_m) - 0.5 * (count - 1) * apart_m),
        apart_m=apart_m,
        count=count,
    )


def strip_pieces(
    pattern: StripPattern,
    polygons: tuple[Polygon, ...],
    height_m: float,
    swath_m: float,
    *,
    gap_m: float,
    least_m: float,
) -> Iterator[list[tuple[Position, Position]]]:
    """Of each strip the ends of its pieces in which any of its width holds a part of a polygon.

    gap_m: pieces no further apart are one.  least_m: none is shorter.
    """
    rings = [[pattern.corners(ring, height_m) for ring in polygon] for polygon in polygons]
    for number in range(pattern.count):
        aside_m = pattern.aside_m(number)
        low_m, high_m = aside_m - 0.5 * swath_m, aside_m + 0.5 * swath_m
        spans_m = [span for polygon in rings for span in _spans_in_band(polygon, low_m, high_m)]
        for shortest_m in (0.0, least_m):  # what is one piece isn't lengthened at its corners
            merged: list[tuple[float, float]] = []
            for begin_m, end_m in sorted(spans_m):
                short_m = max(shortest_m - (end_m - begin_m), 0.0)
                begin_m, end_m = begin_m - 0.5 * short_m, end_m + 0.5 * short_m
                if merged and begin_m - merged[-1][1] <= gap_m:
                    begin_m, before_m = merged.pop()
                    end_m = max(before_m, end_m)
                merged.append((begin_m, end_m))
            spans_m = merged
        pieces = []
        for ends_m in np.array(spans_m):
            # The ground falls away from the plane that touches it.
            down_m = (ends_m**2 + aside_m**2) / (2.0 * WGS84_A_M)
            first, last = pattern.positions(ends_m, aside_m, down_m)
            pieces.append((first, last))
        yield pieces


def _spans_in_band(
    rings_m: list[Array], low_m: float, high_m: float
) -> Iterator[tuple[float, float]]:
    """Spans along in which a polygon, (n, 2) along and across of each ring, is in a band across.

    Between neighbouring corners, and crossings of the band's edges, nothing changes.
    """
    begin = np.concatenate([ring[:-1] for ring in rings_m])
    end = np.concatenate([ring[1:] for ring in rings_m])
    step = end - begin
    bounds = [begin[(begin[:, 1] >= low_m) & (begin[:, 1] <= high_m), 0]]
    for edge_m in (low_m, high_m):
        crosses = (begin[:, 1] > edge_m) != (end[:, 1] > edge_m)
        share = (edge_m - begin[crosses, 1]) / step[crosses, 1]
        bounds.append(begin[crosses, 0] + share * step[crosses, 0])
    along_m = np.unique(np.concatenate(bounds))
    for first_m, last_m in pairwise(along_m.tolist()):
        middle_m = 0.5 * (first_m + last_m)
        crosses = (begin[:, 0] > middle_m) != (end[:, 0] > middle_m)
        share = (middle_m - begin[crosses, 0]) / step[crosses, 0]
        aside_m = np.sort(begin[crosses, 1] + share * step[crosses, 1]).reshape(-1, 2)
        if np.any((aside_m[:, 0] < high_m) & (aside_m[:, 1] > low_m)):
            yield first_m, last_m


def _side_azimuth_rad(rings_enu_m: list[Array], track_rad: float) -> float:
    """Azimuth of the side of a ring nearest the track's, if within 10 deg, else the track's.

    Strips along a side cover a rectangle without one too many.
    """
    sides_enu_m = np.concatenate([np.roll(ring, -1, axis=0) - ring for ring in rings_enu_m])
    off_rad = np.arctan2(sides_enu_m[:, 0], sides_enu_m[:, 1]) - track_rad
    off_rad = (off_rad + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    nearest_rad = float(off_rad[np.argmin(np.abs(off_rad))])
    return track_rad + (
        nearest_rad if abs(nearest_rad) < math.radians(OPTIONS.beside_track_deg) else 0.0
    )
