"""How is the progress of a job told as server-sent events?

Source: HTML Living Standard, section 9.2.
"""

import json
import time
from collections.abc import AsyncIterator

import anyio
import anyio.to_thread
from fastapi import Request
from fastapi.sse import format_sse_event

from app.store import events, jobs
from app.store.database import Database
from app.store.events import Event
from planner.frames.time_scales import utc_text

EVENT_STREAM = "text/event-stream"
EVENT_EXAMPLE = (
    'id: 2\nevent: state\ndata: {"at": "2015-02-27T12:00:00.000Z", "state": "running"}\n\n'
)
_LOOK_S = 0.25
_SILENCE_S = 15.0  # proxies cut connections nothing comes over


async def told(request: Request, job_id: str, seq: int) -> AsyncIterator[bytes]:
    """Events after the seq-th, until the job has ended."""
    database: Database = request.app.state.database
    said_s = time.monotonic()
    while True:
        found, is_open = await anyio.to_thread.run_sync(_after, database, job_id, seq)
        for event in found:
            seq, said_s = event.seq, time.monotonic()
            yield _text(event)
        if not is_open:
            return
        if time.monotonic() - said_s > _SILENCE_S:
            said_s = time.monotonic()
            yield format_sse_event(comment="still at it")
        await anyio.sleep(_LOOK_S)


def last_seq(database: Database, job_id: str) -> int:
    """Of what has happened until now."""
    found, _ = _after(database, job_id, 0)
    return found[-1].seq if found else 0


def _after(database: Database, job_id: str, seq: int) -> tuple[list[Event], bool]:
    with database.reading() as connection:
        job = jobs.get(connection, job_id)
        return events.after(connection, job_id, seq), job is not None and job.is_open


def _text(event: Event) -> bytes:
    data = {"at": utc_text(event.at_utc), **event.data}
    return format_sse_event(data_str=json.dumps(data), event=event.kind, id=str(event.seq))
