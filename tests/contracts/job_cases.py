"""Kinds of work that put the dispatcher to the test."""

import os
from concurrent.futures import Future
from dataclasses import dataclass, replace
from pathlib import Path

import child_work as does
from distributed import get_worker

from app.ids import new_id
from app.jobs.child import Bounds
from app.jobs.job_completion import settle
from app.jobs.kinds import JobKind
from app.jobs.shares import Shares
from app.store import jobs
from app.store.jobs import NewJob


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


WORKS = (
    *(does.note, does.spin, does.rest, does.hang, does.hang_once, does.die, does.die_once),
    *(does.linger, does.tell, does.dwell, does.fail, does.repeat, does.leave_out),
)
KINDS = {
    work.__name__: JobKind(
        name=work.__name__,
        bounds=Bounds(deadline_s=120.0, memory_mib=200),
        work=work,
        makes_plans=True,
    )
    for work in WORKS
}
SHARES = Shares(may_be=bool, split=does.share_out, work=does.die_once_each, stage="shares")
KINDS["gather"] = replace(KINDS["note"], name="gather", work=does.gather, shares=SHARES)


def new_job(kind: str, file: Path | str = "", **members: object) -> NewJob:
    given = {
        "id": new_id(),
        "kind": kind,
        "name": "",
        "request": os.fsencode(file),
        "request_sha256": "0" * 64,
        "deadline_s": 120.0,
    }
    return NewJob(**given | members)


def ended_with(database, kind: JobKind, token: str, result: object) -> str:
    """The state of a job whose work ends so, stored as the dispatcher does."""
    done = Future()
    done.set_exception(result) if isinstance(result, Exception) else done.set_result(result)
    with database.writing() as connection:
        return settle(connection, jobs.job_of_lease(connection, token), kind, done, 3).state
