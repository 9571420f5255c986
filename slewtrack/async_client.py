"""A running service from Python, awaited: `Client` with `async` and `await`.

async with slewtrack.AsyncClient() as client:
    plans = await asyncio.gather(*(client.plan(request) for request in requests))
"""

from collections.abc import Sequence
from typing import Self, TypeVar

import anyio
import httpx

from slewtrack import calls
from slewtrack.answers import Campaign, Columns, Job, Members, Opportunities, Plan
from slewtrack.calls import CAMPAIGNS, PLANS, SPACECRAFT, Ask, Call, Json, Reply
from slewtrack.connection import PATIENCE_S, Service, reply_of, request_of
from slewtrack.events import OnProgress

T = TypeVar("T")


class AsyncClient:
    """A service, asked and awaited; the same as `Client` otherwise."""

    def __init__(
        self,
        url: str | None = None,
        key: str | None = None,
        *,
        patience_s: float = PATIENCE_S,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self._service = Service(url, key, patience_s=patience_s)
        self._http = httpx.AsyncClient(transport=transport, **self._service.options)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """End its connections."""
        await self._http.aclose()

    async def plan(
        self,
        request: Json,
        *,
        revises: str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """Slews and tracks for every session, as a verified command table; it is kept."""
        return await self._run(
            calls.plan(PLANS, request, revises, progress, timeout_s, self._service.patience_s)
        )

    async def plan_imaging(
        self,
        request: Json,
        *,
        revises: str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """An imaging session of the spacecraft; its plans are kept apart from the platform's."""
        return await self._run(
            calls.plan(SPACECRAFT, request, revises, progress, timeout_s, self._service.patience_s)
        )

    async def check(self, request: Json) -> Members:
        """Whether a request for a plan flies, and what to know before; nothing is kept."""
        return await self._run(calls.check(PLANS, request, self._service.patience_s))

    async def submit(self, request: Json, *, revises: str | None = None) -> Job:
        """A plan to be made; `wait` for it."""
        return await self._run(calls.submit(PLANS, request, revises, self._service.patience_s))

    async def wait(
        self,
        plan_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """The plan once it is made."""
        return await self._run(
            calls.wait_for_plan(PLANS, plan_id, progress, timeout_s, self._service.patience_s)
        )

    async def get(self, plan_id: str) -> Plan:
        """A plan that is made."""
        return await self._run(calls.plan_at(PLANS, plan_id, self._service.patience_s))

    async def plans(self, *, limit: int = 50, **filters: str | None) -> list[Job]:
        """Those there are, the latest first; filters as `GET /v1/plans` has them."""
        return await self._run(calls.jobs(PLANS, limit, filters, self._service.patience_s))

    async def table(self, plan_id: str) -> Columns:
        """The command table of a plan."""
        return await self._run(calls.table(PLANS, plan_id, self._service.patience_s))

    async def export(self, plan_id: str, format_name: str) -> bytes:
        """The table as a file: csv, netcdf, aem, czml, geojson, kml, png and more."""
        return await self._run(calls.export(PLANS, plan_id, format_name, self._service.patience_s))

    async def view(self, plan_id: str, *, step_s: float | None = None) -> Columns:
        """What there is to see along a plan: `carrier.latitude_deg`, `targets.0.azimuth_deg`."""
        return await self._run(calls.view(PLANS, plan_id, step_s, self._service.patience_s))

    async def delete(self, plan_id: str) -> None:
        """Cancel it, or delete it when it is finished."""
        await self._run(calls.delete(PLANS, plan_id, self._service.patience_s))

    async def opportunities(self, request: Json) -> Opportunities:
        """When each target can be seen."""
        return await self._run(calls.opportunities(request, self._service.patience_s))

    async def campaign(
        self,
        request: Json,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Campaign:
        """Many targets over days: chosen, ordered and planned pass by pass."""
        return await self._run(
            calls.campaign(request, progress, timeout_s, self._service.patience_s)
        )

    async def wait_for_campaign(
        self,
        campaign_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Campaign:
        """One that was posted before."""
        return await self._run(
            calls.wait_for_campaign(campaign_id, progress, timeout_s, self._service.patience_s)
        )

    async def campaigns(self, *, limit: int = 50, **filters: str | None) -> list[Job]:
        """Those there are, the latest first."""
        return await self._run(calls.jobs(CAMPAIGNS, limit, filters, self._service.patience_s))

    async def estimate_vertical(self, images: Sequence[bytes], request: Json) -> Members:
        """The nadir in body axes from one image file per camera."""
        return await self._run(calls.estimate_vertical(images, request, self._service.patience_s))

    async def platforms(self) -> Sequence[Members]:
        """Those that a request can name, each as it may write out its own."""
        return await self._run(calls.platforms(self._service.patience_s))

    async def _run(self, call: Call[T]) -> T:
        try:
            ask = next(call)
            while True:
                try:
                    reply = await self._answer(ask)
                except httpx.TransportError as error:
                    ask = call.throw(self._service.lost(error))
                except Exception as error:  # noqa: BLE001 (the call decides what it means)
                    ask = call.throw(error)
                else:
                    ask = call.send(reply)
        except StopIteration as done:
            result: T = done.value
            return result

    async def _answer(self, ask: Ask) -> Reply:
        await anyio.sleep(ask.after_s)
        async with self._http.stream(**request_of(ask)) as answer:
            if ask.on_line is None or answer.status_code >= 400:
                return reply_of(answer, await answer.aread())
            async for line in answer.aiter_lines():
                ask.on_line(line)
            return reply_of(answer, b"")
