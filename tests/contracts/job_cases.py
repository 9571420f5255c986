"""Which kinds of work put the dispatcher to the test?  Children import them from here."""

import os
import signal
import time
import zlib
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import Connection

from app.jobs.child import Bounds
from app.jobs.kinds import PLAN, JobKind
from app.store.ids import JobState, new_id
from app.store.jobs import Job, NewJob
from app.store.packed import NewPlan
from app.work.progress import Progress, report


def made() -> NewPlan:
    return NewPlan(
        name="",
        state="done",
        input_sha256="",
        versions={},
        document=zlib.compress(b"{}"),
        table_columns=b"",
        planned_utc=datetime.now(UTC),
    )


@dataclass(frozen=True)
class BoundsWithABug:
    """Whoever looks at them fails, and says what it was at."""

    told: str

    @property
    def deadline_s(self) -> float:
        raise RuntimeError(self.told)


def note(request: bytes, _: object = None) -> NewPlan:
    """Adds its process to a file."""
    with Path(os.fsdecode(request)).open("a") as file:
        file.write(f"{os.getpid()}\n")
    return made()


def spin(*_: object) -> NewPlan:
    while True:
        pass


def hang(request: bytes, _: object = None) -> NewPlan:
    """Never ends, and uses a whole processor for it."""
    note(request)
    spin(request)
    return made()


def die(request: bytes, _: object = None) -> NewPlan:
    note(request)
    os.kill(os.getpid(), signal.SIGKILL)
    return made()


def die_once(request: bytes, _: object = None) -> NewPlan:
    return note(request) if Path(os.fsdecode(request)).exists() else die(request)


def hang_once(request: bytes, _: object = None) -> NewPlan:
    return note(request) if Path(os.fsdecode(request)).exists() else hang(request)


def linger(request: bytes, _: object = None) -> NewPlan:
    """Until let go."""
    while not _gate(Path(os.fsdecode(request))).exists():
        time.sleep(0.02)
    return note(request)


def tell(request: bytes, _: object = None) -> NewPlan:
    """Lingers, and says how far it is."""
    told = 0
    while not _gate(Path(os.fsdecode(request))).exists():
        told += 1
        report(Progress(stage="telling", done=told))
        time.sleep(0.02)
    return note(request)


def dwell(request: bytes, _: object = None) -> NewPlan:
    """Goes from stage to stage at once, and lingers in the last."""
    for stage in ("one", "two", "three"):
        report(Progress(stage=stage))
    return linger(request)


def fail(*_: object) -> NewPlan:
    raise RuntimeError("secret /etc/passwd")


def _store_twice(connection: Connection, job: Job, result: NewPlan) -> JobState:
    """What no database takes."""
    PLAN.store(connection, job, result)
    return PLAN.store(connection, job, result)


def repeat(request: bytes, asked: object = None) -> NewPlan:
    """Writes down what it was given beside the request's bytes."""
    with Path(os.fsdecode(request)).open("a") as file:
        file.write(f"{asked}\n")
    return made()


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


@dataclass(frozen=True)
class Notes:
    """What the children of one job wrote."""

    file: Path

    def pids(self) -> list[int]:
        return [int(line) for line in self.file.read_text().split()] if self.file.exists() else []


def _gate(file: Path) -> Path:
    return file.with_suffix(".go")


def let_go(file: Path) -> None:
    """Let the work that lingers with this file end."""
    _gate(file).touch()


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
