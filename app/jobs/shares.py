"""A job's work that begins with shares, which several processes do at a time."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from threading import Lock, Semaphore
from typing import Any

from app.jobs.worker_process import ChildDied, RunTask, Stop, Task
from app.log.logs import log
from app.work.progress import OnProgress, Progress

_POLL_S = 0.25  # for a place that somebody left; whoever waits for one longer takes it sooner


@dataclass(frozen=True, kw_only=True)
class Shares:
    """What is done before the work itself, which is handed what comes of it.

    Each is a task of its own within the bounds of the whole: it follows from what it is given
    alone, so that one whose process died is done again, and the answer doesn't hang on how many
    there are at a time.

    may_be: whether a request, by its bytes, could have any.  split: in a child, of the arguments
    of the work and what was made before; none where there is no more to do so.  work: in a child,
    of one of them.
    stage: as it is reported.
    """

    may_be: Callable[[bytes], bool]
    split: Callable[..., Sequence[bytes]]
    work: Callable[[bytes], bytes]
    stage: str


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where shares may be done beside the place that the whole has: as many as `take` gives."""

    take: Callable[[], bool]
    leave: Callable[[], None]
    most: int


@dataclass(frozen=True, kw_only=True)
class Sharing:
    """Does tasks and their shares; attempts: at a share whose process dies."""

    run_task: RunTask
    places: Places
    attempts: int

    def run(
        self, shares: Shares, task: Task, stop: Stop, on_progress: OnProgress | None = None
    ) -> Any:  # noqa: ANN401 (the work's)
        """As a RunTask does."""
        if not shares.may_be(task.arguments[0]):
            return self.run_task(task, stop, on_progress)
        with_made = replace(task, arguments=(*task.arguments, []))
        while given := self._made(replace(with_made, work=shares.split), stop):
            made = self.make(shares, given, task, stop, on_progress)
            with_made = replace(task, arguments=(*task.arguments, made))
        return self.run_task(with_made, stop, on_progress)

    def make(
        self,
        shares: Shares,
        given: Sequence[bytes],
        task: Task,
        stop: Stop,
        on_progress: OnProgress | None = None,
    ) -> list[bytes]:
        """What comes of each share of a task, in order; ends as a RunTask does."""
        own_place, telling, made_yet = Semaphore(), Lock(), [0]
        stops = [Stop() for _ in given]

        def make(one: bytes, own_stop: Stop) -> bytes:
            share = replace(task, work=shares.work, arguments=(one,))
            with self._place(own_place):
                made: bytes = self._made(share, own_stop)
            with telling:
                made_yet[0] += 1
                tell(made_yet[0])
            return made

        def tell(count: int) -> None:
            if on_progress is not None:
                on_progress(Progress(stage=shares.stage, done=count, of=len(given)))

        def end_all() -> None:
            for one in stops:
                one.request()

        tell(0)
        with stop.ending_by(end_all), ThreadPoolExecutor(self.places.most + 1) as threads:
            try:
                return [*threads.map(make, given, stops)]
            finally:
                end_all()

    def _made(self, share: Task, stop: Stop) -> Any:  # noqa: ANN401 (the share's)
        for _ in range(1, self.attempts):
            try:
                made = self.run_task(share, stop)
            except ChildDied as error:
                log.warning("a child was lost", job=share.job_id, error=error)
            else:
                return made
        return self.run_task(share, stop)

    @contextmanager
    def _place(self, own: Semaphore) -> Iterator[None]:
        """That of the whole, or one more."""
        while not (is_own := own.acquire(blocking=False)) and not self.places.take():
            time.sleep(_POLL_S)
        try:
            yield
        finally:
            if is_own:
                own.release()
            else:
                self.places.leave()
