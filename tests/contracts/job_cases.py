"""Kinds of work that put the dispatcher to the test."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from child_work import (
    die,
    die_once,
    die_once_each,
    dwell,
    fail,
    gather,
    hang,
    hang_once,
    leave_out,
    linger,
    note,
    repeat,
    rest,
    share_out,
    spin,
    tell,
)
from distributed import get_worker

from app.ids import new_id
from app.jobs.child import Bounds
from app.jobs.kinds import JobKind
from app.jobs.shares import Shares
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
    *(note, spin, rest, hang, hang_once, die, die_once, linger, tell, dwell, fail, repeat),
    leave_out,
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
SHARES = Shares(may_be=bool, split=share_out, work=die_once_each, stage="shares")
KINDS["gather"] = replace(KINDS["note"], name="gather", work=gather, shares=SHARES)


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
