"""Passes of the imaging spacecraft over what is to be imaged.

Its camera looks from orbital orientation, so far along the track and so far across it: the search
for a platform of two axes serves, with these angles for its stops.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.effort import at_most
from planner.base.errors import InvalidInput, SearchEnded
from planner.planning.opportunities.carrier import Carrier, carrier_over
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.request import OpportunityRequest, OpportunityTarget
from planner.planning.opportunities.search import Spans, describe_windows, edges_of, found_spans
from planner.planning.opportunities.sights import resting_sight
from planner.planning.opportunities.sweep import OPTIONS as SWEEP
from planner.planning.opportunities.windows import Sightings, WindowEdges, Windows
from planner.spacecraft.imaging.session import HEIGHT_MAX_M
from planner.spacecraft.opportunity_request import ImagingOpportunityRequest, positions_of
from planner.spacecraft.requests import Request
from planner.spacecraft.vehicle.definition import PushbroomCamera
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.earth_orientation import earth_orientation_warnings
from planner.world.frames.geodesy import WGS84_A_M, geodetic_from_itrf, itrf_from_geodetic
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.platforms import along_and_across
from planner.world.targets import GroundTarget

# Windows this far apart are of two passes: a low orbit lasts an hour and a half.
_PASSES_APART_S = 1800.0


@dataclass(frozen=True, kw_only=True, eq=False)
class PassEdges(WindowEdges):
    """Windows of requests: from when its first position is within the camera's angles until the
    last is no more, of the passes in which every one is.

    whole_from_s, whole_to_s: (windows,), since the search's start, while all of it is within them
    at once; NaN where it never is.
    """

    whole_from_s: Array
    whole_to_s: Array


class ImagingSearch:
    """One spacecraft with all it is to image: what is found follows from the request alone.

    Raises InvalidInput for a high orbit, OutsideCoverage.
    """

    def __init__(self, request: ImagingOpportunityRequest) -> None:
        self._request = request
        self._camera = request.definition().camera
        ephemeris = request.orbit.ephemeris(request.start, request.stop)
        self._asked, self._owner = _position_search(request, self._camera)
        base = lookout_of(self._asked.platform, self._asked.attitude)
        self.carrier = carrier_over(ephemeris, base, request.start, request.stop)
        _require_low(self.carrier)
        ends = Instants(request.start, np.array([0.0, self.carrier.span_s]))
        self.warnings = (*ephemeris.warnings, *earth_orientation_warnings(ends))

    def find(self) -> PassEdges:
        """All passes over all requests, by no more work than one request may make.

        Edges are those of the exact orbit and frames to 0.1 ms.  Neglected: the yaw with which the
        camera steers against the Earth's rotation, which moves what it looks at by nothing, and
        the duration of scans and slews: the plan tells whether they fit.
        Raises SearchEnded.
        """
        with at_most(effort.PLAN):
            of_positions = _spans_of_positions(self._asked, self.carrier, self._camera)
            spans, whole_s = _request_passes(self._request, self._owner, of_positions)
            held_s = np.stack([spans.start_s, spans.stop_s], axis=1)
            edges = edges_of(np.arange(len(self._request.requests)), spans, held_s)
            return PassEdges(**vars(edges), whole_from_s=whole_s[:, 0], whole_to_s=whole_s[:, 1])
        raise SearchEnded(
            f"the passes over these {len(self._request.requests)} requests take more work than one "
            "request may make; ask for fewer requests, days, samples or conditions at a time",
            field="requests",
        )

    def tell(self, edges: WindowEdges) -> Windows:
        """What is told of passes that were found: the view of the middle of a request's positions.

        Its axes are `along` and `across` the track.
        """
        middles = _middle_places(self._request)
        sight = resting_sight(self.carrier, middles, np.zeros(len(middles)))
        spans = Spans(edges.target, edges.rise_s, edges.set_s, edges.opened_by, edges.closed_by)
        held_s = np.stack([edges.held_from_s, edges.held_to_s], axis=1)
        windows = describe_windows(self._asked, sight, np.arange(len(middles)), spans, held_s)
        return replace(
            windows,
            closest=_in_camera_angles(windows.closest),
            through=_in_camera_angles(windows.through),
        )


def _require_low(carrier: Carrier) -> None:
    height_m = float(np.linalg.norm(carrier.orbit.at(np.zeros(1))[0, :3])) - WGS84_A_M
    if height_m > HEIGHT_MAX_M:
        raise InvalidInput(
            f"the orbit is {height_m / 1e3:.0f} km high at the start; this spacecraft images from "
            f"low orbits, up to {HEIGHT_MAX_M / 1e3:.0f} km: give the orbit of such a one",
            field="orbit",
        )


def _position_search(
    request: ImagingOpportunityRequest, camera: PushbroomCamera
) -> tuple[OpportunityRequest, Indices]:
    """The search for every position, and the number of the request each belongs to."""
    places = [
        (number, GroundTarget(longitude_deg=p[0], latitude_deg=p[1], height_m=one.height_m))
        for number, one in enumerate(request.requests)
        for p in positions_of(one)
    ]
    asked = OpportunityRequest(
        platform=along_and_across(camera.along_max_deg),
        orbit=request.orbit,
        attitude=LvlhAttitude(),
        targets=tuple(
            OpportunityTarget(id=str(row), target=target) for row, (_, target) in enumerate(places)
        ),
        start=request.start,
        stop=request.stop,
        conditions=replace(request.conditions, min_duration_s=0.0),  # of the whole window
        samples=request.samples,
        pixel_arcsec=math.degrees(camera.pixel_rad) * 3600.0,
    )
    return asked, np.array([number for number, _ in places])


def _spans_of_positions(
    asked: OpportunityRequest, carrier: Carrier, camera: PushbroomCamera
) -> Spans:
    found = [
        replace(spans, target=numbers[spans.target])
        for numbers, _, spans, _ in found_spans(asked, carrier, math.radians(camera.across_max_deg))
    ]
    columns = zip(*(vars(spans).values() for spans in found), strict=True)
    return Spans(*map(np.concatenate, columns))


class _Pass(NamedTuple):
    """whole_s: while all positions are seen at once, NaN where never."""

    request: int
    start_s: float
    stop_s: float
    opened_by: str
    closed_by: str
    whole_s: tuple[float, float]


def _request_passes(
    request: ImagingOpportunityRequest, owner: Indices, of_positions: Spans
) -> tuple[Spans, Array]:
    """Those in which every position of a request is seen, and while all are at once."""
    passes = [
        found
        for number, one in enumerate(request.requests)
        for spans in _by_pass(of_positions.select(owner[of_positions.target] == number))
        if len(np.unique(spans.target)) == np.count_nonzero(owner == number)
        for found in _passes_that_serve(request, number, one, spans)
    ]
    columns = list(zip(*passes, strict=True)) or [()] * len(_Pass._fields)
    spans = Spans(
        target=np.array(columns[0], dtype=np.intp),
        start_s=np.array(columns[1], dtype=np.float64),
        stop_s=np.array(columns[2], dtype=np.float64),
        opened_by=np.array(columns[3], dtype=np.str_),
        closed_by=np.array(columns[4], dtype=np.str_),
    )
    return spans, np.array(columns[5], dtype=np.float64).reshape(-1, 2)


def _by_pass(spans: Spans) -> Iterator[Spans]:
    in_order = spans.select(np.argsort(spans.start_s))
    begins = in_order.start_s[1:] > np.maximum.accumulate(in_order.stop_s)[:-1] + _PASSES_APART_S
    for rows in np.split(np.arange(len(in_order.start_s)), np.flatnonzero(begins) + 1):
        if rows.size:
            yield in_order.select(rows)


def _passes_that_serve(
    request: ImagingOpportunityRequest, number: int, one: Request, spans: Spans
) -> Iterator[_Pass]:
    """The pass of these spans, within the times the request itself asks for; or none."""
    first, last = int(np.argmin(spans.start_s)), int(np.argmax(spans.stop_s))
    opens_s = elapsed_s(one.window_start or request.start, request.start)
    closes_s = elapsed_s(one.window_stop or request.stop, request.start)
    start_s, stop_s = max(spans.start_s[first], opens_s), min(spans.stop_s[last], closes_s)
    if stop_s - start_s < max(request.conditions.min_duration_s, SWEEP.shortest_s):
        return
    if one.start is not None and not start_s <= elapsed_s(one.start, request.start) <= stop_s:
        return
    each = [spans.select(spans.target == position) for position in np.unique(spans.target)]
    from_s = max(start_s, *(span.start_s.min() for span in each))
    until_s = min(stop_s, *(span.stop_s.max() for span in each))
    yield _Pass(
        request=number,
        start_s=start_s,
        stop_s=stop_s,
        opened_by=str(spans.opened_by[first]) if spans.start_s[first] == start_s else "interval",
        closed_by=str(spans.closed_by[last]) if spans.stop_s[last] == stop_s else "interval",
        whole_s=(from_s, until_s) if from_s < until_s else (math.nan, math.nan),
    )


def _middle_places(request: ImagingOpportunityRequest) -> list[GroundTarget]:
    targets = []
    for one in request.requests:
        longitude_rad, latitude_rad = np.deg2rad([p[:2] for p in positions_of(one)]).T
        r_itrf_m = itrf_from_geodetic(latitude_rad, longitude_rad, one.height_m).mean(axis=0)
        latitude, longitude, _ = np.rad2deg(geodetic_from_itrf(r_itrf_m))
        targets.append(
            GroundTarget(
                latitude_deg=float(latitude), longitude_deg=float(longitude), height_m=one.height_m
            )
        )
    return targets


def _in_camera_angles(seen: Sightings) -> Sightings:
    """The inner axis's angle b on an outer one at a, as the angle atan(tan b / cos a) across."""
    along_rad, b_rad = seen.angle_rad[..., 0], seen.angle_rad[..., 1]
    along_rad_s, b_rad_s = seen.rate_rad_s[..., 0], seen.rate_rad_s[..., 1]
    slope = np.tan(b_rad) / np.cos(along_rad)
    slope_per_s = (
        b_rad_s / np.cos(b_rad) ** 2 / np.cos(along_rad) + slope * np.tan(along_rad) * along_rad_s
    )
    across_rad, across_rad_s = np.arctan(slope), slope_per_s / (1.0 + slope**2)
    return replace(
        seen,
        angle_rad=np.stack([along_rad, across_rad], axis=-1),
        rate_rad_s=np.stack([along_rad_s, across_rad_s], axis=-1),
    )
