"""Work of children under test, importing nothing that they wouldn't have anyway."""

import os
import signal
import struct
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from app.work.progress import report
from app.work.result import Result
from planner.base.errors import FieldError, InvalidInput, InvalidRequest


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


def made() -> Result:
    return Result(content=(zlib.compress(b"{}"), b""))


def note(request: bytes, *_: object) -> Result:
    """Adds its process to a file."""
    with Path(os.fsdecode(request)).open("a") as file:
        file.write(f"{os.getpid()}\n")
    return made()


def spin(*_: object) -> Result:
    """Never ends, and uses a whole processor for it."""
    while True:
        pass


def rest(*_: object) -> Result:
    """Never ends either, and leaves the processor to others."""
    while True:
        time.sleep(3600.0)


def hang(request: bytes, *_: object) -> Result:
    note(request)
    return spin()


def die(request: bytes, *_: object) -> Result:
    note(request)
    os.kill(os.getpid(), signal.SIGKILL)
    return made()


def die_once(request: bytes, *_: object) -> Result:
    return note(request) if Path(os.fsdecode(request)).exists() else die(request)


def hang_once(request: bytes, *_: object) -> Result:
    return note(request) if Path(os.fsdecode(request)).exists() else hang(request)


def find_once_hung(file: bytes, *search: Any) -> object:
    """Windows, but for the first who is asked."""
    hang_once(file)
    from app.work.searches import find_windows  # which the others don't have

    return find_windows(*search)


def find_looks_once(lose: Callable[[bytes], Result], given: bytes) -> bytes:
    """Of a carrier, but for the first who is asked; given: a file's name before what is to do."""
    file, _, packed = given.partition(b"\n")
    lose(file)
    from planner.planning.campaigns.apart import find_looks  # which the others don't have

    return find_looks(packed)


def share_out(request: bytes, _: object, made: Sequence[bytes] = ()) -> list[bytes]:
    """A file for each of three, once."""
    return [] if made else [request + number for number in (b"0", b"1", b"2")]


def die_once_each(request: bytes) -> bytes:
    die_once(request)
    return request


def gather(request: bytes, _: object, shares: Sequence[bytes] = ()) -> Result:
    assert list(shares) == share_out(request, None, ())
    return note(request)


def linger(request: bytes, *_: object) -> Result:
    """Until let go."""
    while not _gate(Path(os.fsdecode(request))).exists():
        time.sleep(0.02)
    return note(request)


def tell(request: bytes, *_: object) -> Result:
    """Lingers, and says how far it is."""
    told = 0
    while not _gate(Path(os.fsdecode(request))).exists():
        told += 1
        report("telling", told)
        time.sleep(0.02)
    return note(request)


def dwell(request: bytes, *_: object) -> Result:
    """Goes from stage to stage at once, and lingers in the last."""
    for stage in ("one", "two", "three"):
        report(stage)
    return linger(request)


def abort(*_: object) -> None:
    os.abort()


def fail(*_: object) -> Result:
    raise RuntimeError("secret /etc/passwd")


def leave_out(request: bytes, *_: object) -> Result:
    """What no database takes."""
    note(request)
    return Result(content=(None,))


def hoard(*_: object) -> bytes:
    """More memory than any work may take."""
    return bytes(2**30)


def repeat(request: bytes, asked: object = None) -> Result:
    """Writes down what it was given beside the request's bytes."""
    with Path(os.fsdecode(request)).open("a") as file:
        file.write(f"{asked}\n")
    return made()


def refuse(detail):
    raise InvalidInput(detail, field="sessions.0", limit="rate")


def refuse_by(refusal, *_):
    raise refusal


def refuse_unread(*_):
    faults = (
        FieldError(field="name", detail="is none", value=-0.5),
        FieldError(field="", detail=""),
    )
    raise InvalidRequest(*faults)


def say_how_far():
    report("begun")
    report("half", 1, 2)


def used_to_end():
    """The process, and the processor time it may still use until it is killed."""
    return os.getpid(), signal.getitimer(signal.ITIMER_PROF)[0]


def allocate(size):
    return len(bytes(size))


kept: list[bytes] = []


def keep_much():
    kept.append(b"." * (180 * 2**20))
    return os.getpid()


def die_within_a_word():
    def send_half(line, _):
        os.write(line.fileno(), struct.pack("!i", 1000) + b"half")
        os.abort()

    Connection._send = send_half


def fall_silent():
    os.closerange(3, 100)
    time.sleep(3600.0)
