"""The answer to a search for passes of the imaging spacecraft."""

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut
from app.answers.opportunities import (
    FoundWindows,
    OpportunitiesHead,
    PassWindow,
    SessionTimesOut,
    found_windows,
    pass_columns,
    rows_of,
)
from app.answers.ranges import Count
from planner.spacecraft.table import TICK_S
from planner.world.frames.time_scales import shifted_utc, utc_text

if TYPE_CHECKING:
    from planner.spacecraft.opportunities import ImagingOpportunities
    from planner.spacecraft.opportunity_request import ImagingOpportunityRequest

# From orbital orientation to the farthest look and back: 54 deg at 1.58 deg/s about each axis,
# the build-up of the rate and the settling beside it.
TURN_S = 60.0


@dataclass(frozen=True, kw_only=True)
class WholeOut:
    """While all of a request is within the camera's angles at once.

    start: from when; UTC.
    stop: until when; UTC.
    """

    start: str
    stop: str


@dataclass(frozen=True, kw_only=True)
class ImagingOpportunityOut(PassWindow):
    """One pass over a request: from when its first position is within the camera's angles until
    the last is no more.

    target: name of the request.
    session: times for a plan of it, with a minute before and after for the slews.
    opened_by: the condition that is met from `rise` on: `reach` the angle along the track, `across`
    that across it, "interval" the search's or the request's own start.
    closed_by: the condition that is met until `set`, likewise.
    closest: the view of the middle of its positions at the least range; angles `along` the track,
    positive ahead, and `across` it, positive to the right of flight.
    through: the view of the middle at instants spread evenly from rise to set.
    place: the middle of its positions.
    sky: the pass in the sky of the middle.
    mode: of the request. E.g. `"strip"`.
    geometry: as the request gives it: GeoJSON. E.g.
    `{"type": "LineString", "coordinates": [[-12.390357, 20.486982], [-12.506716, 21.017679]]}`.
    whole: while all of it is within the camera's angles at once; null where it never is: it is
    imaged piece after piece.
    """

    mode: str
    geometry: dict[str, Any]
    whole: WholeOut | None


@dataclass(frozen=True, kw_only=True)
class ImagingOpportunitiesResponse(OpportunitiesHead):
    """Passes in the order of the requests, each one's in order of time.

    id: of what was found, as its address names it.
    windows: all there are.
    unseen: names of the requests that no pass shows whole. E.g. `["north"]`.
    """

    id: str
    windows: list[ImagingOpportunityOut]
    unseen: list[str]


@dataclass(frozen=True, kw_only=True)
class ImagingWindowsPage:
    """Some of the passes found.

    windows: those of this page.
    next: `cursor` of what comes after; null at the end. E.g. `100`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    windows: list[ImagingOpportunityOut]
    next: Count | None


def found_passes(
    request: "ImagingOpportunityRequest", result: "ImagingOpportunities", provenance: ProvenanceOut
) -> FoundWindows:
    """The answer without its id."""
    requests = [request.requests[row] for row in result.windows.target]
    columns = pass_columns(result) | {
        "session": [_session(result, row) for row in range(len(requests))],
        "mode": [one.mode for one in requests],
        "geometry": [asdict(one.geometry) for one in requests],
        "whole": [_whole(result, row) for row in range(len(requests))],
    }
    windows = [ImagingOpportunityOut(**row) for row in rows_of(columns)]
    seen = {*result.windows.target.tolist()}
    unseen = [name for row, name in enumerate(result.ids) if row not in seen]
    return found_windows(result, request.name, provenance, windows, unseen)


def _session(result: "ImagingOpportunities", row: int) -> SessionTimesOut:
    """On rows of a table, which begin on multiples of 0.2 s after the second."""
    before_s = result.start_utc.microsecond / 1e6
    rise_s, set_s = float(result.windows.rise_s[row]), float(result.windows.set_s[row])
    first = math.floor((rise_s - TURN_S + before_s) / TICK_S)
    last = math.ceil((set_s + TURN_S + before_s) / TICK_S)
    start, stop = (
        utc_text(shifted_utc(result.start_utc, tick * TICK_S - before_s), 1)
        for tick in (first, last)
    )
    return SessionTimesOut(start=start, stop=stop)


def _whole(result: "ImagingOpportunities", row: int) -> WholeOut | None:
    if np.isnan(result.whole_s[row, 0]):
        return None
    start, stop = (utc_text(shifted_utc(result.start_utc, t)) for t in result.whole_s[row].tolist())
    return WholeOut(start=start, stop=stop)
