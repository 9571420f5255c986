"""How does work that may run wild stay harmless?  In a process that can be thrown away.

Children are forked from a small server that has imported, and once done, what they are for, and
holds nothing of the service: they can be killed at any moment and take no lock with them.
One that answered soundly and didn't grow waits for more work, which then needn't wait for a fork;
any other is killed.  Each piece of work has its own bounds; memory is limited by RLIMIT_DATA,
which Linux applies to heaps and private mappings.
"""

import atexit
import ctypes
import multiprocessing
import os
import pickle
import resource
import signal
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import connection, forkserver
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Lock, Timer
from typing import Any, ClassVar, TypeVar

from app.jobs.progress import Progress, report_through
from app.observability.exceptions import traceback_text
from app.observability.logs import log
from planner.errors import Refusal

T = TypeVar("T")
# What the children run: the server imports it, and warms it up, once for all of them.
_IMPORTED = ["app.jobs.warm"]
_MEBIBYTE = 2**20
# A child that nothing is asked of for so long makes the server's pages it will write its own.
_IDLE_S = 0.02
# A spare is forked and warmed up, 60 ms of a processor, when the answer is out so that it takes
# nothing from that.
_ANSWER_S = 0.05
# A child that holds so much more than when it was born is thrown away: all kinds of plan one after
# the other take 64 MiB.
_GROWN_BYTES = 150 * _MEBIBYTE
# Most time a child may take to begin: the first of all waits until the server is warm.
_START_S = 120.0
# Most time from when a child has closed its line until it has ended by itself.
_END_S = 1.0
# What RLIMIT_DATA counts, used or not; and what is really held.
_LIMITED, _HELD = "VmData:", "RssAnon:"
_PR_SET_PDEATHSIG = 1  # linux/prctl.h

# What a child sends of a piece of work: that it begins, progress any number of times, then one of
# the others.
_BEGUN, _PROGRESS, _DONE, _REFUSED, _FAILED = range(5)


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Most time a piece of work may take, and most memory beyond what its process has already.

    alone: its process does nothing after, as what it reads may have taken it over.
    """

    deadline_s: float
    memory_mib: int
    alone: bool = False


class TooDemanding(Refusal):
    """Sound, but more work than one request may make."""

    slug: ClassVar[str] = "too-demanding"
    title: ClassVar[str] = "The request asks for too much at a time"


class ChildFailed(RuntimeError):
    """The work raised what is no refusal; the message tells where."""

    tells_no_secret: ClassVar[bool] = True


class ChildDied(RuntimeError):
    """The child ended without a word."""

    tells_no_secret: ClassVar[bool] = True


class Stopped(RuntimeError):
    """The work was stopped from outside."""


class Stop:
    """Lets any thread end a piece of work at once, before or while it runs."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._kill: Callable[[], None] | None = None
        self.requested = False

    def request(self) -> None:
        """The work's process is killed; may be called again."""
        with self._lock:
            self.requested = True
            if self._kill is not None:
                self._kill()

    @contextmanager
    def ending_by(self, kill: Callable[[], None]) -> Iterator[None]:
        """Inside, a request calls `kill`; raises Stopped when there was one before."""
        with self._lock:
            if self.requested:
                raise Stopped
            self._kill = kill
        try:
            yield
        finally:
            with self._lock:
                self._kill = None


class _Child:
    """A process that does the work it is given, one piece after the other."""

    # multiprocessing's bookkeeping of children isn't made for threads.
    _books = Lock()

    def __init__(self) -> None:
        context = multiprocessing.get_context("forkserver")
        self.line, childs_end = context.Pipe(duplex=True)
        self._process = context.Process(target=_do_all, args=(childs_end,), daemon=True)
        try:
            with self._books:
                start_server()
                self._process.start()
        except (EOFError, OSError) as error:  # the server was killed just now
            traceback.clear_frames(error.__traceback__)  # they hold its pipes
            self.line.close()
            raise
        finally:
            childs_end.close()

    def kill(self) -> None:
        if not self._has_ended(0.0):  # else its number may be another process's by now
            self._process.kill()

    def _has_ended(self, within_s: float) -> bool:
        return bool(connection.wait([self._process.sentinel], within_s))

    def exit_code(self) -> int | None:
        """Waits for the end, which comes soon."""
        if not self._has_ended(_END_S):
            self.kill()
            connection.wait([self._process.sentinel])
        with self._books:
            self._process.join()
            return self._process.exitcode

    def throw_away(self) -> None:
        """Dead when this returns, and nothing of it is left."""
        self.kill()
        self.exit_code()
        self.line.close()
        with self._books:
            self._process.close()


class _Children:
    """Those that work, and those that wait for work."""

    def __init__(self) -> None:
        self._waiting: list[_Child] = []
        self._working = 0
        self._kept = 0
        self._lock = Lock()
        self._forking = Lock()

    def keep(self, count: int) -> None:
        """So many from now on when there is nothing to do; with 0 they end with their work."""
        with self._lock:
            self._kept = count
            unwanted, self._waiting[count:] = self._waiting[count:], []
        for child in unwanted:
            child.throw_away()
        self._refill_after(0.0)

    def take(self) -> _Child:
        """The one that worked last of those that wait, or a new one."""
        return self._counted(lambda: self._that_waited() or _Child())

    def _counted(self, child: Callable[[], _Child]) -> _Child:
        """As one that works, unless there is none: the server may have been killed, too."""
        with self._lock:
            self._working += 1
        try:
            return child()
        except BaseException:
            with self._lock:
                self._working -= 1
            raise

    def _that_waited(self) -> _Child | None:
        while True:
            with self._lock:
                if not self._waiting:
                    return None
                child = self._waiting.pop()
            if not child.line.poll():
                return child
            child.throw_away()  # it says something unasked: that it was killed

    def give_back(self, child: _Child, may_do_more: bool) -> None:
        """What is thrown away is replaced when what was made of its answer is out, too."""
        with self._lock:
            self._working -= 1
            if may_do_more and len(self._waiting) < self._kept:
                self._waiting.append(child)
                return
        child.kill()
        self._refill_after(_ANSWER_S, child)

    def _refill_after(self, wait_s: float, gone: _Child | None = None) -> None:
        timer = Timer(wait_s, self._refill, (gone,))
        timer.daemon = True
        timer.start()

    def _refill(self, gone: _Child | None) -> None:
        if gone is not None:
            gone.throw_away()
        with self._forking:
            while self._working + len(self._waiting) < self._kept:
                try:
                    child = self._counted(_Child)
                except (EOFError, OSError) as error:  # work that finds none forks its own
                    if self._kept:
                        log.warning("a child couldn't be forked", error=error)
                    return
                self.give_back(child, may_do_more=True)


_children = _Children()


def start_server() -> None:
    """Begin to start the server children are forked from; returns at once."""
    # Read when NumPy is loaded: threads cost more than they save on matrices of this size.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    multiprocessing.get_context("forkserver").set_forkserver_preload(_IMPORTED)
    forkserver.ensure_running()


@atexit.register
def _end_server() -> None:
    """At once, its children with it: Python 3.13 waits until none holds its resource tracker."""
    pid = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    if pid is not None:
        os.kill(pid, signal.SIGKILL)


@contextmanager
def spare_children(count: int) -> Iterator[None]:
    """Inside, so many children wait ready."""
    _children.keep(count)
    try:
        yield
    finally:
        _children.keep(0)


def run_disposable(
    bounds: Bounds,
    work: Callable[..., T],
    *given: object,
    stop: Stop | None = None,
    on_progress: Callable[[Progress], None] | None = None,
) -> T:
    """What `work(*given)` returns; both go through pickle, so `work` is a module's function.

    stop: ends it from another thread.  on_progress: called here with what the work reports.
    Raises the Refusal that the work raises; TooDemanding beyond the bounds; Stopped;
    ChildFailed; ChildDied.
    """
    task = pickle.dumps((bounds, work, given))
    stop = stop or Stop()
    if stop.requested:
        raise Stopped
    child = _children.take()
    may_do_more = False
    try:
        with stop.ending_by(child.kill):
            kind, value, may_do_more = _outcome(child, task, bounds, on_progress)
    except ChildDied:
        if stop.requested:
            raise Stopped from None
        raise
    finally:
        _children.give_back(child, may_do_more and not stop.requested)
    if kind == _REFUSED:
        raise value
    if kind == _FAILED:
        raise ChildFailed(value)
    done: T = value
    return done


def _outcome(
    child: _Child, task: bytes, bounds: Bounds, on_progress: Callable[[Progress], None] | None
) -> tuple[int, Any, bool]:
    """How it ended, with what, and whether the child may do more."""
    try:
        child.line.send_bytes(task)
        if not child.line.poll(_START_S):
            raise ChildDied(f"it didn't begin within {_START_S:g} s")
        until_s = time.monotonic() + bounds.deadline_s
        while child.line.poll(max(until_s - time.monotonic(), 0.0)):
            kind, value, may_do_more = pickle.loads(child.line.recv_bytes())  # noqa: S301 (our child's)
            if kind in (_DONE, _REFUSED, _FAILED):
                return kind, value, may_do_more
            if kind == _PROGRESS and on_progress is not None:
                on_progress(value)
    except (EOFError, OSError):  # nothing comes any more, or not the rest of a message
        raise ChildDied(f"exit code {child.exit_code()}") from None
    raise TooDemanding(
        f"this takes more than the {bounds.deadline_s:g} s it may; ask for less at a time"
    )


def _do_all(line: Connection) -> None:
    """The child's whole life."""
    from app.jobs import warm  # here already, since the server imported it

    _die_with_service(warm.SERVER_PID)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the service's to handle
    _limit(resource.RLIMIT_CORE, 0)
    _say_nothing()
    if not line.poll(_IDLE_S):
        warm.warm_up()
    report_through(lambda progress: line.send_bytes(_packed(_PROGRESS, progress)))
    grown_bytes = _bytes(_HELD) + _GROWN_BYTES
    while True:
        try:
            bounds, work, given = pickle.loads(line.recv_bytes())  # noqa: S301 (our own service's)
        except (EOFError, ConnectionResetError):  # the service has ended
            return
        line.send_bytes(_packed(_BEGUN, None))
        _bind(bounds)
        line.send_bytes(_answer(bounds, work, given, grown_bytes))


def _answer(
    bounds: Bounds, work: Callable[..., object], given: tuple[object, ...], grown_bytes: int
) -> bytes:
    try:
        try:
            kind, value = _DONE, work(*given)
        except Refusal as refusal:
            kind, value = _REFUSED, refusal
        return _packed(kind, value, not bounds.alone and _bytes(_HELD) < grown_bytes)
    except MemoryError:
        too_much = TooDemanding(
            f"this takes more than the {bounds.memory_mib} MiB of memory it may; ask for less at "
            "a time"
        )
        return _packed(_REFUSED, too_much)
    except Exception as error:  # noqa: BLE001 (told to the parent, which raises it)
        return _packed(_FAILED, traceback_text(error))


def _packed(kind: int, value: object, may_do_more: bool = False) -> bytes:
    return pickle.dumps((kind, value, may_do_more))


def _bind(bounds: Bounds) -> None:
    """From here on, beyond what was used and is held already."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    may_use_s = bounds.deadline_s * (os.cpu_count() or 1)
    # However long it may hold the interpreter.
    _limit(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime + may_use_s) + 1)
    _limit(resource.RLIMIT_DATA, _bytes(_LIMITED) + bounds.memory_mib * _MEBIBYTE)


def _die_with_service(server_pid: int) -> None:
    """However the service ends, and whatever the child is at, the child is killed.

    The server ends when no process holds the far end of its pipe, which multiprocessing gives
    to every child too; let go of here, only the service holds it.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != server_pid:  # it was gone before the kernel was asked
        os.kill(os.getpid(), signal.SIGKILL)
    os.close(forkserver._forkserver._forkserver_alive_fd)  # type: ignore[attr-defined]


def _say_nothing() -> None:
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
