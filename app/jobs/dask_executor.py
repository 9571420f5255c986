"""Work on other machines, by workers of a dask.distributed scheduler.

Imported only where SLEWTRACK_DASK_SCHEDULER is set, and by such a worker, whose tasks have a child
process each, as in the service.  What Dask loses, a worker, its scheduler
or the connection, is begun again; a result counts once, for the lease it was made under.
"""

import asyncio
import contextlib
import os
import secrets
import signal
import threading
import time
from concurrent.futures import CancelledError
from contextlib import ExitStack
from dataclasses import asdict
from typing import Any

from anyio.from_thread import start_blocking_portal
from distributed import Client, Worker, get_worker
from distributed import Future as DaskFuture
from distributed.client import ClosedClientError
from distributed.comm.addressing import get_local_address_for
from distributed.comm.core import CommClosedError
from tornado.ioloop import IOLoop

from app.jobs.worker_process import (
    ChildDied,
    ChildFailed,
    Stop,
    Stopped,
    Task,
    run_here,
    spare_children,
    start_server,
)
from app.log.logs import log
from app.versions import VERSION
from app.work.cluster_prices import CONNECT_S, SLOT, WORKER_OF
from app.work.progress import OnProgress, Progress
from planner.base.errors import Refusal

_PAUSE_S = 1.0
_STOP_TRIES = 3
_LOST = (CancelledError, ClosedClientError, CommClosedError, TimeoutError, OSError)

PROGRESS_TOPIC = "slewtrack-progress"

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

    os.environ[WORKER_OF] = scheduler
    start_server()
    with spare_children(solves):
        asyncio.run(_work_for(scheduler, solves))


async def _work_for(scheduler: str, solves: int) -> None:
    async def work() -> None:
        while True:
            try:
                await _work_until_disconnected(scheduler, solves)
            except (OSError, TimeoutError) as error:
                log.warning("the scheduler doesn't answer", scheduler=scheduler, error=error)
                await asyncio.sleep(_PAUSE_S)

    working = asyncio.create_task(work())
    for number in (signal.SIGTERM, signal.SIGINT):  # also while it waits for the scheduler
        asyncio.get_running_loop().add_signal_handler(number, working.cancel)
    with contextlib.suppress(asyncio.CancelledError):
        await working


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
        nthreads=solves + 1,  # which is free for prices, however many children are waited for
        resources={SLOT: solves},
        memory_limit=0,  # each child has its own
        host=get_local_address_for(scheduler),  # only on the cluster's network
        dashboard=False,
        dashboard_address="127.0.0.1:0",  # its metrics are plain HTTP for all, even with TLS
    )
    async with worker:
        log.info("at work", scheduler=scheduler, solves=solves, version=VERSION)
        await worker.finished()


class DaskExecutor:
    """Hands tasks to the cluster."""

    def __init__(self, scheduler: str) -> None:
        self._scheduler = scheduler
        self._lock = threading.Lock()
        self._client: Client | None = None
        # A client that finds no scheduler would leave the event loop it began.
        self._loop_kept = ExitStack()
        self._loop = self._loop_kept.enter_context(start_blocking_portal()).call(IOLoop.current)
        self._listeners: dict[str, OnProgress] = {}

    def close(self) -> None:
        """All tasks have ended."""
        with self._loop_kept:
            self._disconnect()

    def run(self, task: Task, stop: Stop, on_progress: OnProgress | None = None) -> Any:  # noqa: ANN401 (the work's)
        """As a RunTask does; without a scheduler it waits for one."""
        key = f"slewtrack-{task.job_id}-{secrets.token_hex(4)}"
        if on_progress is not None:
            self._listeners[key] = on_progress
        wake = threading.Event()
        try:
            with stop.ending_by(wake.set):
                while not stop.requested:
                    try:
                        return self._result_of(key, task, stop, wake)
                    except _LOST as error:
                        log.warning("the cluster was lost", job=task.job_id, error=error)
                        wake.clear()
                        wake.wait(_PAUSE_S)
                raise Stopped
        finally:
            self._listeners.pop(key, None)

    def _result_of(self, key: str, task: Task, stop: Stop, wake: threading.Event) -> Any:  # noqa: ANN401 (the work's)
        client = self._connect()
        future = client.submit(run_on_worker, key, task, key=key, resources={SLOT: 1}, pure=False)
        future.add_done_callback(lambda _: wake.set())
        wake.wait()
        if stop.requested:
            self._stop(client, future, key)
            raise Stopped
        wake.clear()
        succeeded, value = future.result()
        if not succeeded:
            raise value
        return value

    def _stop(self, client: Client, future: DaskFuture[Any], key: str) -> None:
        """A task that waits is forgotten; the child of one that runs is killed."""
        try:
            future.cancel()
            for _ in range(_STOP_TRIES):  # it may just be beginning
                if client.status != "running" or any(
                    client.run(stop_here, key, on_error="ignore").values()
                ):
                    return
                time.sleep(0.1)
        except _LOST as error:
            log.warning("the cluster was lost", error=error)

    def _connect(self) -> Client:
        """A client of the scheduler, a new one where the last has lost it; raises TimeoutError."""
        with self._lock:
            if self._client is None or self._client.status != "running":
                self._disconnect()
                self._client = Client(
                    self._scheduler,
                    timeout=CONNECT_S,
                    set_as_default=False,
                    name="slewtrack",
                    loop=self._loop,
                )
                self._client.subscribe_topic(PROGRESS_TOPIC, self._pass_progress_on)
                workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
                if not any(SLOT in worker["resources"] for worker in workers):
                    log.warning(
                        "no worker of this version is connected; work waits for one", slot=SLOT
                    )
            return self._client

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def _pass_progress_on(self, event: tuple[object, dict[str, Any]]) -> None:
        _, content = event
        listener = self._listeners.get(content["key"])
        if listener is not None:
            listener(Progress(**content["progress"]))
