"""What works on jobs while the service runs."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from app.http.metrics import Metrics
from app.jobs.dispatcher import Dispatcher
from app.jobs.disposable import spare_children
from app.jobs.executors import LocalExecutor, SolveExecutor
from app.settings import Settings
from app.store import jobs
from app.store.database import Database
from app.store.ids import JobState


@contextmanager
def dispatching(settings: Settings, database: Database, metrics: Metrics) -> Iterator[Dispatcher]:
    """A dispatcher at work as the settings say; at the end it gives back what isn't done."""

    def on_end(kind: str, state: JobState, took_s: float, iterations: int | None) -> None:
        metrics.solve_s.labels(kind, state).observe(took_s)
        if iterations is not None:
            metrics.iterations.labels(kind).observe(iterations)

    def counts() -> dict[tuple[str, str], int]:
        with database.reading() as connection:
            return jobs.counts(connection)

    metrics.count_jobs_by(counts)
    # With a cluster only what is answered at once is done here.
    here = settings.workers if not settings.dask_scheduler else os.cpu_count() or 1
    with spare_children(here):
        dispatcher = Dispatcher(database, _executor(settings), settings, on_end)
        dispatcher.start()
        try:
            yield dispatcher
        finally:
            dispatcher.close()


def _executor(settings: Settings) -> SolveExecutor:
    if not settings.dask_scheduler:
        return LocalExecutor(settings.workers)
    from app.jobs.dask_executor import DaskExecutor  # half a second that others needn't wait

    return DaskExecutor(settings.dask_scheduler, settings.workers)
