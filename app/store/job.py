"""A job as it stands, without its request, and the listing of it; no database is loaded for it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any

from app.ids import OPEN_STATES, JobState
from planner.base.answer_members import Count, Internal, Member, Share, answer
from planner.world.frames.time_scales import Utc

TARGETS_LISTED = 20


@dataclass(frozen=True, kw_only=True)
class Listing:
    """As it was asked for, and once it is made as that turned out.

    platform: its name, or the spacecraft's.  start_utc, stop_utc: of what is looked at, first to
    last.  targets: as people know them, told once each.
    probability_in_frame: the least of any session's.
    """

    platform: str = ""
    start_utc: datetime | None = None
    stop_utc: datetime | None = None
    targets: tuple[str, ...] = ()
    probability_in_frame: float | None = None

    def columns(self, name: str) -> dict[str, Any]:
        targets = [*dict.fromkeys(filter(None, self.targets))]
        return {
            "platform": self.platform,
            "start_utc": self.start_utc,
            "stop_utc": self.stop_utc,
            "targets": targets[:TARGETS_LISTED],
            "target_count": len(targets),
            "probability_in_frame": self.probability_in_frame,
            "words": _words((name, self.platform, *targets)),
            "target_words": _words(targets),
        }


def folded(text: str) -> str:
    """Upper and lower case alike, on every database."""
    return text.casefold()


def _words(texts: Iterable[str]) -> str:
    """One a line: no text that is kept holds a line's end."""
    return folded("\n".join(texts))


@answer
class Job:
    """The state of the work on a plan.

    id: of what is made, as its address names it.
    state: state of the work.
    name: as the request gives it.
    platform: name of the platform, or of the spacecraft.
    start_utc: of the first session, or of the time that is searched or planned; UTC, as asked for,
    and as planned once it is.
    stop_utc: of the last session, or of that time; UTC.
    targets: names, or else ids, or else the targets in a few words; the first 20.
    target_count: of all targets.
    probability_in_frame: the least of any session's; null before it is planned. E.g. `0.97`.
    revision: of the plan, from 1; null until it is made. E.g. `1`.
    revises: id of the plan it replaces, or of the campaign it revises; null for none. E.g.
    `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    requested_by: name of the API key that the request came with; null without keys. E.g. `"anna"`.
    request_sha256: of the request's bytes; of flights, with those of their plan.
    created_utc: time at which the request came; UTC.
    started_utc: time at which the work began; UTC, null before.
    finished_utc: time at which it ended; UTC, null before.
    attempts: number of times it was begun; more than once when a process died at it.
    problem: the reason why it was refused or failed, `instance` being the job; null otherwise.
    cancel_requested: of itself, or of the job it is a part of.
    series, options: see `JobRow`.
    """

    id: str
    state: JobState
    name: str
    platform: str | None
    start_utc: Utc | None
    stop_utc: Utc | None
    targets: list[str]
    target_count: Count
    probability_in_frame: Share | None
    revision: Annotated[int, Member(least=1)] | None
    revises: str | None
    requested_by: str | None
    request_sha256: Annotated[str, Member(called="input_sha256")]
    created_utc: Utc
    started_utc: Utc | None
    finished_utc: Utc | None
    attempts: Count
    problem: Mapping[str, Any] | None
    kind: Internal[str]
    options: Internal[Mapping[str, Any]]
    key_id: Internal[str | None]
    parent_id: Internal[str | None]
    plan_id: Internal[str | None]
    deadline_s: Internal[float]
    cancel_requested: Internal[bool]
    series: Internal[str | None]

    @property
    def is_open(self) -> bool:
        return self.state in OPEN_STATES
