"""Jobs: the work accepted, its lease, and its result.

A job belongs to whoever holds its lease. A lease is taken in one transaction, lengthened while
the work goes on, and asked for again when the result is stored: whoever lost it stores nothing.
"""

import secrets
import zlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Float,
    Row,
    Select,
    bindparam,
    delete,
    exists,
    func,
    insert,
    not_,
    or_,
    select,
    update,
)
from sqlalchemy.orm import aliased

from app.ids import OPEN_STATES, JobState
from app.store import events
from app.store.job import Job, Listing, folded
from app.store.models import JobRow, KeyRow, database_now_s
from app.store.packed import unzip
from planner.world.frames.time_scales import utc_from_text

# By the name of a list's filter: the condition it sets.  name: in the job's; target: in a target's;
# text: in the name, the platform's or a target's; upper and lower case are alike in the last two.
# before, after: UTC text; what is looked at begins, ends so.
FILTERS: Mapping[str, Callable[[Any], ColumnElement[bool]]] = {
    "state": lambda state: JobRow.state == state,
    "name": lambda name: JobRow.name.contains(name, autoescape=True),
    "target": lambda text: JobRow.target_words.contains(folded(text), autoescape=True),
    "text": lambda text: JobRow.words.contains(folded(text), autoescape=True),
    "before": lambda utc: JobRow.start_utc < utc_from_text(utc),
    "after": lambda utc: JobRow.stop_utc > utc_from_text(utc),
}


@dataclass(frozen=True, kw_only=True)
class NewJob:
    """Work to accept.  idempotency: see `JobRow`."""

    id: str
    kind: str
    name: str
    request: bytes
    request_sha256: str
    deadline_s: float
    options: Mapping[str, Any] = field(default_factory=dict)
    key_id: str | None = None
    idempotency: str | None = None
    parent_id: str | None = None
    plan_id: str | None = None
    revises: str | None = None
    rank: int = 0
    listing: Listing = field(default_factory=Listing)


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A job that is ours while the lease lasts."""

    job: Job
    request: bytes
    token: str


# Among a job's options: that it is nothing without each of its parts; what they are called.
NEEDS_ALL = "parts"
_WHOLE = aliased(JobRow)
_UNWANTED: ColumnElement[bool] = or_(
    JobRow.cancel_requested,
    exists().where(_WHOLE.id == JobRow.parent_id, _WHOLE.cancel_requested),
)
_DERIVED: dict[str, ColumnElement[Any]] = {
    "cancel_requested": _UNWANTED,
    "requested_by": select(KeyRow.name).where(KeyRow.id == JobRow.key_id).scalar_subquery(),
}
_COLUMNS = tuple(
    _DERIVED[name].label(name) if name in _DERIVED else getattr(JobRow, name)
    for name in Job.__dataclass_fields__
)
# Statements of every plan, built once: that takes longer than SQLite needs to answer them.
_JOBS = select(*_COLUMNS)
# Rows are locked but for their keys: on PostgreSQL rows that refer to one hold that against loss.
_JOB = _JOBS.where(JobRow.id == bindparam("of_job"))
_JOB_OF_LEASE = _JOBS.where(JobRow.lease_token == bindparam("of_token")).with_for_update(
    key_share=True
)
_JOB_OF_KEY = _JOBS.where(JobRow.idempotency == bindparam("of_key"))
_NEW = insert(JobRow).values(
    lease_until_s=database_now_s() + bindparam("lease_s", type_=Float())  # null without a lease
)
_CHANGE = update(JobRow).where(JobRow.id == bindparam("of_job"))


def accept(connection: Connection, new: NewJob, lease_s: float | None = None) -> str | None:
    """Store a job; with `lease_s` it is the caller's at once, under the token returned."""
    if lease_s is None:
        _insert(connection, new, {})
        events.begin(connection, new.id, {"state": "queued"})
        return None
    token = secrets.token_hex(16)
    begun = {"state": "running", "attempts": 1, "lease_token": token, "lease_s": lease_s}
    _insert(connection, new, begun | {"started_utc": datetime.now(UTC)})
    events.begin(connection, new.id, {"state": "queued"}, {"state": "running", "attempt": 1})
    return token


def record_done(connection: Connection, new: NewJob, begun_utc: datetime) -> None:
    """Keep what was done before anybody else could be told of it."""
    begun = {"created_utc": begun_utc, "started_utc": begun_utc, "attempts": 1}
    done = {"state": "done", "finished_utc": datetime.now(UTC)}
    _insert(connection, new, begun | done)


def _insert(connection: Connection, new: NewJob, stands: dict[str, Any]) -> None:
    """As it stands, in the queue unless that says otherwise."""
    asked = {name: value for name, value in vars(new).items() if name != "listing"}
    queued = {
        "state": "queued",
        "attempts": 0,
        "lease_token": None,
        "lease_s": None,
        "created_utc": datetime.now(UTC),
        "started_utc": None,
        "finished_utc": None,
        "cancel_requested": False,
        "request": zlib.compress(new.request),
    }
    connection.execute(_NEW, asked | new.listing.columns(new.name) | queued | stands)


def get(connection: Connection, job_id: str) -> Job | None:
    return _one(connection, _JOB, of_job=job_id)


def find_idempotent(connection: Connection, idempotency: str) -> Job | None:
    """The job accepted under this key before."""
    return _one(connection, _JOB_OF_KEY, of_key=idempotency)


def request_of(connection: Connection, job_id: str) -> bytes | None:
    found = connection.scalar(select(JobRow.request).where(JobRow.id == job_id))
    return None if found is None else unzip(found)


def latest(
    connection: Connection,
    kind: str,
    limit: int,
    *,
    before: str | None = None,
    parent_id: str | None = None,
    plan_id: str | None = None,
    filters: Mapping[str, Any] = MappingProxyType({}),
) -> list[Job]:
    """Jobs of a kind, the latest first; `before` an id.  filters: by `FILTERS`, None of no use.

    Parts of the larger job, or without one those that are no parts; with `plan_id` those about
    that plan.
    """
    conditions = [JobRow.kind == kind, JobRow.parent_id == parent_id]
    conditions += [FILTERS[name](asked) for name, asked in filters.items() if asked is not None]
    if plan_id is not None:
        conditions.append(JobRow.plan_id == plan_id)
    if before is not None:
        conditions.append(JobRow.id < before)
    found = connection.execute(_JOBS.where(*conditions).order_by(JobRow.id.desc()).limit(limit))
    return [_job(row) for row in found]


def count_waiting(connection: Connection) -> int:
    """Jobs nobody works on yet; parts of a larger job aside, which was counted itself."""
    waiting = JobRow.state == "queued", JobRow.parent_id.is_(None)
    return connection.scalar(select(func.count()).where(*waiting)) or 0


def counts(connection: Connection) -> dict[tuple[str, str], int]:
    """How many, by (kind, state)."""
    grouped = select(JobRow.kind, JobRow.state, func.count()).group_by(JobRow.kind, JobRow.state)
    return {(kind, state): count for kind, state, count in connection.execute(grouped)}


def is_work_waiting(connection: Connection, kinds: Collection[str]) -> bool:
    """Whether `claim` would find anything."""
    either = or_(*(exists().where(*conditions) for conditions in _claimable(kinds)))
    return bool(connection.scalar(select(either)))


def claim(connection: Connection, kinds: Collection[str], lease_s: float) -> Claim | None:
    """Take the next job: one whose lease ran out, else the first in the queue.

    Returns the job as it was before, with the attempts made so far.
    """
    for conditions in _claimable(kinds):
        row = connection.execute(
            select(*_COLUMNS, JobRow.request)
            .where(*conditions)
            .order_by(JobRow.rank, JobRow.id)
            .limit(1)
            .with_for_update(skip_locked=True, key_share=True)
        ).one_or_none()
        if row is None:
            continue
        token, job, request = secrets.token_hex(16), _job(row), unzip(row._mapping["request"])
        begun = {
            "attempts": JobRow.attempts + 1,
            "lease_token": token,
            "lease_until_s": database_now_s() + lease_s,
            "started_utc": job.started_utc or datetime.now(UTC),
        }
        connection.execute(
            update(JobRow).where(JobRow.id == job.id).values(state="running", **begun)
        )
        data = {"state": "running", "attempt": job.attempts + 1}
        events.record(connection, job.id, events.STATE, data)
        return Claim(job=job, request=request, token=token)
    return None


def _claimable(kinds: Collection[str]) -> tuple[tuple[ColumnElement[bool], ...], ...]:
    of_kinds = JobRow.kind.in_(kinds)
    return (
        (JobRow.state == "running", JobRow.lease_until_s < database_now_s(), of_kinds),
        (JobRow.state == "queued", of_kinds),
    )


def extend(connection: Connection, tokens: Collection[str], lease_s: float) -> frozenset[str]:
    """Lengthen leases; returns those `leases_to_end`."""
    mine = JobRow.lease_token.in_(tokens)
    connection.execute(update(JobRow).where(mine).values(lease_until_s=database_now_s() + lease_s))
    return leases_to_end(connection, tokens)


def leases_to_end(connection: Connection, tokens: Collection[str]) -> frozenset[str]:
    """Leases that are no longer ours, or on jobs that somebody wants to end."""
    still_ours = connection.scalars(
        select(JobRow.lease_token).where(JobRow.lease_token.in_(tokens), not_(_UNWANTED))
    )
    return frozenset(tokens) - frozenset(still_ours)


def job_of_lease(connection: Connection, token: str) -> Job | None:
    """The job of a lease that is still ours, locked until the transaction ends."""
    return _one(connection, _JOB_OF_LEASE, of_token=token)


def finish(
    connection: Connection,
    job: Job,
    state: JobState,
    problem: Mapping[str, Any] | None = None,
    **columns: Any,  # noqa: ANN401 (of a row)
) -> Job:
    """What became of a job that this transaction has locked; columns: told anew of it."""
    told = None if problem is None else dict(problem)
    columns |= {"finished_utc": datetime.now(UTC), "problem": told}
    data = {"state": state} if told is None else {"state": state, "problem": told}
    finished = _change(connection, job, state, data, **columns)
    if job.parent_id is not None:
        _record_end_of_part(connection, job.parent_id)
    return finished


def place_in_series(connection: Connection, job: Job) -> dict[str, Any]:
    """Of a plan that is made now: the latest revision of the series of the one it revises."""
    of_revised = select(JobRow.series).where(JobRow.id == job.revises)
    series = None if job.revises is None else connection.scalar(of_revised)
    if series is None:
        return {"series": job.id, "revision": 1}
    of_series = JobRow.series == series
    locked = select(JobRow.id).where(of_series).order_by(JobRow.id).with_for_update(key_share=True)
    connection.execute(locked)  # one by one
    last = connection.scalar(select(func.max(JobRow.revision)).where(of_series)) or 0
    return {"series": series, "revision": last + 1}


def wait_for_parts(connection: Connection, job: Job) -> Job:
    """Nobody works on a locked job any more; the last of its parts to finish finishes it."""
    return _change(connection, job, "running", {"state": "running", "waits_for": "parts"})


def parts_of(connection: Connection, job_id: str) -> list[Job]:
    """Jobs that are parts of this one, the oldest first."""
    found = connection.execute(_JOBS.where(JobRow.parent_id == job_id).order_by(JobRow.id))
    return [_job(row) for row in found]


def _record_end_of_part(connection: Connection, whole_id: str) -> None:
    # Locked before its parts are counted: of two that end together one sees the other.
    locked = _JOBS.where(JobRow.id == whole_id).with_for_update(of=JobRow, key_share=True)
    row = connection.execute(locked).one()
    whole = _job(row)
    grouped = connection.execute(
        select(JobRow.state, func.count())
        .where(JobRow.parent_id == whole_id)
        .group_by(JobRow.state)
    )
    counted = {state: int(count) for state, count in grouped}
    left = sum(counted.get(state, 0) for state in OPEN_STATES)
    done = sum(counted.values()) - left
    data = {"stage": whole.options.get(NEEDS_ALL, "plans"), "done": done, "of": done + left}
    events.record(connection, whole_id, events.PROGRESS, data)
    if left:
        return
    if whole.cancel_requested:
        finish(connection, whole, "cancelled")
    elif NEEDS_ALL in whole.options and counted.get("done", 0) < done:
        broken = next(part for part in parts_of(connection, whole_id) if part.state != "done")
        finish(connection, whole, broken.state, broken.problem)
    else:
        finish(connection, whole, "done")


def give_back(connection: Connection, job: Job, *, counted: bool) -> Job:
    """Put a locked job back into the queue; `counted`: the attempt was one."""
    attempts = job.attempts if counted else job.attempts - 1
    return _change(connection, job, "queued", {"state": "queued"}, attempts=attempts)


def _change(
    connection: Connection, job: Job, state: JobState, data: dict[str, Any], **columns: object
) -> Job:
    ends_lease = {"lease_token": None, "lease_until_s": None}
    connection.execute(_CHANGE, {"of_job": job.id, "state": state, **ends_lease, **columns})
    events.record(connection, job.id, events.STATE, data)
    changed = {name: value for name, value in columns.items() if name in Job.__dataclass_fields__}
    return replace(job, state=state, **changed)  # type: ignore[arg-type]


def cancel(connection: Connection, job_id: str) -> Job | None:
    """End a job in the queue; one that runs is marked for whoever works on it."""
    job = _one(connection, _JOB.with_for_update(key_share=True), of_job=job_id)
    if job is None:
        return None
    if job.state == "queued":
        finish(connection, job, "cancelled")
    elif job.state == "running" and not job.cancel_requested:
        connection.execute(update(JobRow).where(JobRow.id == job_id).values(cancel_requested=True))
    return get(connection, job_id)


def remove(connection: Connection, job_id: str) -> bool:
    """Delete a finished job with what it made, its events and flights; False if there is none."""
    gone = connection.execute(
        delete(JobRow).where(JobRow.id == job_id, JobRow.state.not_in(OPEN_STATES))
    )
    if gone.rowcount == 0:
        return False
    connection.execute(delete(JobRow).where(JobRow.plan_id == job_id))
    return True


def remove_finished(connection: Connection, before_utc: datetime, limit: int) -> list[str]:
    """Delete up to `limit` jobs that finished before then, parts only with their whole."""
    found = connection.scalars(
        select(JobRow.id)
        .where(JobRow.finished_utc < before_utc, JobRow.parent_id.is_(None))
        .limit(limit)
    ).all()
    gone = or_(JobRow.id.in_(found), JobRow.plan_id.in_(found))
    connection.execute(delete(JobRow).where(gone))
    return list(found)


def _one(connection: Connection, query: Select[*tuple[Any, ...]], **parameters: str) -> Job | None:
    row = connection.execute(query, parameters).one_or_none()
    return None if row is None else _job(row)


def _job(row: Row[*tuple[Any, ...]]) -> Job:
    members = {name: row._mapping[name] for name in Job.__dataclass_fields__}
    targets, count = members["targets"] or [], members["target_count"] or 0
    return Job(**members | {"targets": targets, "target_count": count})
