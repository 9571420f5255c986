"""The refusals and failures of a service, as exceptions."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class FieldFault:
    """One field of a request that can't be read: its dotted name, what is wrong, what it holds."""

    field: str
    detail: str
    value: str | float | int | bool | None = None


@dataclass(frozen=True, kw_only=True)
class Relaxation:
    """What one session, by number, would lose if the request's `on_conflict` were set so."""

    on_conflict: str
    session: int
    start_later_s: float
    stop_earlier_s: float


@dataclass(frozen=True, kw_only=True)
class Problem:
    """RFC 9457 problem details, as the service answers them.

    type: urn:slewtrack:problem:... or about:blank.  status: the HTTP status.
    detail: what is wrong and the way out.  field: of the request, dotted (`sessions.0.start`).
    axis, limit, at: which limit breaks, and when.
    earliest_feasible_start, feasible_stop: times of a session that works, UTC text that a request
    takes; costs_sessions: numbers of those that can't be flown as asked with it.
    relaxations: what each `on_conflict` would cost.  errors: every field at fault.
    members: all of it, as it came.
    """

    type: str
    title: str
    status: int
    detail: str
    instance: str = ""
    field: str | None = None
    axis: str | None = None
    limit: str | None = None
    at: str | None = None
    earliest_feasible_start: str | None = None
    feasible_stop: str | None = None
    costs_sessions: tuple[int, ...] = ()
    relaxations: tuple[Relaxation, ...] = ()
    errors: tuple[FieldFault, ...] = ()
    members: Mapping[str, Any] = dataclasses.field(repr=False)


# What reading JSON of another shape raises: of no JSON, too deep, or with other types in it.
MISREAD = (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)
_TEXTS = ("field", "axis", "limit", "at", "earliest_feasible_start", "feasible_stop")


def problem_of(members: Mapping[str, Any]) -> Problem:
    """A problem of its JSON; members that only newer services know are in `members`.

    Raises one of MISREAD.
    """
    texts = {name: members.get(name) for name in _TEXTS}
    if not all(text is None or isinstance(text, str) for text in texts.values()):
        raise TypeError
    return Problem(
        type=str(members.get("type", "about:blank")),
        title=str(members.get("title", "")),
        status=int(members.get("status", 500)),
        detail=str(members.get("detail") or members.get("title", "")),
        instance=str(members.get("instance", "")),
        costs_sessions=tuple(members.get("costs_sessions") or ()),
        relaxations=tuple(
            Relaxation(
                on_conflict=offer["on_conflict"],
                session=offer["session"],
                start_later_s=offer["start_later_s"],
                stop_earlier_s=offer["stop_earlier_s"],
            )
            for offer in members.get("relaxations") or ()
        ),
        errors=tuple(
            FieldFault(field=fault["field"], detail=fault["detail"], value=fault.get("value"))
            for fault in members.get("errors") or ()
        ),
        members=members,
        **texts,
    )


class ServiceError(Exception):
    """What was asked of a service was not done."""


class Refused(ServiceError):
    """The service answered with a problem; `problem.status` 500 and above is its own failure."""

    def __init__(self, problem: Problem) -> None:
        field = problem.field
        named = field is None or problem.detail.startswith(field)
        super().__init__(problem.detail if named else f"{field}: {problem.detail}")
        self.problem = problem


class NoAnswer(ServiceError):
    """The service can't be reached, or the connection to it broke, for longer than we wait."""


class BadAnswer(ServiceError):
    """What came is not what a slewtrack service answers, or more than is taken of an answer."""


class NotFinished(ServiceError):
    """The time to wait is over and the work goes on; `job_id` finds it again."""

    def __init__(self, job_id: str, state: str) -> None:
        super().__init__(f"{job_id} is still {state}; wait() for it again, or delete() it")
        self.job_id = job_id


class Cancelled(ServiceError):
    """What was waited for was cancelled by somebody."""

    def __init__(self, job_id: str) -> None:
        super().__init__(f"{job_id} was cancelled; ask again")
        self.job_id = job_id
