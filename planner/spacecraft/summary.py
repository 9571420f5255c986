"""The summary of an imaging session."""

from typing import TYPE_CHECKING

from planner.base.answer_members import Count, answer
from planner.spacecraft.table import TICK_S
from planner.world.frames.time_scales import Utc, shifted_utc

if TYPE_CHECKING:
    from planner.spacecraft.plan import ImagingPlan
    from planner.spacecraft.requests import Request


@answer
class ImagingRequestSummary:
    """One request as it is planned.

    request: its name.
    mode: strip, stereo, area or corridor. E.g. `"strip"`.
    looks: number of times that the camera is on for it; 0 where it is left out.
    start_utc: first time that it is; UTC, null where it is left out.
    stop_utc: last time that it is; UTC, null where it is left out.
    """

    request: str
    mode: str
    looks: Count
    start_utc: Utc | None
    stop_utc: Utc | None


@answer
class ImagingSummary:
    """Summary of the session.

    name: as the request gives it.
    platform: the spacecraft's name.
    targets: names of the requests.
    start_utc: row 0 of the table; UTC.
    stop_utc: latest time at which the spacecraft is back in orbital orientation; UTC.
    requests: in the order of the request.
    """

    name: str
    platform: str
    targets: tuple[str, ...]
    start_utc: Utc
    stop_utc: Utc
    requests: tuple[ImagingRequestSummary, ...]


def summarise(plan: "ImagingPlan") -> ImagingSummary:
    """Of a session as it was planned."""
    request = plan.request
    return ImagingSummary(
        name=request.name,
        platform=request.spacecraft,
        targets=tuple(one.name for one in request.requests),
        start_utc=request.start,
        stop_utc=request.stop,
        requests=tuple(_summarise_request(plan, one) for one in request.requests),
    )


def _summarise_request(plan: "ImagingPlan", request: "Request") -> ImagingRequestSummary:
    epoch_utc = plan.table.epoch_utc
    looks = [window for window in plan.windows if window.request == request.name]
    first_row = min((look.first_row for look in looks), default=None)
    last_row = max((look.last_row for look in looks), default=None)
    return ImagingRequestSummary(
        request=request.name,
        mode=request.mode,
        looks=len(looks),
        start_utc=None if first_row is None else shifted_utc(epoch_utc, first_row * TICK_S),
        stop_utc=None if last_row is None else shifted_utc(epoch_utc, last_row * TICK_S),
    )
