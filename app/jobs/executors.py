"""Tasks, and what does them: this machine, or a cluster."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from app.jobs.child import Bounds
from app.jobs.worker_process import Stop, run_in_worker
from app.work.progress import OnProgress


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
