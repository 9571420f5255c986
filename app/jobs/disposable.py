"""How does work that may run wild stay harmless?  In a process of its own, thrown away after.

Children are forked from a small server that has imported, and once done, what they are for, and
holds nothing of the service: they can be killed at any moment and take no lock with them.
Some wait ready, so that work needn't wait for a fork.  Their memory is limited by RLIMIT_DATA,
which Linux applies to heaps and private mappings.
"""

import ctypes
import multiprocessing
import os
import pickle
import resource
import signal
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import connection, forkserver
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Lock, Timer
from typing import Any, ClassVar, TypeVar

from app.jobs.progress import Progress, report_through
from planner.errors import Refusal

T = TypeVar("T")
# What the children run: the server imports it, and warms it up, once for all of them.
_IMPORTED = ["app.jobs.warm"]
_MEBIBYTE = 2**20
# A child that nothing is asked of for so long makes the server's pages it will write its own.
_IDLE_S = 0.02
# A spare is forked and warmed up, 60 ms of a processor, when the answer is out so that it takes
# nothing from that; work as long as this leaves time enough meanwhile.
_ANSWER_S, _LONG_S = 0.05, 0.25
# Most time a child may take to begin: the first of all waits until the server is warm.
_START_S = 120.0
_PR_SET_PDEATHSIG = 1  # linux/prctl.h

# What a child sends: that it begins, progress any number of times, then one of the others.
_BEGUN, _PROGRESS, _DONE, _REFUSED, _FAILED = range(5)


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Most time a piece of work may take, and most memory beyond what its process starts with."""

    deadline_s: float
    memory_mib: int


class TooDemanding(Refusal):
    """Sound, but more work than one request may make."""

    slug: ClassVar[str] = "too-demanding"
    title: ClassVar[str] = "The request asks for too much at a time"


class ChildFailed(RuntimeError):
    """The work raised what is no refusal; the message holds its traceback."""


class ChildDied(RuntimeError):
    """The child ended without a word."""


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
    """A process that does one piece of work when it is given any."""

    # multiprocessing's bookkeeping of children isn't made for threads.
    _books = Lock()

    def __init__(self) -> None:
        context = multiprocessing.get_context("forkserver")
        self.line, childs_end = context.Pipe(duplex=True)
        self._process = context.Process(target=_do_one, args=(childs_end,), daemon=True)
        with self._books:
            start_server()
            self._process.start()
        childs_end.close()

    def kill(self) -> None:
        self._process.kill()

    def exit_code(self) -> int | None:
        """Waits for the end."""
        connection.wait([self._process.sentinel])
        with self._books:
            self._process.join()
            return self._process.exitcode

    def throw_away(self) -> None:
        """Dead when this returns, and nothing of it is left."""
        self.line.close()
        self.kill()
        self.exit_code()
        with self._books:
            self._process.close()


class _Spares:
    """Children that wait for work."""

    def __init__(self) -> None:
        self._ready: deque[_Child] = deque()
        self._count = 0
        self._lock = Lock()

    def keep(self, count: int) -> None:
        """So many from now on; with 0 those that wait are thrown away."""
        self._count = count
        if count:
            self.refill_after(0.0)
            return
        with self._lock:
            while self._ready:
                self._ready.popleft().throw_away()

    def take(self) -> _Child:
        """One that waits, or a new one."""
        while True:
            try:
                child = self._ready.popleft()
            except IndexError:
                return _Child()
            if not child.line.poll():
                return child
            child.throw_away()  # it says something unasked: that it was killed

    def refill_after(self, wait_s: float) -> Timer:
        """In the background, unless cancelled before."""
        timer = Timer(wait_s, self.refill)
        timer.daemon = True
        timer.start()
        return timer

    def replace(self, gone: _Child) -> None:
        """In the background, when what was made of the child's answer is out, too."""
        timer = Timer(_ANSWER_S, self._replace, (gone,))
        timer.daemon = True
        timer.start()

    def _replace(self, gone: _Child) -> None:
        gone.throw_away()
        self.refill()

    def refill(self) -> None:
        """Fork what is missing."""
        with self._lock:
            while len(self._ready) < self._count:
                self._ready.append(_Child())


_spares = _Spares()


def start_server() -> None:
    """Begin to start the server children are forked from; returns at once."""
    # Read when NumPy is loaded: threads cost more than they save on matrices of this size.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    multiprocessing.get_context("forkserver").set_forkserver_preload(_IMPORTED)
    forkserver.ensure_running()


@contextmanager
def spare_children(count: int) -> Iterator[None]:
    """Inside, so many children wait ready."""
    _spares.keep(count)
    try:
        yield
    finally:
        _spares.keep(0)


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
    child = _spares.take()
    refill = _spares.refill_after(_LONG_S)
    try:
        with stop.ending_by(child.kill):
            try:
                value: T = _outcome(child, task, bounds, on_progress)
            except ChildDied:
                if stop.requested:
                    raise Stopped from None
                raise
            return value
    finally:
        child.kill()
        refill.cancel()
        _spares.replace(child)


def _outcome(
    child: _Child, task: bytes, bounds: Bounds, on_progress: Callable[[Progress], None] | None
) -> Any:  # noqa: ANN401 (the work's)
    try:
        child.line.send_bytes(task)
        if not child.line.poll(_START_S):
            raise ChildDied(f"it didn't begin within {_START_S:g} s")
        until_s = time.monotonic() + bounds.deadline_s
        while child.line.poll(max(until_s - time.monotonic(), 0.0)):
            kind, value = pickle.loads(child.line.recv_bytes())  # noqa: S301 (our own child's)
            if kind == _DONE:
                return value
            if kind == _REFUSED:
                raise value
            if kind == _FAILED:
                raise ChildFailed(value)
            if kind == _PROGRESS and on_progress is not None:
                on_progress(value)
    except (EOFError, ConnectionError):
        raise ChildDied(f"exit code {child.exit_code()}") from None
    raise TooDemanding(
        f"this takes more than the {bounds.deadline_s:g} s it may; ask for less at a time"
    )


def _do_one(line: Connection) -> None:
    """The child's whole life."""
    from app.jobs import warm  # here already, since the server imported it

    _die_with_service()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the service's to handle
    try:
        if not line.poll(_IDLE_S):
            warm.warm_up()
        bounds, work, given = pickle.loads(line.recv_bytes())  # noqa: S301 (our own service's)
    except EOFError:
        return
    line.send_bytes(pickle.dumps((_BEGUN, None)))
    # However long it may hold the interpreter.
    _limit(resource.RLIMIT_CPU, int(bounds.deadline_s) * (os.cpu_count() or 1) + 1)
    _limit(resource.RLIMIT_CORE, 0)
    _limit(resource.RLIMIT_DATA, _data_bytes() + bounds.memory_mib * _MEBIBYTE)
    report_through(lambda progress: line.send_bytes(pickle.dumps((_PROGRESS, progress))))
    line.send_bytes(_answer(bounds, work, given))


def _answer(bounds: Bounds, work: Callable[..., object], given: tuple[object, ...]) -> bytes:
    try:
        return pickle.dumps((_DONE, work(*given)))
    except Refusal as refusal:
        return pickle.dumps((_REFUSED, refusal))
    except MemoryError:
        too_much = TooDemanding(
            f"this takes more than the {bounds.memory_mib} MiB of memory it may; ask for less at "
            "a time"
        )
        return pickle.dumps((_REFUSED, too_much))
    except Exception:  # noqa: BLE001 (told to the parent, which raises it)
        return pickle.dumps((_FAILED, traceback.format_exc()))


def _die_with_service() -> None:
    """However the service ends, and whatever the child is at, the child is killed.

    The server ends when no process holds the far end of its pipe, which multiprocessing gives
    to every child too; let go of here, only the service holds it.
    """
    os.close(forkserver._forkserver._forkserver_alive_fd)  # type: ignore[attr-defined]
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _limit(which: int, most: int) -> None:
    resource.setrlimit(which, (most, most))


def _data_bytes() -> int:
    """What the process already has of what RLIMIT_DATA counts."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmData:"):
            return int(line.split()[1]) * 1024
    raise RuntimeError("the kernel doesn't say VmData")
