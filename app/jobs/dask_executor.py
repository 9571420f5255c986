"""Work on other machines, by workers of a dask.distributed scheduler.

Imported only where SLEWTRACK_DASK_SCHEDULER is set.  What Dask loses, a worker, its scheduler
or the connection, is begun again; a result counts once, for the lease it was made under.
"""

import secrets
import threading
import time
from concurrent.futures import CancelledError
from contextlib import ExitStack
from typing import Any

from anyio.from_thread import start_blocking_portal
from distributed import Client
from distributed import Future as DaskFuture
from distributed.client import ClosedClientError
from distributed.comm.core import CommClosedError
from tornado.ioloop import IOLoop

from app.jobs.dask_worker import PROGRESS_TOPIC, SLOT, run_on_worker, stop_here
from app.jobs.executors import Task
from app.jobs.worker_process import Stop, Stopped
from app.log.logs import log
from app.work.progress import OnProgress, Progress

_CONNECT_S = 5.0
_PAUSE_S = 1.0
_STOP_TRIES = 3
_LOST = (CancelledError, ClosedClientError, CommClosedError, TimeoutError, OSError)


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
                    timeout=_CONNECT_S,
                    set_as_default=False,
                    name="slewtrack",
                    loop=self._loop,
                )
                self._client.subscribe_topic(PROGRESS_TOPIC, self._pass_progress_on)
                self._warn_without_workers(self._client)
            return self._client

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def _warn_without_workers(self, client: Client) -> None:
        workers = client.scheduler_info(n_workers=-1)["workers"].values()
        if not any(SLOT in worker["resources"] for worker in workers):
            log.warning("no worker of this version is connected; work waits for one", slot=SLOT)

    def _pass_progress_on(self, event: tuple[object, dict[str, Any]]) -> None:
        _, content = event
        listener = self._listeners.get(content["key"])
        if listener is not None:
            listener(Progress(**content["progress"]))
