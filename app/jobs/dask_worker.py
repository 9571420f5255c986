"""A task on a machine of the cluster: a child process each, as in the service."""

import asyncio
import contextlib
import signal
from dataclasses import asdict
from typing import Any

from distributed import Worker, get_worker
from distributed.comm.addressing import get_local_address_for

from app.jobs.executors import Task, run_here
from app.jobs.worker_process import (
    ChildDied,
    ChildFailed,
    Stop,
    Stopped,
    spare_children,
    start_server,
)
from app.log.logs import log
from app.versions import VERSION
from app.work.progress import Progress
from planner.base.errors import Refusal

PROGRESS_TOPIC = "slewtrack-progress"
# A worker of another version never gets a task: its plans would say the wrong version.
SLOT = f"slewtrack-{VERSION}"

_PAUSE_S = 1.0

Outcome = tuple[bool, Any]
_stops: dict[str, Stop] = {}


def run_on_worker(key: str, task: Task) -> Outcome:
    """(True, result), or (False, what the work raised), which Dask needn't know about."""
    worker = get_worker()

    def tell(progress: Progress) -> None:
        worker.log_event(PROGRESS_TOPIC, {"key": key, "progress": asdict(progress)})

    try:
        result = run_here(task, _stops.setdefault(key, Stop()), tell)
    except (Refusal, Stopped, ChildFailed, ChildDied) as error:
        return False, error
    finally:
        _stops.pop(key, None)
    return True, result


def stop_here(key: str) -> bool:
    """End the task if it runs on this worker, and say so; called on all of them."""
    stop = _stops.get(key)
    if stop is None:
        return False
    stop.request()
    return True


def work_for(scheduler: str, solves: int) -> None:
    """Do tasks of the scheduler at this address, so many at a time, until told to end."""
    # what tasks refer to: seconds in which it wouldn't answer
    import app.jobs.kinds
    import app.work.searches  # noqa: F401

    start_server()
    with spare_children(solves):
        asyncio.run(_work_for(scheduler, solves))


async def _work_for(scheduler: str, solves: int) -> None:
    working = asyncio.create_task(_work_whenever_connected(scheduler, solves))
    for number in (signal.SIGTERM, signal.SIGINT):  # also while it waits for the scheduler
        asyncio.get_running_loop().add_signal_handler(number, working.cancel)
    with contextlib.suppress(asyncio.CancelledError):
        await working


async def _work_whenever_connected(scheduler: str, solves: int) -> None:
    while True:
        try:
            await _work_until_disconnected(scheduler, solves)
        except (OSError, TimeoutError) as error:
            log.warning("the scheduler doesn't answer", scheduler=scheduler, error=error)
            await asyncio.sleep(_PAUSE_S)


class _Worker(Worker):
    """Ends with what it is at: the scheduler has it done elsewhere once this one has left."""

    async def close(self, *positional: Any, **named: Any) -> Any:  # noqa: ANN401 (Dask's)
        closed = await super().close(*positional, **named | {"executor_wait": False})
        for stop in list(_stops.values()):
            stop.request()
        return closed


async def _work_until_disconnected(scheduler: str, solves: int) -> None:
    worker = _Worker(
        scheduler,
        nthreads=solves,
        resources={SLOT: solves},
        memory_limit=0,  # each child has its own
        host=get_local_address_for(scheduler),  # only on the cluster's network
        dashboard=False,
        dashboard_address="127.0.0.1:0",  # its metrics are plain HTTP for all, even with TLS
    )
    async with worker:
        log.info("at work", scheduler=scheduler, solves=solves, version=VERSION)
        await worker.finished()
