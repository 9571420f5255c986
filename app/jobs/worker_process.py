"""Work that may run wild, in a process that can be thrown away.

Children are forked from a small server that has imported, and once done, what they are for, and
holds nothing of the service: they can be killed at any moment and take no lock with them.
One that answered soundly and didn't grow waits for more work, which then needn't wait for a fork;
any other is killed.  Each piece of work has its own bounds; memory is limited by RLIMIT_DATA,
which Linux applies to heaps and private mappings.
"""

import atexit
import multiprocessing
import os
import pickle
import signal
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing import connection, forkserver
from threading import Lock, Timer
from typing import Any, ClassVar, Protocol, TypeVar

from app.jobs.child import OVERTIME, Bounds, Message, TooDemanding, work_until_closed
from app.log.logs import log
from app.work.progress import OnProgress

T = TypeVar("T")
# What the children run: the server imports it, and warms it up, once for all of them.
_IMPORTED = ["app.work.preload"]
# A spare is forked and warmed up, 60 ms of a processor, when the answer is out so that it takes
# nothing from that.
_ANSWER_S = 0.05
# Most time a child may take to begin: the first of all waits until the server is warm.
_START_S = 120.0
_CPUCLOCK_SCHED = 2  # linux/posix-timers_types.h: the clock of a process is ~pid << 3 with it
# A child that says nothing and uses less than _STILL_S of a processor in so long hangs: on the
# busiest machine one that works gets more.
_SILENT_S, _STILL_S = 600.0, 0.01
# Most time from when a child has closed its line until it has ended by itself.
_END_S = 1.0


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
        self._process = context.Process(target=work_until_closed, args=(childs_end,), daemon=True)
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

    def processor_s(self) -> float:
        """What all its threads have used."""
        pid = self._process.pid
        if pid is None or self._has_ended(0.0):
            return 0.0
        return time.clock_gettime(~pid << 3 | _CPUCLOCK_SCHED)

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
    """Those that work, and those that wait for work: `_kept` together while there are fewer.

    A child counts as one that works from before it is forked until it is given back.
    """

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
        with self._one_more_working():
            return self._next_waiting() or _Child()

    @contextmanager
    def _one_more_working(self) -> Iterator[None]:
        """Unless none comes of it: the server may have been killed, too."""
        with self._lock:
            self._working += 1
        try:
            yield
        except BaseException:
            with self._lock:
                self._working -= 1
            raise

    def _next_waiting(self) -> _Child | None:
        while True:
            with self._lock:
                if not self._waiting:
                    return None
                child = self._waiting.pop()
            if not child.line.poll():
                return child
            child.throw_away()  # it says something unasked: that it was killed

    def give_back(self, child: _Child, may_do_more: bool) -> None:
        """It waits for more work, or is killed, and replaced when its answer is out."""
        with self._lock:
            self._working -= 1
            if may_do_more and len(self._waiting) < self._kept:
                self._waiting.append(child)
                return
        child.kill()
        self._refill_after(_ANSWER_S, child)

    def _refill_after(self, wait_s: float, old: _Child | None = None) -> None:
        timer = Timer(wait_s, self._refill, (old,))
        timer.daemon = True
        timer.start()

    def _refill(self, old: _Child | None) -> None:
        if old is not None:
            old.throw_away()
        with self._forking:
            while self._working + len(self._waiting) < self._kept:
                try:
                    with self._one_more_working():
                        child = _Child()
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


def run_in_worker(
    bounds: Bounds,
    work: Callable[..., T],
    *arguments: object,
    stop: Stop | None = None,
    on_progress: OnProgress | None = None,
) -> T:
    """What `work(*arguments)` returns; both go through pickle, so `work` is a module's function.

    stop: ends it from another thread.  on_progress: called here with what the work reports.
    Raises the Refusal that the work raises; TooDemanding beyond the bounds; Stopped;
    ChildFailed; ChildDied.
    """
    task = pickle.dumps((bounds, work, arguments))
    stop = stop or Stop()
    if stop.requested:
        raise Stopped
    child = _children.take()
    may_do_more = False
    try:
        with stop.ending_by(child.kill):
            end = _end(child, task, bounds, on_progress)
            may_do_more = end.may_do_more
    except ChildDied:
        if stop.requested:
            raise Stopped from None
        raise
    finally:
        _children.give_back(child, may_do_more and not stop.requested)
    if end.kind == "refused":
        raise end.value
    if end.kind == "failed":
        raise ChildFailed(end.value)
    done: T = end.value
    return done


def _end(child: _Child, task: bytes, bounds: Bounds, on_progress: OnProgress | None) -> Message:
    """The last message of the work; raises ChildDied without one, TooDemanding when it's late."""
    try:
        child.line.send_bytes(task)
        if not child.line.poll(_START_S):
            raise ChildDied(f"it didn't begin within {_START_S:g} s")
        while True:
            _wait_for_word(child)
            message: Message = pickle.loads(child.line.recv_bytes())  # noqa: S301 (our child's)
            if message.kind in ("done", "refused", "failed"):
                return message
            if message.kind == "progress" and on_progress is not None:
                on_progress(message.value)
    except (EOFError, OSError):  # nothing comes any more, or not the rest of a message
        exit_code = child.exit_code()
    if exit_code == -OVERTIME:
        raise TooDemanding(
            f"this took more than the {bounds.deadline_s:g} s of a processor that a request may "
            "take; ask for less at a time"
        )
    raise ChildDied(f"exit code {exit_code}")


def _wait_for_word(child: _Child) -> None:
    """As long as it works; raises ChildDied where it hangs."""
    used_s = child.processor_s()
    while not child.line.poll(_SILENT_S):
        before_s, used_s = used_s, child.processor_s()
        if used_s - before_s < _STILL_S:
            raise ChildDied(f"it said and did nothing for {_SILENT_S:g} s")


@dataclass(frozen=True, kw_only=True)
class Task:
    """Work for a child: `work(*arguments)` within bounds; all of it goes through pickle."""

    job_id: str
    bounds: Bounds
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = field(repr=False)


class RunTask(Protocol):
    """Does a task in a worker process, here or elsewhere, while the caller waits.

    Ends as `run_in_worker` does: with the work's result, a Refusal, Stopped, ChildFailed or
    ChildDied.  Any other error is taken for a loss of the machine that was at it, and the task is
    given to another.  `stop` ends it wherever it runs, `on_progress` is called in any thread.
    """

    def __call__(self, task: Task, stop: Stop, on_progress: OnProgress | None = None) -> Any: ...  # noqa: ANN401 (the work's)


def run_here(task: Task, stop: Stop, on_progress: OnProgress | None = None) -> Any:  # noqa: ANN401 (the work's)
    return run_in_worker(
        task.bounds, task.work, *task.arguments, stop=stop, on_progress=on_progress
    )
