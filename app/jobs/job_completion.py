"""The state of a job whose work has ended, and its problem."""

import hashlib
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any, NamedTuple

from sqlalchemy import Connection

from app.answers.problem import bug, problem_of
from app.ids import JobState, new_id
from app.jobs.kinds import JobKind
from app.jobs.refusals import Interrupted
from app.jobs.worker_process import ChildFailed, Stopped
from app.log.logs import log
from app.store import jobs, results
from app.store.job import Job
from app.store.jobs import NewJob
from app.store.listing import Listing
from app.store.plans import StoredPlan, plan_of
from app.work.campaign import without_refused
from app.work.result import Part, Result
from planner.base.errors import Refusal

OF_CAMPAIGN = "campaign"  # among a job's options: the facts of the pass that it plans
_PART_RANK = 1  # after what somebody waits for


class Settled(NamedTuple):
    """The state a job has when its work has ended, `running` while it waits for parts.

    plan: as it was stored, for who waits for it; None where none was made.
    """

    state: JobState
    plan: StoredPlan | None = None


def settle(
    connection: Connection, job: Job, kind: JobKind, done: Future[Result], attempts_max: int
) -> Settled:
    """Store the result of a job whose row is locked."""
    error = done.exception()
    if error is None:
        return _store(connection, job, kind, done.result())
    if isinstance(error, Stopped):
        return Settled(_state_when_stopped(connection, job))
    problem = _problem(job, error)
    if problem is None:
        return Settled(take_up_again(connection, job, attempts_max))
    state: JobState = "refused" if problem["status"] < 500 else "failed"
    if state == "refused" and OF_CAMPAIGN in job.options and not job.cancel_requested:
        _replace_refused(connection, job, kind, problem)
    jobs.finish(connection, job, state, problem)
    return Settled(state)


def _store(connection: Connection, job: Job, kind: JobKind, result: Result) -> Settled:
    if kind.parts is not None and job.cancel_requested:  # a plan that is made anyway is kept
        jobs.finish(connection, job, "cancelled")
        return Settled("cancelled")
    results.store(connection, job.id, result.content)
    if kind.parts is not None and result.parts:
        for part in result.parts:
            _accept_part(connection, kind.parts, part, job.id, job)
        jobs.wait_for_parts(connection, job)
        return Settled("running")
    place = jobs.place_in_series(connection, job) if kind.makes_plans else {}
    told = {} if result.listing is None else result.listing.columns(job.name)
    finished = jobs.finish(connection, job, result.state, **place, **told)
    return Settled(result.state, plan_of(finished, result.content) if kind.makes_plans else None)


def _accept_part(
    connection: Connection, kind: JobKind, part: Part, whole_id: str | None, like: Job
) -> None:
    """like: with the same key, and no more time."""
    new = NewJob(
        id=new_id(),
        kind=kind.name,
        name=part.name,
        request=part.request,
        request_sha256=hashlib.sha256(part.request).hexdigest(),
        deadline_s=min(kind.bounds.deadline_s, like.deadline_s),
        options={OF_CAMPAIGN: dict(part.facts)} if part.facts else {},
        key_id=like.key_id,
        parent_id=whole_id,
        rank=_PART_RANK,
        listing=part.listing,
    )
    jobs.accept(connection, new)


def _replace_refused(
    connection: Connection, refused: Job, kind: JobKind, problem: Mapping[str, Any]
) -> None:
    """Accept a campaign's pass once more without the look at fault, if any other is left.

    In the transaction that finishes the refused plan, whose row it holds, so that the campaign
    never sees itself complete in between.
    """
    part = Part(
        request=jobs.request_of(connection, refused.id) or b"",
        name=refused.name,
        listing=Listing(platform=refused.platform or ""),
        facts=refused.options[OF_CAMPAIGN],
    )
    repaired = without_refused(part, problem.get("field"), problem["detail"])
    if repaired is not None:
        _accept_part(connection, kind, repaired, refused.parent_id, refused)


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
