"""The state of a job whose work has ended, and its problem."""

import hashlib
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any

from sqlalchemy import Connection

from app.answers.problem import bug, problem_of
from app.ids import JobState, new_id
from app.jobs.kinds import JobKind
from app.jobs.refusals import Interrupted
from app.jobs.worker_process import ChildFailed, Stopped
from app.log.logs import log
from app.store import jobs, results
from app.store.job import Job, Listing
from app.store.jobs import NewJob
from app.store.plans import plan_of
from app.work.campaign import without_refused
from app.work.result import Part, Result
from planner.base.errors import Refusal

OF_CAMPAIGN = "campaign"  # among a job's options: the facts of the pass that it plans
_PART_RANK = 1  # after what somebody waits for


def settle(
    connection: Connection, job: Job, kind: JobKind, done: Future[Result], attempts_max: int
) -> Job:
    """Store the result of a job whose row is locked: the job then, with the plan where it made one.

    Its state is `running` while it waits for parts.
    """
    error = done.exception()
    if error is None:
        return _store(connection, job, kind, done.result())
    if isinstance(error, Stopped) and job.cancel_requested:
        return jobs.finish(connection, job, "cancelled")
    if isinstance(error, Stopped):  # the service stops; the next goes on
        return jobs.give_back(connection, job, counted=False)
    problem = _problem(job, error)
    if problem is None:
        return take_up_again(connection, job, attempts_max)
    state: JobState = "refused" if problem["status"] < 500 else "failed"
    if state == "refused" and OF_CAMPAIGN in job.options and not job.cancel_requested:
        _replace_refused(connection, job, kind, problem)
    return jobs.finish(connection, job, state, problem)


def _store(connection: Connection, job: Job, kind: JobKind, result: Result) -> Job:
    if kind.parts is not None and job.cancel_requested:  # a plan that is made anyway is kept
        return jobs.finish(connection, job, "cancelled")
    results.store(connection, job.id, result.content)
    if kind.parts is not None and result.parts:
        for part in result.parts:
            _accept_part(connection, kind.parts, part, job.id, job)
        return jobs.wait_for_parts(connection, job)
    place = jobs.place_in_series(connection, job) if kind.makes_plans else {}
    told = {} if result.listing is None else result.listing.columns(job.name)
    finished = jobs.finish(connection, job, result.state, **place, **told)
    return plan_of(finished, result.content) if kind.makes_plans else finished


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


def take_up_again(connection: Connection, job: Job, attempts_max: int) -> Job:
    """Back into the queue, unless whoever worked on it died too often."""
    if job.attempts < attempts_max:
        return jobs.give_back(connection, job, counted=True)
    problem = problem_of(
        Interrupted(
            f"the process that worked on it ended without a word {job.attempts} times; ask for "
            "less at a time, or again if the service was killed"
        )
    )
    return jobs.finish(connection, job, "failed", problem)


def give_up(connection: Connection, job: Job) -> Job:
    """Our failure, which no other attempt would mend."""
    return jobs.finish(connection, job, "failed", bug())


def _problem(job: Job, error: BaseException) -> Mapping[str, Any] | None:
    if isinstance(error, Refusal):
        return problem_of(error)
    if isinstance(error, ChildFailed):
        log.error("bug", job=job.id, exc_info=error)
        return bug()
    log.warning("a child was lost", job=job.id, error=error)
    return None
