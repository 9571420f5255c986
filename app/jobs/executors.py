"""Executors of work: their interface, and the one on this machine."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Protocol

from app.jobs.child import Bounds
from app.jobs.worker_process import Stop, run_in_worker
from app.work.progress import OnProgress


@dataclass(frozen=True, kw_only=True)
class Task:
    """Work for a child: `work(body, request)` within bounds; all of it goes through pickle.

    body: the request as it was sent.  request: as it was read, None where the child is to read it.
    """

    job_id: str
    bounds: Bounds
    work: Callable[[bytes, Any], Any]
    body: bytes = field(repr=False)
    request: Any = field(default=None, repr=False)


class SolveExecutor(Protocol):
    """Does `workers` tasks at a time, each in a worker process, here or elsewhere.

    The future of a task ends as `run_in_worker` does: with the work's result, a Refusal,
    Stopped, ChildFailed or ChildDied.  Any other error is taken for a loss of the machine that
    was at it, and the task is given to another.
    """

    @property
    def workers(self) -> int: ...

    def submit(self, task: Task, stop: Stop, on_progress: OnProgress) -> Future[Any]:
        """Begin; `stop` ends it wherever it runs, `on_progress` is called in any thread."""
        ...

    def close(self) -> None:
        """All tasks have ended."""
        ...


class LocalExecutor:
    """In children of this machine, a thread waiting for each."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="solve")

    def submit(self, task: Task, stop: Stop, on_progress: OnProgress) -> Future[Any]:
        return self._threads.submit(
            run_in_worker,
            task.bounds,
            task.work,
            task.body,
            task.request,
            stop=stop,
            on_progress=on_progress,
        )

    def close(self) -> None:
        self._threads.shutdown()
