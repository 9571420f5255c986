"""The summary of an imaging session: its requests, and the times at which each is imaged."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.answers.ranges import Count
from planner.spacecraft.table import TICK_S, ImagingWindow
from planner.world.frames.time_scales import shifted_utc, utc_text

if TYPE_CHECKING:
    from planner.spacecraft.plan import ImagingPlan


@dataclass(frozen=True, kw_only=True)
class ImagingRequestSummaryOut:
    """One request as it is planned.

    request: its name.
    mode: strip, stereo, area or corridor. E.g. `"strip"`.
    looks: number of times that the camera is on for it; 0 where it is left out.
    start: first time that it is; UTC, null where it is left out.
    stop: last time that it is; UTC, null where it is left out.
    """

    request: str
    mode: str
    looks: Count
    start: str | None
    stop: str | None


@dataclass(frozen=True, kw_only=True)
class ImagingSummaryOut:
    """Summary of the session.

    name: as the request gives it.
    platform: the spacecraft's name.
    targets: names of the requests.
    start: row 0 of the table; UTC.
    stop: latest time at which the spacecraft is back in orbital orientation; UTC.
    requests: in the order of the request.
    """

    name: str
    platform: str
    targets: list[str]
    start: str
    stop: str
    requests: list[ImagingRequestSummaryOut]


def imaging_summary_out(plan: "ImagingPlan") -> ImagingSummaryOut:
    """Of a session as it was planned."""
    request = plan.request

    def utc(row: int) -> str:
        return utc_text(shifted_utc(plan.table.epoch_utc, row * TICK_S))

    def told(name: str, mode: str, looks: Sequence[ImagingWindow]) -> ImagingRequestSummaryOut:
        return ImagingRequestSummaryOut(
            request=name,
            mode=mode,
            looks=len(looks),
            start=utc(min(look.first_row for look in looks)) if looks else None,
            stop=utc(max(look.last_row for look in looks)) if looks else None,
        )

    return ImagingSummaryOut(
        name=request.name,
        platform=request.spacecraft,
        targets=[one.name for one in request.requests],
        start=utc_text(request.start),
        stop=utc_text(request.stop),
        requests=[
            told(one.name, one.mode, [w for w in plan.table.windows if w.request == one.name])
            for one in request.requests
        ],
    )
