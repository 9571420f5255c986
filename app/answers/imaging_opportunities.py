"""The answer to a search for passes of the imaging spacecraft."""

from dataclasses import dataclass
from typing import Any

from app.answers.opportunities import OpportunitiesHead, PassWindow
from planner.base.answer_members import Count


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
