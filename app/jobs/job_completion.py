"""The state of a job whose work has ended, and its problem."""

from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any

from sqlalchemy import Connection

from app.answers.problem import bug, problem_of
from app.jobs.kinds import JobKind, Settled, replace_refused
from app.jobs.refusals import Interrupted
from app.jobs.worker_process import ChildFailed, Stopped
from app.log.logs import log
from app.store import jobs
from app.store.ids import JobState
from app.store.jobs import Job
from planner.base.errors import Refusal


def settle(
    connection: Connection, job: Job, kind: JobKind, done: Future[Any], attempts_max: int
) -> Settled:
    """Store the result of a job whose row is locked."""
    error = done.exception()
    if error is None:
        settled = kind.store(connection, job, done.result())
        if settled.state == "running":
            jobs.wait_for_parts(connection, job)
        else:
            jobs.finish(connection, job, settled.state)
        return settled
    if isinstance(error, Stopped):
        return Settled(_state_when_stopped(connection, job))
    problem = _problem(job, error)
    if problem is None:
        return Settled(take_up_again(connection, job, attempts_max))
    state: JobState = "refused" if problem["status"] < 500 else "failed"
    if state == "refused" and "campaign" in job.options and not job.cancel_requested:
        replace_refused(connection, job, problem)
    jobs.finish(connection, job, state, problem)
    return Settled(state)


def take_up_again(connection: Connection, job: Job, attempts_max: int) -> JobState:
    """Back into the queue, unless whoever worked on it died too often."""
    if job.attempts < attempts_max:
        jobs.give_back(connection, job, counted=True)
        return "queued"
    problem = problem_of(
        Interrupted(
            f"the process that worked on it ended without a word {job.attempts} times; ask for "
            "less at a time, or again if the service was killed"
        )
    )
    jobs.finish(connection, job, "failed", problem)
    return "failed"


def give_up(connection: Connection, job: Job) -> Settled:
    """Our failure, which no other attempt would mend."""
    jobs.finish(connection, job, "failed", bug())
    return Settled("failed")


def _state_when_stopped(connection: Connection, job: Job) -> JobState:
    if job.cancel_requested:
        jobs.finish(connection, job, "cancelled")
        return "cancelled"
    jobs.give_back(connection, job, counted=False)  # the service stops; the next goes on
    return "queued"


def _problem(job: Job, error: BaseException) -> Mapping[str, Any] | None:
    if isinstance(error, Refusal):
        return problem_of(error)
    if isinstance(error, ChildFailed):
        log.error("bug", job=job.id, exc_info=error)
        return bug()
    log.warning("a child was lost", job=job.id, error=error)
    return None
