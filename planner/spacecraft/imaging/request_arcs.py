"""The ground arcs that the scans of a request follow, in every order they may be scanned."""

from collections.abc import Callable, Iterable
from itertools import pairwise

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.spacecraft.imaging.session import GroundArc, ImagingSession
from planner.spacecraft.requests import AreaRequest, CorridorRequest, Request, StereoRequest
from planner.world.targets.geojson import Position
from planner.world.targets.imaging import IMAGING_MODES, ImagingMode
from planner.world.targets.strips import StripPattern, strip_pattern

Ends = tuple[Position, Position]


def scan_orders(request: Request, session: ImagingSession) -> list[list[GroundArc]]:
    """The request's arcs in each order and sense they may be scanned, times open (start_s = 0).

    A corridor's legs as they are given, other arcs in the sense of flight; by a reversible
    detector to and fro.
    """
    mode, lines = _mode(request), list(_lines(request, session))
    if isinstance(request, CorridorRequest):
        return [[GroundArc(path=mode.path_between(*ends)) for ends in lines]]
    forward = [mode.in_sense(ends, session.passing) for ends in lines]
    senses = [[GroundArc(path=mode.path_between(*ends)) for ends in forward]]
    if not session.platform.camera.both_ways:
        return senses
    senses.append(
        [GroundArc(path=mode.path_between(*ends[::-1]), backwards=True) for ends in forward]
    )
    return [[senses[(k + first) % 2][k] for k in range(len(lines))] for first in (0, 1)]


def least_time_s(request: Request, session: ImagingSession) -> tuple[int, float]:
    """How many scans a request is, and no less than the time they and the slews between take."""
    if isinstance(request, AreaRequest):
        pattern = _strip_pattern(request, session)
        scans = pattern.count
        scan_s = scans * (pattern.to_m - pattern.from_m) / request.scan_speed_m_s
    else:
        mode, lines = _mode(request), pairwise(request.geometry.coordinates)
        lasts_s = [mode.path_between(*ends).duration_s for ends in lines]
        looks = 2 if isinstance(request, StereoRequest) else 1
        scans, scan_s = looks * len(lasts_s), looks * sum(lasts_s)
    return scans, scan_s + (scans - 1) * max(session.slews.settle_s, COMMAND_STEP_S)


def _mode(request: Request) -> ImagingMode:
    """The imaging mode that says the same of a session of any platform."""
    mode: Callable[..., ImagingMode] = IMAGING_MODES[request.mode]
    return mode(
        geometry=request.geometry,
        speed_m_s=request.scan_speed_m_s,
        height_m=request.height_m,
        line="plane",
    )


def _lines(request: Request, session: ImagingSession) -> Iterable[Ends]:
    """Of an area parallel strips over the polygon's bounding box in scan direction."""
    if not isinstance(request, AreaRequest):
        return pairwise(request.geometry.coordinates)
    pattern = _strip_pattern(request, session)
    ends_m = np.array([pattern.from_m, pattern.to_m])
    strips = (pattern.positions(ends_m, pattern.aside_m(k)) for k in range(pattern.count))
    return ((first, last) for first, last in strips)


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
