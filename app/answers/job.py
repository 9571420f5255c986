"""The state of the work on a plan, and lists of what jobs make, as answered."""

from collections.abc import Sequence
from dataclasses import dataclass, make_dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, TypeAdapter

from app.answers.members import BUILT_ON_FIRST_USE, fill, to_json
from app.answers.problem import Problem
from app.ids import JobState
from planner.base.answer_members import Count, Share

if TYPE_CHECKING:  # children answer without a database
    from app.store.jobs import Job


@dataclass(frozen=True, kw_only=True)
class JobResponse:
    """The state of the work on a plan.

    id: of what is made, as its address names it.
    state: state of the work.
    name: as the request gives it.
    platform: name of the platform, or of the spacecraft.
    start: of the first session, or of the time that is searched or planned; UTC, as asked for, and
    as planned once it is.
    stop: of the last session, or of that time; UTC.
    targets: names, or else ids, or else the targets in a few words; the first 20.
    target_count: of all targets.
    probability_in_frame: the least of any session's; null before it is planned. E.g. `0.97`.
    revision: of the plan, from 1; null until it is made. E.g. `1`.
    revises: id of the plan it replaces; null for none. E.g.
    `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    requested_by: name of the API key that the request came with; null without keys. E.g. `"anna"`.
    input_sha256: of the request's bytes; of flights, with those of their plan.
    created: time at which the request came; UTC.
    started: time at which the work began; UTC, null before.
    finished: time at which it ended; UTC, null before.
    attempts: number of times it was begun; more than once when a process died at it.
    problem: the reason why it was refused or failed, `instance` being the job; null otherwise.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    id: str
    state: JobState
    name: str
    platform: str | None
    start: str | None
    stop: str | None
    targets: list[str]
    target_count: Count
    probability_in_frame: Share | None
    revision: Annotated[int, Field(ge=1)] | None
    revises: str | None
    requested_by: str | None
    input_sha256: str
    created: str
    started: str | None
    finished: str | None
    attempts: Count
    problem: Problem | None


def list_class(name: str, member: str, of_what: str) -> type[Any]:
    """The answer that lists jobs under this member, a page at a time."""
    doc = f"""{of_what}, the latest first.

    {member}: those of this page.
    next: `cursor` of what comes after, null at the end. E.g.
    `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    """
    return make_dataclass(
        name,
        [(member, list[JobResponse]), ("next", str | None)],
        namespace={
            "__doc__": doc,
            "__module__": __name__,
            "__pydantic_config__": BUILT_ON_FIRST_USE,
        },
    )


_PROBLEM = TypeAdapter(Problem)


def job_out(job: "Job") -> JobResponse:
    """As it stands."""
    problem = job.problem
    return fill(
        JobResponse,
        job,
        targets=list(job.targets or ()),
        target_count=job.target_count or 0,
        input_sha256=job.request_sha256,
        problem=None
        if problem is None
        else _PROBLEM.validate_python({**problem, "instance": f"urn:uuid:{job.id}"}),
    )


def job_json(job: "Job") -> bytes:
    """A JobResponse as UTF-8 JSON."""
    return to_json(job_out(job))


def list_json(kind: type[Any], jobs: "Sequence[Job]", limit: int) -> bytes:
    """A list of its class, of jobs of which one more than the limit was asked for."""
    shown = jobs[:limit]
    return to_json(
        kind([job_out(job) for job in shown], shown[-1].id if len(jobs) > limit else None)
    )
