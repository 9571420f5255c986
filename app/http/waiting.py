"""The wait for a plan, by a client's own patience, and a job's progress as server-sent events.

Source: RFC 7240 (Prefer); HTML Living Standard, section 9.2.
"""

import asyncio
import json
import re
import time
from collections.abc import AsyncIterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import anyio
from fastapi import Request
from fastapi.sse import format_sse_event
from sqlalchemy import Connection

from app.http.blocking import read
from app.jobs.dispatcher import Dispatcher
from app.jobs.kinds import JOB_KINDS
from app.store import events, jobs
from app.store.events import Event
from app.store.job import Job
from app.store.plans import StoredPlan
from app.store.unavailable import StoreDamaged, StoreUnavailable
from planner.world.frames.time_scales import utc_text

WAIT_S, WAIT_MAX_S = 30, 60
_LOOK_S = 1.0  # between looks at a job that another service may work on
_LOOK_FOR_EVENTS_S = 0.25
_SILENCE_S = 15.0  # proxies cut connections nothing comes over
_RETRY_MS = 2000  # before a browser asks again where a connection broke
_WAIT = re.compile(r"wait\s*=\s*\"?(\d{1,6})\"?")


class Patience(NamedTuple):
    """How long to wait, and the headers that tell which wish of the client's was followed."""

    wait_s: float
    headers: Mapping[str, str] = MappingProxyType({})


def patience(prefer: str | None, default_s: float) -> Patience:
    """Of a Prefer header; what isn't understood in it is ignored, as the RFC asks."""
    wishes = [wish.split(";")[0].strip().lower() for wish in (prefer or "").split(",")]
    if "respond-async" in wishes:
        return Patience(0.0, {"Preference-Applied": "respond-async"})
    for wish in wishes:
        if found := _WAIT.fullmatch(wish):
            seconds = min(int(found[1]), WAIT_MAX_S)
            return Patience(seconds, {"Preference-Applied": f"wait={seconds}"})
    return Patience(default_s)


async def wait_for_end(request: Request, job_id: str, wait_s: float) -> StoredPlan | None:
    """Until a job has ended, here or with another service on the database, or time is up.

    Or this service is told to stop: the job is kept.  The plan where it was made here meanwhile;
    else the database knows more.
    """
    dispatcher: Dispatcher = request.app.state.dispatcher
    clock_s = asyncio.get_running_loop().time
    until_s = clock_s() + wait_s
    stops = asyncio.create_task(request.app.state.stopping.wait())
    try:
        while (left_s := until_s - clock_s()) > 0.0 and not stops.done():
            with dispatcher.watching(job_id) as (ended, is_here):
                if not is_here:
                    job = await read(request, lambda connection: jobs.get(connection, job_id))
                    if job is None or not job.is_open:
                        return None
                    left_s = min(left_s, _LOOK_S)
                waits: list[asyncio.Future[Any]] = [asyncio.wrap_future(ended), stops]
                await asyncio.wait(waits, timeout=left_s, return_when=asyncio.FIRST_COMPLETED)
                if ended.done() and (job := ended.result()) is not None:
                    return job if isinstance(job, StoredPlan) else None
        return None
    finally:
        stops.cancel()


async def stream_events(request: Request, job_id: str, seq: int) -> AsyncIterator[bytes]:
    """Events after the seq-th, until the job has ended or the service is told to stop."""
    stopping: asyncio.Event = request.app.state.stopping
    last_s = time.monotonic()
    retry_ms: int | None = _RETRY_MS  # told once
    while True:
        is_open = True
        try:
            found, job = await _after(request, job_id, seq)
        except StoreDamaged:
            return
        except StoreUnavailable:
            pass  # the stream has begun: it goes on when that is back
        else:
            is_open = job is not None and job.is_open
            for event in found:
                seq, last_s = event.seq, time.monotonic()
                yield _text(event, job, retry_ms)
                retry_ms = None
        if not is_open or stopping.is_set():
            return
        if time.monotonic() - last_s > _SILENCE_S:
            last_s = time.monotonic()
            yield format_sse_event(comment="still at it")
        with anyio.move_on_after(_LOOK_FOR_EVENTS_S):
            await stopping.wait()


async def last_seq(request: Request, job_id: str) -> int:
    found, _ = await _after(request, job_id, 0)
    return found[-1].seq if found else 0


async def _after(request: Request, job_id: str, seq: int) -> tuple[list[Event], Job | None]:
    def reading(connection: Connection) -> tuple[list[Event], Job | None]:
        job = jobs.get(connection, job_id)
        return events.after(connection, job_id, seq), job

    return await read(request, reading)


def _text(event: Event, job: Job | None, retry_ms: int | None) -> bytes:
    data = {"at": utc_text(event.at_utc), **event.data}
    if event.kind == events.PROGRESS and job is not None:
        told = {name: event.data[name] for name in ("stage", "done", "of") if name in event.data}
        data["percent"] = JOB_KINDS[job.kind].percent(**told)
    return format_sse_event(
        data_str=json.dumps(data), event=event.kind, id=str(event.seq), retry=retry_ms
    )
