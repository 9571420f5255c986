"""The progress of a job as server-sent events.

Source: HTML Living Standard, section 9.2.
"""

import asyncio
import json
import time
from collections.abc import AsyncIterator

import anyio
from fastapi import Request
from fastapi.sse import format_sse_event
from sqlalchemy import Connection

from app.http.blocking import read
from app.jobs.kinds import JOB_KINDS
from app.store import events, jobs
from app.store.events import Event
from app.store.job import Job
from app.store.unavailable import StoreDamaged, StoreUnavailable
from planner.world.frames.time_scales import utc_text

_LOOK_S = 0.25
_SILENCE_S = 15.0  # proxies cut connections nothing comes over
_RETRY_MS = 2000  # before a browser asks again where a connection broke


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
        with anyio.move_on_after(_LOOK_S):
            await stopping.wait()


async def last_seq(request: Request, job_id: str) -> int:
    """Of what has happened until now."""
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
