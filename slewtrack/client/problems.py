"""The refusals and failures of a service, as exceptions."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, replace

from slewtrack.client.reading import Members, read


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
    members: Members = dataclasses.field(repr=False)

    @property
    def ways_out(self) -> tuple[Mapping[str, str], ...]:
        """Fields of the request and what to set them to; each was tried by planning it so."""
        changes: list[Mapping[str, str]] = []
        session, start, stop = self.field or "", self.earliest_feasible_start, self.feasible_stop
        session = session.rpartition(".")[0]
        if start and session.startswith("sessions.") and not self.costs_sessions:
            times = {f"{session}.start": start, f"{session}.stop": stop}
            changes.append({field: time for field, time in times.items() if time})
        names = dict.fromkeys(offer.on_conflict for offer in self.relaxations)
        return (*changes, *({"on_conflict": name} for name in names))


def problem_of(members: Members) -> Problem:
    """A problem of its JSON; raises one of MISREAD."""
    title = str(members.get("title", ""))
    told = {"type": "about:blank", "status": 500, "title": title, "detail": title, **members}
    return replace(read(Problem, told), members=members)


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
