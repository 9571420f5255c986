"""The ground arcs that the scans of a request follow, in every order they may be scanned."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.spacecraft.imaging.session import GroundArc, ImagingSession
from planner.spacecraft.requests import (
    AreaRequest,
    CorridorRequest,
    ImagingRequest,
    Request,
    StereoRequest,
)
from planner.world.targets.geojson import Position
from planner.world.targets.strips import StripPattern, strip_pattern


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
    if not session.platform.camera.both_ways:
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
    return scans, scan_s + (scans - 1) * max(session.slews.settle_s, COMMAND_STEP_S)


def _strip_pattern(request: AreaRequest, session: ImagingSession) -> StripPattern:
    swath_m = session.spacecraft.swath_m
    return strip_pattern(
        request.geometry.coordinates,
        request.height_m,
        request.azimuth_deg,
        session.passing.velocity_passing,
        swath_m,
        swath_m,
    )


def _cut_strips(request: AreaRequest, session: ImagingSession) -> list[GroundArc]:
    """Parallel strips over the polygon's bounding box in scan direction."""
    pattern = _strip_pattern(request, session)
    ends_m = np.array([pattern.from_m, pattern.to_m])
    strips = (pattern.positions(ends_m, pattern.aside_m(k)) for k in range(pattern.count))
    return [_arc(first, last, request) for first, last in strips]


def _along_flight(arc: GroundArc, session: ImagingSession) -> GroundArc:
    """The arc in the sense of the flight."""
    (start_itrf_m, end_itrf_m), _ = arc.point_itrf(np.array([0.0, 1.0]))
    v_itrf_m_s = session.passing.velocity_passing(start_itrf_m)
    return arc if (end_itrf_m - start_itrf_m) @ v_itrf_m_s >= 0.0 else arc.turned_round()
