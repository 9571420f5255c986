"""The ground arcs that the scans of a request follow, in every order they may be scanned."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from planner.base.arrays import Array
from planner.spacecraft.geojson import Position
from planner.spacecraft.imaging.ground_arc import GroundArc
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.requests import (
    AreaRequest,
    CorridorRequest,
    ImagingRequest,
    Request,
    StereoRequest,
)
from planner.spacecraft.table import TICK_S
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf, itrf_from_geodetic

BESIDE_TRACK_RAD = math.radians(10.0)  # a side of a polygon that near the track's azimuth is taken


def scan_orders(request: Request, session: ImagingSession) -> list[list[GroundArc]]:
    """The request's arcs in each order and sense they may be scanned, times open (start_s = 0).

    A corridor's legs as they are given, other arcs in the sense of flight; by a reversible
    detector to and fro.
    """
    if isinstance(request, AreaRequest):
        arcs = _cut_strips(request, session)
    else:
        arcs = [_arc(start, end, request) for start, end in pairwise(request.geometry.coordinates)]
    if isinstance(request, CorridorRequest):
        return [arcs]
    forward = [_along_flight(arc, session) for arc in arcs]
    if not session.spacecraft.camera.reversible:
        return [forward]
    senses = [(arc, replace(arc.turned_round(), backwards=True)) for arc in forward]
    return [[both[(k + first) % 2] for k, both in enumerate(senses)] for first in (0, 1)]


def _arc(start: Position, end: Position, request: ImagingRequest) -> GroundArc:
    arc = GroundArc(
        latitude_rad=(math.radians(start[1]), math.radians(end[1])),
        longitude_rad=(math.radians(start[0]), math.radians(end[0])),
        height_m=request.height_m,
        start_s=0.0,
        duration_s=1.0,
    )
    return replace(arc, duration_s=arc.length_m() / request.scan_speed_m_s)


@dataclass(frozen=True, kw_only=True, eq=False)
class _StripPattern:
    """Parallel strips over a polygon's bounding box in scan direction, in the plane that touches
    the ground at its middle.

    along_enu, across_enu: unit vectors.  from_m, to_m: every strip's ends along; first_aside_m:
    the first one's place across.
    """

    r_middle_itrf_m: Array
    c_enu_from_itrf: Array
    along_enu: Array
    across_enu: Array
    from_m: float
    to_m: float
    first_aside_m: float
    swath_m: float
    count: int


def least_time_s(request: Request, session: ImagingSession) -> tuple[int, float]:
    """How many scans a request is, and no less than the time they and the slews between take."""
    if isinstance(request, AreaRequest):
        pattern = _strip_pattern(request, session)
        scans = pattern.count
        scan_s = scans * (pattern.to_m - pattern.from_m) / request.scan_speed_m_s
    else:
        arcs = [_arc(start, end, request) for start, end in pairwise(request.geometry.coordinates)]
        looks = 2 if isinstance(request, StereoRequest) else 1
        scans, scan_s = looks * len(arcs), looks * sum(arc.duration_s for arc in arcs)
    return scans, scan_s + (scans - 1) * max(session.spacecraft.slew.settle_s, TICK_S)


def _strip_pattern(request: AreaRequest, session: ImagingSession) -> _StripPattern:
    longitude_rad, latitude_rad = np.deg2rad(
        [p[:2] for p in request.geometry.coordinates[0][:-1]]
    ).T
    corners_itrf_m = itrf_from_geodetic(latitude_rad, longitude_rad, request.height_m)
    middle_rad = geodetic_from_itrf(corners_itrf_m.mean(axis=0))[:2]
    r_middle_itrf_m = itrf_from_geodetic(*middle_rad, request.height_m)
    c_enu = c_enu_from_itrf(*middle_rad)
    corners_enu_m = (corners_itrf_m - r_middle_itrf_m) @ c_enu.T
    if request.azimuth_deg is None:
        east, north, _ = c_enu @ session.velocity_passing(r_middle_itrf_m)
        azimuth_rad = _side_azimuth_rad(corners_enu_m, math.atan2(east, north))
    else:
        azimuth_rad = math.radians(request.azimuth_deg)
    along_enu = np.array([math.sin(azimuth_rad), math.cos(azimuth_rad), 0.0])
    across_enu = np.array([math.cos(azimuth_rad), -math.sin(azimuth_rad), 0.0])
    along_m, across_m = corners_enu_m @ along_enu, corners_enu_m @ across_enu
    left_m, right_m = across_m.min(), across_m.max()
    swath_m = session.spacecraft.camera.swath_m
    count = max(1, math.ceil((right_m - left_m) / swath_m - 1e-3))
    return _StripPattern(
        r_middle_itrf_m=r_middle_itrf_m,
        c_enu_from_itrf=c_enu,
        along_enu=along_enu,
        across_enu=across_enu,
        from_m=float(along_m.min()),
        to_m=float(along_m.max()),
        first_aside_m=float(0.5 * (left_m + right_m) - 0.5 * (count - 1) * swath_m),
        swath_m=swath_m,
        count=count,
    )


def _cut_strips(request: AreaRequest, session: ImagingSession) -> list[GroundArc]:
    """Parallel strips over the polygon's bounding box in scan direction."""
    pattern = _strip_pattern(request, session)
    arcs = []
    for k in range(pattern.count):
        aside_m = pattern.first_aside_m + k * pattern.swath_m
        ends_itrf_m = [
            pattern.r_middle_itrf_m
            + (end_m * pattern.along_enu + aside_m * pattern.across_enu) @ pattern.c_enu_from_itrf
            for end_m in (pattern.from_m, pattern.to_m)
        ]
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(np.array(ends_itrf_m))
        start, end = np.rad2deg([longitude_rad, latitude_rad]).T.tolist()
        arcs.append(_arc(tuple(start), tuple(end), request))
    return arcs


def _side_azimuth_rad(corners_enu_m: Array, track_rad: float) -> float:
    """Azimuth of the side of the polygon nearest the track's, if within 10 deg, else the track's.

    Strips along a side cover a rectangle without one too many.
    """
    sides_enu_m = np.roll(corners_enu_m, -1, axis=0) - corners_enu_m
    off_rad = np.arctan2(sides_enu_m[:, 0], sides_enu_m[:, 1]) - track_rad
    off_rad = (off_rad + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    nearest_rad = float(off_rad[np.argmin(np.abs(off_rad))])
    return track_rad + (nearest_rad if abs(nearest_rad) < BESIDE_TRACK_RAD else 0.0)


def _along_flight(arc: GroundArc, session: ImagingSession) -> GroundArc:
    """The arc in the sense of the flight."""
    (start_itrf_m, end_itrf_m), _ = arc.point_itrf(np.array([0.0, 1.0]))
    v_itrf_m_s = session.velocity_passing(start_itrf_m)
    return arc if (end_itrf_m - start_itrf_m) @ v_itrf_m_s >= 0.0 else arc.turned_round()
