"""Work that would hold up other requests: database reads in a thread, a route's work in a child."""

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from typing import Any, TypeVar

import anyio.to_thread
from anyio import CapacityLimiter
from fastapi import Request, Response
from sqlalchemy import Connection
from starlette.requests import ClientDisconnect

from app.answers.members import ProvenanceOut, provenance
from app.http.negotiation import JSON
from app.http.problems import service_stops
from app.jobs.child import Bounds
from app.jobs.worker_process import Stop, Stopped, Task, run_in_worker
from app.store.database import Database

T = TypeVar("T")

# Enough for many times a pass; the longest table there is covers a day.
EXPORT_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)


def database_of(request: Request) -> Database:
    database: Database = request.app.state.database
    return database


async def read(request: Request, reading: Callable[[Connection], T]) -> T:
    """What `reading` returns in one transaction, in a thread."""
    database = database_of(request)

    def in_transaction() -> T:
        with database.reading() as connection:
            return reading(connection)

    return await database.answer(in_transaction)


async def answer_in_child(
    request: Request,
    body: bytes,
    read_request: Callable[[bytes], T],
    bounds: Bounds,
    work: Callable[[T, ProvenanceOut], bytes],
) -> Response:
    """The JSON that `work` makes of the request in a body and its provenance; see `in_child`."""
    now_utc = datetime.now(UTC)
    spec = await anyio.to_thread.run_sync(read_request, body)
    answer = await in_child(request, bounds, work, spec, provenance(now_utc, body))
    return Response(answer, media_type=JSON)


async def in_child(
    request: Request, bounds: Bounds, work: Callable[..., T], *arguments: object
) -> T:
    """`run_in_worker` when its turn has come; stopped when the client or the service goes away.

    Raises ClientDisconnect or 503 then, and else what `run_in_worker` does.  The request's body
    must have been read.
    """
    run = partial(run_in_worker, bounds, work, *arguments)
    return await _wait(request, run, request.app.state.children)


async def where_solved(request: Request, task: Task) -> Any:  # noqa: ANN401 (the work's)
    """As `in_child`, by a worker of the cluster where there is one; again, if that is lost."""
    run = partial(request.app.state.dispatcher.run_task, task)
    return await _wait(request, run, request.app.state.solves)


async def _wait(request: Request, run: Callable[..., T], limiter: CapacityLimiter) -> T:
    stop = Stop()
    stopping: asyncio.Event = request.app.state.stopping
    watches = [asyncio.create_task(one) for one in (_disconnected(request), stopping.wait())]
    for watch in watches:
        watch.add_done_callback(lambda done: None if done.cancelled() else stop.request())
    try:
        return await anyio.to_thread.run_sync(lambda: run(stop=stop), limiter=limiter)
    except Stopped:
        raise (service_stops() if stopping.is_set() else ClientDisconnect()) from None
    finally:
        for watch in watches:
            watch.cancel()


async def _disconnected(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
