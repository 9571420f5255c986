"""The time that a client will wait for a plan, and the wait itself.

Source: RFC 7240 (Prefer).
"""

import asyncio
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fastapi import Request

from app.http.blocking import read
from app.jobs.dispatcher import Dispatcher
from app.store import jobs
from app.store.plans import StoredPlan

WAIT_S, WAIT_MAX_S = 30, 60
_LOOK_S = 1.0  # between looks at a job that another service may work on
_WAIT = re.compile(r"wait\s*=\s*\"?(\d{1,6})\"?")


@dataclass(frozen=True, kw_only=True)
class Patience:
    """How long to wait, and the headers that tell which wish of the client's was followed."""

    wait_s: float
    headers: Mapping[str, str] = field(default_factory=dict)

    @property
    def answers_at_once(self) -> bool:
        """Whether the answer is 202 wherever the work is by then."""
        return self.wait_s == 0


def patience(prefer: str | None, default_s: float) -> Patience:
    """Of a Prefer header; what isn't understood in it is ignored, as the RFC asks."""
    wishes = [wish.split(";")[0].strip().lower() for wish in (prefer or "").split(",")]
    if "respond-async" in wishes:
        return Patience(wait_s=0, headers={"Preference-Applied": "respond-async"})
    for wish in wishes:
        if found := _WAIT.fullmatch(wish):
            seconds = min(int(found[1]), WAIT_MAX_S)
            return Patience(wait_s=seconds, headers={"Preference-Applied": f"wait={seconds}"})
    return Patience(wait_s=default_s)


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
                if ended.done() and (settled := ended.result()) is not None:
                    return settled.plan
        return None
    finally:
        stops.cancel()
