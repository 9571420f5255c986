"""Kinds of work that put the dispatcher to the test."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from child_work import (
    die,
    die_once,
    dwell,
    fail,
    hang,
    hang_once,
    linger,
    note,
    repeat,
    spin,
    tell,
)
from distributed import get_worker
from sqlalchemy import Connection

from app.jobs.child import Bounds
from app.jobs.kinds import PLAN, JobKind
from app.store.ids import JobState, new_id
from app.store.jobs import Job, NewJob
from app.store.packed import NewPlan


@dataclass(frozen=True)
class BoundsWithABug:
    """The worker that hands them on to its child fails, and says what it was at."""

    told: str

    def __getstate__(self) -> dict[str, object]:
        try:
            get_worker()
        except ValueError:  # not on a worker yet
            return vars(self)
        raise RuntimeError(self.told)


def _store_twice(connection: Connection, job: Job, result: NewPlan) -> JobState:
    """What no database takes."""
    PLAN.store(connection, job, result)
    return PLAN.store(connection, job, result)


WORKS = (note, spin, hang, die, die_once, hang_once, linger, tell, dwell, fail, repeat)
KINDS = {
    work.__name__: JobKind(
        name=work.__name__,
        bounds=Bounds(deadline_s=120.0, memory_mib=200),
        work=work,
        store=PLAN.store,
    )
    for work in WORKS
}
KINDS["unstorable"] = replace(KINDS["note"], name="unstorable", store=_store_twice)


def new_job(kind: str, file: Path, **members: object) -> NewJob:
    given = {
        "id": new_id(),
        "kind": kind,
        "name": "",
        "request": os.fsencode(file),
        "request_sha256": "0" * 64,
        "deadline_s": 120.0,
    }
    return NewJob(**given | members)
