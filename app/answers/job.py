"""The state of the work on a plan, and lists of what jobs make, as answered."""

from collections.abc import Sequence
from dataclasses import make_dataclass
from typing import Any

from pydantic import TypeAdapter

from app.answers.members import BUILT_ON_FIRST_USE, to_json
from app.answers.problem import Problem
from app.store.job import Job
from planner.base.answer_members import answer


@answer
class JobResponse(Job):
    """The state of the work on a plan."""

    __pydantic_config__ = BUILT_ON_FIRST_USE

    problem: Problem | None  # type: ignore[assignment]  # with the job it is of


def list_class(name: str, member: str, of_what: str) -> type[Any]:
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


def job_out(job: Job) -> JobResponse:
    members = {name: getattr(job, name) for name in Job.__dataclass_fields__}
    if job.problem is not None:
        told = {**job.problem, "instance": f"urn:uuid:{job.id}"}
        members["problem"] = _PROBLEM.validate_python(told)
    return JobResponse(**members)


def job_json(job: Job) -> bytes:
    return to_json(job_out(job))


def list_json(kind: type[Any], jobs: Sequence[Job], limit: int) -> bytes:
    """A list of its class, of jobs of which one more than the limit was asked for."""
    shown = jobs[:limit]
    return to_json(
        kind([job_out(job) for job in shown], shown[-1].id if len(jobs) > limit else None)
    )
