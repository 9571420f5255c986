"""The answer about a plan that isn't made, or not yet."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import TypeAdapter

from app.answers.members import fill, to_json
from app.answers.problem import Problem
from app.store.ids import JobState

if TYPE_CHECKING:  # children answer without a database
    from app.store.jobs import Job


@dataclass(frozen=True, kw_only=True)
class JobProblem(Problem):
    """Why there is no plan; `instance` is the job's."""


@dataclass(frozen=True, kw_only=True)
class JobResponse:
    """Where the work on a plan stands.

    attempts: how often it was begun; more than once when a process died at it.  problem: why
    it was refused or failed.  revises: the plan it replaces.
    """

    id: str
    state: JobState
    name: str
    revises: str | None
    input_sha256: str
    created: str
    started: str | None
    finished: str | None
    attempts: int
    problem: JobProblem | None


@dataclass(frozen=True, kw_only=True)
class PlanList:
    """The latest first; `next` is the `cursor` of what comes after, null at the end."""

    plans: list[JobResponse]
    next: str | None


_PROBLEM = TypeAdapter(JobProblem)


def job_out(job: "Job") -> JobResponse:
    """As it stands."""
    problem = job.problem
    return fill(
        JobResponse,
        job,
        revises=job.options.get("revises"),
        input_sha256=job.request_sha256,
        problem=None
        if problem is None
        else _PROBLEM.validate_python({**problem, "instance": f"urn:uuid:{job.id}"}),
    )


def job_json(job: "Job") -> bytes:
    """A JobResponse as UTF-8 JSON."""
    return to_json(job_out(job))


def page(jobs: "Sequence[Job]", limit: int) -> tuple[list[JobResponse], str | None]:
    """Of jobs of which one more than the limit was asked for; the id to go on from, if any."""
    shown = jobs[:limit]
    return [job_out(job) for job in shown], shown[-1].id if len(jobs) > limit else None


def list_json(jobs: "Sequence[Job]", limit: int) -> bytes:
    """A PlanList."""
    plans, after = page(jobs, limit)
    return to_json(PlanList(plans=plans, next=after))
