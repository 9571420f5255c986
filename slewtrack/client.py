"""A running service from Python: what is asked of it, one method each, waiting or awaited.

    with slewtrack.Client("http://127.0.0.1:8000") as client:
        plan = client.plan(request, progress=print)
        print(plan.passed, plan.table["alpha_deg"])

Requests are the JSON that the service takes, as bytes or as the dictionary it holds.  What is
refused raises `slewtrack.Refused`, whose `problem` names the field, the reason and the way out.
"""

import time
from collections.abc import Sequence
from typing import Self, TypeVar

import httpx

from slewtrack import calls
from slewtrack.answers import Campaign, Columns, Job, Members, Opportunities, Plan
from slewtrack.calls import CAMPAIGNS, PLANS, SPACECRAFT, Ask, Call, Json, Reply
from slewtrack.connection import PATIENCE_S, Service, reply_of, request_of
from slewtrack.events import OnProgress

T = TypeVar("T")


class Client:
    """A service, asked and waited for; close it, or use it in `with`.

    url: default: the environment's SLEWTRACK_URL, else this machine's port 8000.
    key: an API key, default: SLEWTRACK_KEY; none is needed on loopback.
    patience_s: for how long a service that is busy or can't be reached is asked again.
    progress: of what takes long, called with a `Progress` at each step.
    timeout_s: how long to wait, then `NotFinished`; the work goes on.
    """

    def __init__(
        self,
        url: str | None = None,
        key: str | None = None,
        *,
        patience_s: float = PATIENCE_S,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        self._service = Service(url, key, patience_s=patience_s)
        self._http = httpx.Client(transport=transport, **self._service.options)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End its connections."""
        self._http.close()

    def plan(
        self,
        request: Json,
        *,
        revises: str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """Slews and tracks for every session, as a verified command table; it is kept."""
        return self._run(
            calls.plan(PLANS, request, revises, progress, timeout_s, self._service.patience_s)
        )

    def plan_imaging(
        self,
        request: Json,
        *,
        revises: str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """An imaging session of the spacecraft; its plans are kept apart from the platform's."""
        return self._run(
            calls.plan(SPACECRAFT, request, revises, progress, timeout_s, self._service.patience_s)
        )

    def check(self, request: Json) -> Members:
        """Whether a request for a plan flies, and what to know before; nothing is kept."""
        return self._run(calls.check(PLANS, request, self._service.patience_s))

    def submit(self, request: Json, *, revises: str | None = None) -> Job:
        """A plan to be made; `wait` for it."""
        return self._run(calls.submit(PLANS, request, revises, self._service.patience_s))

    def wait(
        self,
        plan_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """The plan once it is made."""
        return self._run(
            calls.wait_for_plan(PLANS, plan_id, progress, timeout_s, self._service.patience_s)
        )

    def get(self, plan_id: str) -> Plan:
        """A plan that is made."""
        return self._run(calls.plan_at(PLANS, plan_id, self._service.patience_s))

    def plans(self, *, limit: int = 50, **filters: str | None) -> list[Job]:
        """Those there are, the latest first; filters as `GET /v1/plans` has them."""
        return self._run(calls.jobs(PLANS, limit, filters, self._service.patience_s))

    def table(self, plan_id: str) -> Columns:
        """The command table of a plan."""
        return self._run(calls.table(PLANS, plan_id, self._service.patience_s))

    def export(self, plan_id: str, format_name: str) -> bytes:
        """The table as a file: csv, netcdf, aem, czml, geojson, kml, png and more."""
        return self._run(calls.export(PLANS, plan_id, format_name, self._service.patience_s))

    def view(self, plan_id: str, *, step_s: float | None = None) -> Columns:
        """What there is to see along a plan: `carrier.latitude_deg`, `targets.0.azimuth_deg`."""
        return self._run(calls.view(PLANS, plan_id, step_s, self._service.patience_s))

    def delete(self, plan_id: str) -> None:
        """Cancel it, or delete it when it is finished."""
        self._run(calls.delete(PLANS, plan_id, self._service.patience_s))

    def opportunities(self, request: Json) -> Opportunities:
        """When each target can be seen."""
        return self._run(calls.opportunities(request, self._service.patience_s))

    def campaign(
        self,
        request: Json,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Campaign:
        """Many targets over days: chosen, ordered and planned pass by pass."""
        return self._run(calls.campaign(request, progress, timeout_s, self._service.patience_s))

    def wait_for_campaign(
        self,
        campaign_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Campaign:
        """One that was posted before."""
        return self._run(
            calls.wait_for_campaign(campaign_id, progress, timeout_s, self._service.patience_s)
        )

    def campaigns(self, *, limit: int = 50, **filters: str | None) -> list[Job]:
        """Those there are, the latest first."""
        return self._run(calls.jobs(CAMPAIGNS, limit, filters, self._service.patience_s))

    def estimate_vertical(self, images: Sequence[bytes], request: Json) -> Members:
        """The nadir in body axes from one image file per camera."""
        return self._run(calls.estimate_vertical(images, request, self._service.patience_s))

    def platforms(self) -> Sequence[Members]:
        """Those that a request can name, each as it may write out its own."""
        return self._run(calls.platforms(self._service.patience_s))

    def _run(self, call: Call[T]) -> T:
        try:
            ask = next(call)
            while True:
                try:
                    reply = self._answer(ask)
                except httpx.TransportError as error:
                    ask = call.throw(self._service.lost(error))
                except Exception as error:  # noqa: BLE001 (the call decides what it means)
                    ask = call.throw(error)
                else:
                    ask = call.send(reply)
        except StopIteration as done:
            result: T = done.value
            return result

    def _answer(self, ask: Ask) -> Reply:
        time.sleep(ask.after_s)
        with self._http.stream(**request_of(ask)) as answer:
            if ask.on_line is None or answer.status_code >= 400:
                return reply_of(answer, answer.read())
            for line in answer.iter_lines():
                ask.on_line(line)
            return reply_of(answer, b"")
