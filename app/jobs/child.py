"""The life of a child process from its fork to its end: work, one piece after the other."""

import ctypes
import os
import pickle
import resource
import signal
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple

from app.log.exceptions import traceback_text
from app.work.progress import report_through
from planner.base.errors import Refusal

_MEBIBYTE = 2**20
# A child that nothing is asked of for so long makes the server's pages it will write its own.
_IDLE_S = 0.02
# A child that holds so much more than when it was born is thrown away: all kinds of plan one after
# the other take 64 MiB.
_GROWN_BYTES = 150 * _MEBIBYTE
# What RLIMIT_DATA counts, used or not; and what is really held.
_LIMITED, _HELD = "VmData:", "RssAnon:"
_PR_SET_PDEATHSIG = 1  # linux/prctl.h
OVERTIME = signal.SIGPROF  # of a child that has used its processor time; nothing handles it


class Message(NamedTuple):
    """What a child sends of a piece of work: `begun`, `progress` any number of times, an end.

    value: the Progress, the result, the Refusal, or where the work failed.  may_do_more: whether
    the child is fit for other work.
    """

    kind: Literal["begun", "progress", "done", "refused", "failed"]
    value: Any = None
    may_do_more: bool = False

    def to_bytes(self) -> bytes:
        return pickle.dumps(self)


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Most a piece of work may take, beyond what its process has taken already.

    deadline_s: of processor time, so that the same work ends alike on a busy machine.
    alone: its process does nothing after, as what it reads may have taken it over.
    """

    deadline_s: float
    memory_mib: int
    alone: bool = False


class TooDemanding(Refusal):
    """Sound, but more work than one request may make."""

    slug: ClassVar[str] = "too-demanding"
    title: ClassVar[str] = "The request asks for too much at a time"


def work_until_closed(line: Connection) -> None:
    from app.work import preload  # here already, since the server imported it

    _die_with_service(preload.SERVER_PID)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the service's to handle
    _limit(resource.RLIMIT_CORE, 0)
    _silence_output()
    if not line.poll(_IDLE_S):
        preload.preload()
    report_through(lambda progress: line.send_bytes(Message("progress", progress).to_bytes()))
    grown_bytes = _bytes(_HELD) + _GROWN_BYTES
    while True:
        try:
            bounds, work, arguments = pickle.loads(line.recv_bytes())  # noqa: S301 (our own service's)
        except (EOFError, ConnectionResetError):  # the service has ended
            return
        line.send_bytes(Message("begun").to_bytes())
        _limit(resource.RLIMIT_DATA, _bytes(_LIMITED) + bounds.memory_mib * _MEBIBYTE)
        # However long it may hold the interpreter, the kernel ends it by OVERTIME.
        signal.setitimer(signal.ITIMER_PROF, bounds.deadline_s)
        end = _end(bounds, work, arguments, grown_bytes)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        line.send_bytes(end)


def _end(
    bounds: Bounds, work: Callable[..., object], arguments: tuple[object, ...], grown_bytes: int
) -> bytes:
    try:
        try:
            end = Message("done", work(*arguments))
        except Refusal as refusal:
            end = Message("refused", refusal)
        fit = not bounds.alone and _bytes(_HELD) < grown_bytes
        return end._replace(may_do_more=fit).to_bytes()
    except MemoryError:
        too_much = TooDemanding(
            f"this took more than the {bounds.memory_mib} MiB of memory that a request may take; "
            "ask for less at a time"
        )
        return Message("refused", too_much).to_bytes()
    except Exception as error:  # noqa: BLE001 (told to the parent, which raises it)
        return Message("failed", traceback_text(error)).to_bytes()


def _die_with_service(server_pid: int) -> None:
    """However the service ends, and whatever the child is at, the child is killed.

    The server ends when no process holds the far end of its pipe, which multiprocessing gives
    to every child too; let go of here, only the service holds it.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != server_pid:  # it was gone before the kernel was asked
        os.kill(os.getpid(), signal.SIGKILL)
    os.close(forkserver._forkserver._forkserver_alive_fd)  # type: ignore[attr-defined]


def _silence_output() -> None:
    """What libraries print in C, and Python of what nobody catches, may hold the request."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    os.close(nowhere)


def _limit(which: int, most: int) -> None:
    resource.setrlimit(which, (most, resource.RLIM_INFINITY))


def _bytes(kind: str) -> int:
    """What this process has of a kind of memory, a line of Linux's proc_pid_status."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(kind):
            return int(line.split()[1]) * 1024
    raise RuntimeError(f"the kernel doesn't say {kind}")
