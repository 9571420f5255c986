"""The answer to a search for passes of the imaging spacecraft."""

from dataclasses import asdict, dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np

from app.answers.members import BUILT_ON_FIRST_USE
from app.answers.opportunities import (
    Column,
    OpportunitiesHead,
    PassWindow,
    pass_columns,
    spread,
    texts_of,
    times_of,
)
from app.answers.ranges import Count
from planner.planning.opportunities import WindowEdges
from planner.spacecraft.table import TICK_S

if TYPE_CHECKING:
    from planner.spacecraft.opportunities import PassEdges
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
    positive ahead, and `across` it, positive to the right of flight; with `view`.
    through: the view of the middle at instants spread evenly from rise to set; with `view`.
    place: the middle of its positions; with `view`.
    sky: the pass in the sky of the middle; with `view`.
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
    windows: the first of them.
    next: `cursor` of those that come after; null at the end. E.g. `100`.
    unseen: names of the requests that no pass shows whole. E.g. `["north"]`.
    """

    id: str
    windows: list[ImagingOpportunityOut]
    next: Count | None


@dataclass(frozen=True, kw_only=True)
class ImagingWindowsPage:
    """Some of the passes found.

    windows: those of this page.
    next: `cursor` of what comes after; null at the end. E.g. `100`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    windows: list[ImagingOpportunityOut]
    next: Count | None


def imaging_columns(
    request: "ImagingOpportunityRequest", passes: "PassEdges", told: WindowEdges
) -> dict[str, Column]:
    """By the names of an `ImagingOpportunityOut`; told: the passes, or more of them."""
    asked = [request.requests[row] for row in passes.target]
    is_whole = np.flatnonzero(~np.isnan(passes.whole_from_s))
    whole = {
        "start": times_of(request.start, passes.whole_from_s[is_whole]),
        "stop": times_of(request.start, passes.whole_to_s[is_whole]),
    }
    names = [one.name for one in request.requests]
    return pass_columns(request.start, names, ("along", "across"), told) | {
        "session": _sessions(request.start, passes),
        "mode": texts_of([one.mode for one in asked]),
        "geometry": texts_of([asdict(one.geometry) for one in asked]),
        "whole": spread(is_whole, len(passes), whole),
    }


def _sessions(start_utc: datetime, passes: WindowEdges) -> Column:
    """On rows of a table, which begin on multiples of 0.2 s after the second."""
    before_s = start_utc.microsecond / 1e6
    first = np.floor((passes.rise_s - TURN_S + before_s) / TICK_S) * TICK_S - before_s
    last = np.ceil((passes.set_s + TURN_S + before_s) / TICK_S) * TICK_S - before_s
    return {"start": times_of(start_utc, first, 1), "stop": times_of(start_utc, last, 1)}
