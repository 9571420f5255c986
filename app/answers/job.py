"""The answer about a plan that isn't made, or not yet."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import TypeAdapter

from app.answers.problem import Problem
from app.store.ids import JobState
from app.store.jobs import Job
from planner.frames.time_scales import utc_text


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


_JOB = TypeAdapter(JobResponse)
_PROBLEM = TypeAdapter(JobProblem)
_LIST = TypeAdapter(PlanList)


def job_out(job: Job) -> JobResponse:
    """As it stands."""
    problem = job.problem
    return JobResponse(
        id=job.id,
        state=job.state,
        name=job.name,
        revises=job.options.get("revises"),
        input_sha256=job.request_sha256,
        created=utc_text(job.created_utc),
        started=None if job.started_utc is None else utc_text(job.started_utc),
        finished=None if job.finished_utc is None else utc_text(job.finished_utc),
        attempts=job.attempts,
        problem=None if problem is None else _problem(job.id, problem),
    )


def _problem(job_id: str, problem: Mapping[str, Any]) -> JobProblem:
    return _PROBLEM.validate_python({**problem, "instance": f"urn:uuid:{job_id}"})


def job_json(job: Job) -> bytes:
    """A JobResponse as UTF-8 JSON."""
    return _JOB.dump_json(job_out(job))


def page(jobs: Sequence[Job], limit: int) -> tuple[list[JobResponse], str | None]:
    """Of jobs of which one more than the limit was asked for; the id to go on from, if any."""
    shown = jobs[:limit]
    return [job_out(job) for job in shown], shown[-1].id if len(jobs) > limit else None


def list_json(jobs: Sequence[Job], limit: int) -> bytes:
    """A PlanList."""
    plans, after = page(jobs, limit)
    return _LIST.dump_json(PlanList(plans=plans, next=after))
