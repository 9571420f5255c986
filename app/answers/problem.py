"""The answer to a refusal or to a failure of ours: RFC 9457 problem details."""

from dataclasses import asdict, dataclass
from http import HTTPStatus
from typing import Annotated, Any, TypeVar

from pydantic import Field

from planner.base.answer_members import Count
from planner.base.errors import FieldError, Refusal, Relaxation
from planner.world.frames.time_scales import utc_text

TYPE_PREFIX = "urn:slewtrack:problem:"
_TEXT_MAX = 2000
_STATUS = {
    "request": HTTPStatus.UNPROCESSABLE_ENTITY,
    "conflict": HTTPStatus.CONFLICT,
    "busy": HTTPStatus.SERVICE_UNAVAILABLE,
    "ours": HTTPStatus.INTERNAL_SERVER_ERROR,
}
T = TypeVar("T")


# Left out of the JSON of a problem, alone or within another answer, where there is nothing to tell.
IfTold = Annotated[T, Field(exclude_if=lambda value: value in (None, ()))]


@dataclass(frozen=True, kw_only=True)
class Problem:
    """RFC 9457 problem details.

    type: kind of refusal.
    title: the kind in words.
    status: the answer's HTTP status.
    detail: the fault and the way out.
    instance: this request, by the id that the log and the header X-Request-ID name too.
    field: request field at fault, dotted.
    axis: name of the axis that can't do it.
    limit: the limit that breaks.
    at: time at which it breaks; UTC. E.g. `"2015-02-27T17:36:10.000Z"`.
    earliest_feasible_start: nearest session start that works, for a session that stops at
    `feasible_stop`, when the sessions in `costs_sessions` are left out; UTC.
    feasible_stop: session stop that goes with it; UTC.
    costs_sessions: numbers of the sessions that can't be flown as asked with that start. E.g.
    `[2]`.
    relaxations: the time that sessions would lose under each `on_conflict`.
    errors: every field at fault of a request that can't be read.
    """

    type: str
    title: str
    status: Annotated[int, Field(ge=400, le=599)]
    detail: str
    instance: str
    field: IfTold[str | None] = None
    axis: IfTold[str | None] = None
    limit: IfTold[str | None] = None
    at: IfTold[str | None] = None
    earliest_feasible_start: IfTold[str | None] = None
    feasible_stop: IfTold[str | None] = None
    costs_sessions: IfTold[tuple[Count, ...]] = ()
    relaxations: IfTold[tuple[Relaxation, ...]] = ()
    errors: IfTold[tuple[FieldError, ...]] = ()


def problem_of(refusal: Refusal) -> dict[str, Any]:
    """A problem's members, but for the instance."""
    times = ("at", "earliest_feasible_start", "feasible_stop")
    times_utc = {name: getattr(refusal, f"{name}_utc") for name in times}
    members = {
        "type": TYPE_PREFIX + refusal.slug,
        "title": refusal.title,
        "status": _STATUS[refusal.blame].value,
        "detail": refusal.detail,
        "field": refusal.field,
        "axis": refusal.axis,
        "limit": refusal.limit,
        **{name: utc and utc_text(utc) for name, utc in times_utc.items()},
        "costs_sessions": list(refusal.costs_sessions),
        "relaxations": [asdict(offer) for offer in getattr(refusal, "relaxations", ())],
        "errors": [asdict(error) for error in getattr(refusal, "errors", ())],
    }
    return {name: _short(value) for name, value in members.items() if value not in (None, [])}


def _short(value: object) -> object:
    """Cut to what a person reads, wherever it came from."""
    if isinstance(value, str):
        return value if len(value) <= _TEXT_MAX else value[:_TEXT_MAX] + "..."
    if isinstance(value, list):
        return [_short(item) for item in value]
    if isinstance(value, dict):
        return {name: _short(item) for name, item in value.items()}
    return value


def bug() -> dict[str, Any]:
    """A problem's members that tell no more of our failure than that there was one."""
    status = HTTPStatus.INTERNAL_SERVER_ERROR
    return {
        "type": TYPE_PREFIX + "internal-error",
        "title": status.phrase,
        "status": status.value,
        "detail": "the service failed; its log gives the reason under this `instance`",
    }
