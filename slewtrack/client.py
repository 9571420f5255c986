"""The client of a running service: a method for each request, waiting or awaited.

    with slewtrack.Client("http://127.0.0.1:8000") as client:
        plan = client.plan(request, progress=print)
        print(plan.passed, plan.table["alpha_deg"])

Requests are the JSON that the service takes, as bytes or as the dictionary it holds.  What is
refused raises `slewtrack.Refused`, whose `problem` names the field, the reason and the way out.
"""

import time
from collections.abc import Sequence
from typing import Any, Self, TypeVar, Unpack

import httpx

from slewtrack import calls
from slewtrack.answers import Campaign, Columns, Flights, Job, Members, Opportunities, Plan, Window
from slewtrack.asking import Ask, Call, Intake, Json, Reply
from slewtrack.calls import (
    CAMPAIGNS,
    FLIGHTS,
    PLANS,
    SEARCHES,
    SPACECRAFT_PLANS,
    SPACECRAFT_SEARCHES,
)
from slewtrack.connection import PATIENCE_S, Service, in_time, reply_of, request_of, start_clock
from slewtrack.events import OnProgress
from slewtrack.filters import Filters

T = TypeVar("T")


class Carrier:
    """Plans and opportunities of one carrier of an instrument, as a service keeps them."""

    def __init__(self, service: Service, http: httpx.Client, plans: str, searches: str) -> None:
        self._service = service
        self._http = http
        self._plans = plans
        self._searches = searches

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
            calls.plan(self._plans, request, revises, progress, timeout_s, self._service.patience_s)
        )

    def check(self, request: Json) -> Members:
        """Whether a request for a plan flies, and what to know before; nothing is kept."""
        return self._run(calls.check(self._plans, request, self._service.patience_s))

    def submit(self, request: Json, *, revises: str | None = None) -> Job:
        """A plan to be made; `wait` for it."""
        return self._run(calls.submit(self._plans, request, revises, self._service.patience_s))

    def wait(
        self,
        plan_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Plan:
        """The plan once it is made."""
        return self._run(
            calls.wait_for_plan(self._plans, plan_id, progress, timeout_s, self._service.patience_s)
        )

    def get(self, plan_id: str) -> Plan:
        """A plan that is made."""
        return self._run(calls.plan_at(self._plans, plan_id, self._service.patience_s))

    def request(self, plan_id: str) -> dict[str, Any]:
        """What a plan was asked for by, as it was sent; `plan` takes it as it is."""
        return self._run(calls.request_at(self._plans, plan_id, self._service.patience_s))

    def plans(self, *, limit: int = 50, **filters: Unpack[Filters]) -> list[Job]:
        """Those there are, the latest first."""
        return self._run(calls.jobs(self._plans, limit, filters, self._service.patience_s))

    def table(self, plan_id: str) -> Columns:
        """The command table of a plan."""
        return self._run(calls.table(self._plans, plan_id, self._service.patience_s))

    def export(self, plan_id: str, format_name: str) -> bytes:
        """The table as a file: csv, netcdf, aem, czml, geojson, kml, png and more."""
        return self._run(calls.export(self._plans, plan_id, format_name, self._service.patience_s))

    def view(self, plan_id: str, *, step_s: float | None = None) -> Columns:
        """What there is to see along a plan: `carrier.latitude_deg`, `targets.0.azimuth_deg`."""
        return self._run(calls.view(self._plans, plan_id, step_s, self._service.patience_s))

    def delete(self, plan_id: str) -> None:
        """Cancel it, or delete it when it is finished."""
        self._run(calls.delete(self._plans, plan_id, self._service.patience_s))

    def opportunities(self, request: Json) -> Opportunities:
        """When each target can be seen; what is found is kept."""
        return self._run(calls.opportunities(self._searches, request, self._service.patience_s))

    def searches(self, *, limit: int = 50, **filters: Unpack[Filters]) -> list[Job]:
        """Searches for opportunities that are kept, the latest first."""
        return self._run(calls.jobs(self._searches, limit, filters, self._service.patience_s))

    def get_search(self, search_id: str) -> Opportunities:
        """All that one found."""
        return self._run(
            calls.opportunities_at(self._searches, search_id, self._service.patience_s)
        )

    def windows(
        self, search_id: str, *, target: str | None = None, limit: int | None = None
    ) -> list[Window]:
        """What one found of the target with this id, of all unless given; the first `limit`."""
        return self._run(
            calls.windows(self._searches, search_id, target, limit, self._service.patience_s)
        )

    def search_request(self, search_id: str) -> dict[str, Any]:
        """What was searched for, as it was sent."""
        return self._run(calls.request_at(self._searches, search_id, self._service.patience_s))

    def delete_search(self, search_id: str) -> None:
        """Forget what it found."""
        self._run(calls.delete(self._searches, search_id, self._service.patience_s))

    def _run(self, call: Call[T]) -> T:
        try:
            ask = next(call)
            while True:
                try:
                    reply = self._answer(ask)
                except Exception as error:  # noqa: BLE001 (the call decides what it means)
                    ask = call.throw(self._service.meaning(error))
                else:
                    ask = call.send(reply)
        except StopIteration as done:
            result: T = done.value
            return result

    def _answer(self, ask: Ask) -> Reply:
        time.sleep(ask.after_s)
        start_clock(ask)
        with self._http.stream(**request_of(ask), extensions={"trace": in_time}) as answer:
            intake = Intake(ask, answer.status_code)
            for part in answer.iter_bytes():
                intake.take(part)
            return reply_of(answer, intake.body)


class Client(Carrier):
    """A service, asked and waited for; close it, or use it in `with`.

    url: default: the environment's SLEWTRACK_URL, else this machine's port 8000.
    key: an API key, default: SLEWTRACK_KEY; none is needed on loopback.
    patience_s: for how long a service that is busy or can't be reached is asked again.
    progress: of what takes long, called with a `Progress` at each step.
    timeout_s: how long to wait, then `NotFinished`; the work goes on.
    spacecraft: the same calls for the imaging spacecraft, whose plans are kept apart.
    """

    def __init__(
        self,
        url: str | None = None,
        key: str | None = None,
        *,
        patience_s: float = PATIENCE_S,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        service = Service(url, key, patience_s=patience_s)
        http = httpx.Client(transport=transport, **service.options)
        super().__init__(service, http, PLANS, SEARCHES)
        self.spacecraft = Carrier(service, http, SPACECRAFT_PLANS, SPACECRAFT_SEARCHES)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End its connections."""
        self._http.close()

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

    def campaigns(self, *, limit: int = 50, **filters: Unpack[Filters]) -> list[Job]:
        """Those there are, the latest first."""
        return self._run(calls.jobs(CAMPAIGNS, limit, filters, self._service.patience_s))

    def fly(
        self,
        plan_id: str,
        request: Json,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Flights:
        """A plan flown many times with errors drawn anew; `runs` and `seed` of them."""
        return self._run(calls.fly(plan_id, request, progress, timeout_s, self._service.patience_s))

    def wait_for_flights(
        self,
        flights_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Flights:
        """Those that were posted before."""
        return self._run(
            calls.wait_for_flights(flights_id, progress, timeout_s, self._service.patience_s)
        )

    def flights(
        self, plan_id: str | None = None, *, limit: int = 50, **filters: Unpack[Filters]
    ) -> list[Job]:
        """Those there are of a plan, of all unless given, the latest first."""
        path = FLIGHTS if plan_id is None else calls.flights_path(plan_id)
        return self._run(calls.jobs(path, limit, filters, self._service.patience_s))

    def delete_flights(self, flights_id: str) -> None:
        """Cancel them, or delete them when they are flown."""
        self._run(calls.delete(FLIGHTS, flights_id, self._service.patience_s))

    def estimate_vertical(self, images: Sequence[bytes], request: Json) -> Members:
        """The nadir in body axes from one image file per camera."""
        return self._run(calls.estimate_vertical(images, request, self._service.patience_s))

    def compare(self, request: Json, csv: bytes | None = None) -> Members:
        """What flew beside a kept plan: its samples in the request, or in a CSV file."""
        return self._run(calls.comparison(request, csv, self._service.patience_s))

    def draw_comparison(
        self, request: Json, csv: bytes | None = None, format_name: str = "png"
    ) -> bytes:
        """The same as a picture: png or svg."""
        return self._run(calls.compare(request, csv, format_name, self._service.patience_s))

    def platforms(self) -> Sequence[Members]:
        """Those that a request can name, each as it may write out its own."""
        return self._run(calls.platforms(self._service.patience_s))

    def places(self, begin: str, *, limit: int = 8) -> Sequence[Members]:
        """The places whose names begin so, for a target of mode place."""
        return self._run(calls.known_names("places", begin, limit, self._service.patience_s))

    def stars(self, begin: str, *, limit: int = 8) -> Sequence[Members]:
        """The stars whose names begin so, for a target of mode star."""
        return self._run(calls.known_names("stars", begin, limit, self._service.patience_s))
