"""The calls to a service, each written once: a generator of requests that reads their answers.

`Client` waits for a call, `AsyncClient` awaits it; neither knows what is asked.
"""

import functools
import inspect
import json
import math
import time
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from typing import Any, Concatenate, Generic, NoReturn, ParamSpec, TypeVar, Unpack, overload

from slewtrack.client import asking, next_pass
from slewtrack.client.answers import (
    Campaign,
    Check,
    Columns,
    Comparison,
    Flights,
    Include,
    Job,
    Known,
    Opportunities,
    Plan,
    Vertical,
    Window,
)
from slewtrack.client.asking import (
    PAUSE_S,
    Ask,
    Call,
    File,
    Filters,
    Json,
    address,
    body_of,
    content_of,
    post,
    query_of,
    refusal_of,
)
from slewtrack.client.call_docs import whole_docstring
from slewtrack.client.events import Events, OnProgress, TimeIsUp
from slewtrack.client.problems import (
    BadAnswer,
    Cancelled,
    NoAnswer,
    NotFinished,
    Refused,
    problem_of,
)
from slewtrack.client.reading import MISREAD, Members, object_of, read, read_list

Named = Plan | Job | Opportunities | str  # what is kept, or its id
P = ParamSpec("P")
T = TypeVar("T")

PLANS = "/v1/plans"
SPACECRAFT_PLANS = "/v1/spacecraft/plans"
SEARCHES = "/v1/opportunities"
CAMPAIGNS = "/v1/campaigns"
CAMPAIGN_FILES = {
    "csv": "text/csv",
    "geojson": "application/geo+json",
    "kml": "application/vnd.google-earth.kml+xml",
    "zip": "application/zip",
}
FLIGHTS = "/v1/flights"
COMPARISONS = "/v1/telemetry/comparisons"
WAIT_S = 30  # of a POST, for what takes no longer
JOBS_A_PAGE, WINDOWS_A_PAGE, PROBABLE_A_PAGE = 200, 1000, 500  # at most, for the service
ENTRIES_MAX = 1_000_000  # of a list that is asked for whole
LOOK_S = 1.0
CATCH_UP_S = 45.0
VIEW: Include = ("view",)
JSON = {"Accept": "application/json"}


@dataclass(frozen=True)
class Exchange:
    """One request to a service and its reply; meaning: of what it raises instead."""

    answer: Callable[[Ask], Awaitable[asking.Reply]]
    meaning: Callable[[Exception], Exception]
    patience_s: float

    async def carry_out(self, call: Call[T]) -> T:
        """Return what the call returns."""
        try:
            ask = next(call)
            while True:
                try:
                    reply = await self.answer(ask)
                except Exception as error:  # noqa: BLE001 (the call decides what it means)
                    ask = call.throw(self.meaning(error))
                else:
                    ask = call.send(reply)
        except StopIteration as done:
            result: T = done.value
            return result


class Waiting:
    """Waits for each call: its exchanges return when they are over, so that nothing suspends."""

    _exchange: Exchange

    def _run(self, call: Call[T]) -> T:
        try:
            self._exchange.carry_out(call).send(None)
        except StopIteration as done:
            result: T = done.value
            return result
        raise RuntimeError("an exchange was awaited by nobody")


class Awaiting:
    """Gives calls to be awaited."""

    _exchange: Exchange

    async def _run(self, call: Call[T]) -> T:
        return await self._exchange.carry_out(call)


class BoundLater(Generic[P, T]):
    """A method that yields what to ask: waited for or awaited, as its holder carries it out."""

    def __init__(self, method: Callable[Concatenate[Any, P], Call[T]], example: str) -> None:
        method.__doc__ = whole_docstring(method, example)
        self._method = method
        _, *parameters = inspect.signature(method).parameters.values()
        self._signature = inspect.Signature(parameters)

    @overload
    def __get__(self, holder: None, owner: type) -> Callable[Concatenate[Any, P], Call[T]]: ...
    @overload
    def __get__(self, holder: Waiting, owner: type) -> Callable[P, T]: ...
    @overload
    def __get__(self, holder: Awaiting, owner: type) -> Callable[P, Coroutine[Any, Any, T]]: ...
    def __get__(self, holder: Any, owner: type) -> Any:
        if holder is None:
            return self._method
        bound: Any = functools.wraps(self._method)(
            lambda *words, **names: holder._run(self._method(holder, *words, **names))
        )
        bound.__signature__ = self._signature
        return bound


def call(
    example: str,
) -> Callable[[Callable[Concatenate[Any, P], Call[T]]], BoundLater[P, T]]:
    """Decorates a method of that kind; the example of its use goes into its docstring."""
    return lambda method: BoundLater(method, example)


class CarrierCalls:
    """Plans of one carrier of an instrument, as a service keeps them."""

    def __init__(self, exchange: Exchange, plans: str) -> None:
        self._exchange, self._plans = exchange, plans

    @call('client.plan(Path("request.json")).table["alpha_deg"]')
    def plan(
        self,
        request: Json,
        *,
        revises: str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Plan]:
        """Slews and tracks for every session, as a verified command table; it is kept."""
        # In one exchange where nobody asks how far it is.
        wait_s = WAIT_S if timeout_s is None else min(WAIT_S, int(timeout_s))
        prefer = f"wait={wait_s}" if progress is None else "respond-async"
        until_s = _until(timeout_s)
        ask = post(self._plans, request, query=_given(revises=revises), prefer=prefer)
        made = yield from self._read(replace(ask, until_s=_and_a_look(until_s)), _plan_or_job)
        if isinstance(made, Plan):
            return made
        return (yield from self._wait(self._plans, made.id, progress, until_s, _plan_or_job))

    @call("client.check(request).flies")
    def check(self, request: Json) -> Call[Check]:
        """Whether a request for a plan flies, and what to know before; nothing is kept."""
        return self._read_as(Check, post(self._plans, request, query={"dry_run": "true"}))

    @call("client.wait(client.submit(request))")
    def submit(self, request: Json, *, revises: str | None = None) -> Call[Job]:
        """A plan to be made; `wait` for it."""
        return self._submit(self._plans, request, query=_given(revises=revises))

    @call("client.wait(job, timeout_s=60.0)")
    def wait(
        self, job: Named, *, progress: OnProgress | None = None, timeout_s: float | None = None
    ) -> Call[Plan]:
        """The plan once it is made."""
        return self._wait(self._plans, job, progress, _until(timeout_s), _plan_or_job)

    @call('client.get("01a203fd-cbae-73f8-8276-319f76b8842c")')
    def get(self, plan: Named) -> Call[Plan]:
        """A plan that is made; raises NotFinished where it is not yet."""
        ask = Ask(method="GET", path=address(self._plans, plan))
        made = yield from self._read(ask, _plan_or_job)
        if isinstance(made, Plan):
            return made
        if made.is_open:
            raise NotFinished(made.id, made.state)
        _raise_unmade(made)

    @call('client.plan(client.request(plan) | {"name": "again"})')
    def request(self, plan: Named) -> Call[dict[str, Any]]:
        """What a plan was asked for by, as it was sent; `plan` takes it as it is."""
        return self._get(address(self._plans, plan, "request"), _whole)

    @call('client.plans(target="Vegas", after="2015-02-27T00:00:00Z")')
    def plans(self, *, limit: int = 50, **filters: Unpack[Filters]) -> Call[list[Job]]:
        """Those there are, the latest first."""
        return self._jobs(self._plans, limit, filters)

    @call("client.table(plan).to_pandas()")
    def table(self, plan: Named) -> Call[Columns]:
        """The command table of a plan, in degrees."""
        return self._get(address(self._plans, plan, "table"), Columns.of_json)

    @call('Path("plan.nc").write_bytes(client.export(plan, "netcdf"))')
    def export(self, plan: Named, format_name: str) -> Call[bytes]:
        """The table as a file; refused where the plan's verification failed."""
        path, query = address(self._plans, plan, "table"), {"format": format_name}
        return (yield from self._good(Ask(method="GET", path=path, query=query))).body

    @call('client.view(plan, step_s=1.0)["targets.0.elevation_deg"]')
    def view(self, plan: Named, *, step_s: float | None = None) -> Call[Columns]:
        """What there is to see along a plan, in degrees and metres."""
        query = {} if step_s is None else {"step_s": repr(step_s)}
        return self._get(address(self._plans, plan, "view"), Columns.of_json, query)

    @call("client.delete(plan)")
    def delete(self, plan: Named) -> Call[None]:
        """Cancel it, or delete it when it is finished."""
        return self._delete(address(self._plans, plan))

    def _read_as(self, kind: type[T], ask: Ask) -> Call[T]:
        return self._read(ask, partial(read, kind))

    def _good(self, ask: Ask) -> Call[asking.Reply]:
        return asking.good(ask, self._exchange.patience_s)

    def _read(self, ask: Ask, read: Callable[[Members], T]) -> Call[T]:
        return asking.document(ask, self._exchange.patience_s, read)

    def _get(
        self, path: str, read: Callable[[Members], T], query: Mapping[str, str] | None = None
    ) -> Call[T]:
        return self._read(Ask(method="GET", path=path, query=query or {}, headers=JSON), read)

    def _delete(self, path: str) -> Call[None]:
        yield from self._good(Ask(method="DELETE", path=path))

    def _submit(
        self,
        path: str,
        request: Json,
        *,
        query: Mapping[str, str] | None = None,
        until_s: float | None = None,
    ) -> Call[Job]:
        ask = post(path, request, query=query, prefer="respond-async")
        return self._read_as(Job, replace(ask, until_s=_and_a_look(until_s)))

    def _jobs(self, path: str, limit: int, filters: Filters) -> Call[list[Job]]:
        """The latest first, page after page until there are so many."""
        kind = path.rpartition("/")[2]
        return self._pages(Job, path, kind, query_of(filters), JOBS_A_PAGE, limit)

    def _pages(
        self,
        kind: type[T],
        path: str,
        member: str,
        query: Mapping[str, str],
        page: int,
        limit: int | None,
    ) -> Call[list[T]]:
        """All entries of a list, or the first `limit`, asked for in pages."""

        def entries(members: Members) -> tuple[list[T], str | None]:
            after = members["next"]
            return read_list(kind, members, member), after and str(after)

        found: list[T] = []
        most = ENTRIES_MAX if limit is None else limit
        while len(found) < most:
            count = min(most - len(found), page)
            ask = Ask(method="GET", path=path, query={**query, "limit": str(count)})
            new, after = yield from self._read(ask, entries)
            found += new
            if after is None:
                return found
            if not new or len(new) > count or (limit is None and len(found) >= most):
                raise BadAnswer(f"GET {path} is answered with pages that come to no end")
            query = {**query, "cursor": after}
        return found

    def _wait(
        self,
        path: str,
        job: Named,
        progress: OnProgress | None,
        until_s: float | None,
        read: Callable[[Members], T | Job],
    ) -> Call[T]:
        """What is there when the work has ended; raises Refused, Cancelled, NotFinished."""
        one = Ask(method="GET", path=address(path, job))
        events, job_id = address(path, job, "events"), str(getattr(job, "id", job))
        heard = Events(progress, until_s)
        state = "queued"
        while True:
            try:
                found = yield from self._read(replace(one, until_s=_and_a_look(until_s)), read)
            except NoAnswer:
                if until_s is not None and time.monotonic() >= until_s:
                    raise NotFinished(job_id, state) from None
                raise
            if not isinstance(found, Job):
                yield from _catch_up(events, heard)
                return found
            if not found.is_open:
                yield from _catch_up(events, heard)
                _raise_unmade(found)
            state = found.state
            if until_s is not None and time.monotonic() >= until_s:
                raise NotFinished(job_id, state)
            yield from _listen(events, heard)
            one = replace(one, after_s=0.0 if heard.has_ended else PAUSE_S)


class ServiceCalls(CarrierCalls):
    """All that a service is asked beside plans."""

    @call('client.opportunities(Path("targets.json")).windows[0].rise')
    def opportunities(
        self, request: Json, *, include: Include = VIEW, limit: int | None = None
    ) -> Call[Opportunities]:
        """When each target can be seen, the first `limit` windows; what is found is kept."""
        query = _window_query(include, limit)
        found = yield from self._read_as(Opportunities, post(SEARCHES, request, query=query))
        return (yield from self._with_the_rest(found, query, limit))

    @call('client.searches(name="gallery", limit=5)')
    def searches(self, *, limit: int = 50, **filters: Unpack[Filters]) -> Call[list[Job]]:
        """Searches for opportunities that are kept, the latest first."""
        return self._jobs(SEARCHES, limit, filters)

    @call("client.get_search(client.searches(limit=1)[0])")
    def get_search(
        self, search: Named, *, include: Include = VIEW, limit: int | None = None
    ) -> Call[Opportunities]:
        """What one found, the first `limit` windows, told as by `opportunities`."""
        query = _window_query(include, limit)
        path = address(SEARCHES, search)
        found = yield from self._get(path, partial(read, Opportunities), query)
        return (yield from self._with_the_rest(found, query, limit))

    @call('client.windows(search, target="Las Vegas", limit=3)')
    def windows(
        self,
        search: Named,
        *,
        target: str | None = None,
        include: Include = VIEW,
        limit: int | None = None,
    ) -> Call[list[Window]]:
        """What one found of the target with this id, of all unless given; the first `limit`."""
        query = _window_query(include, limit) | _given(target=target)
        return self._windows(search, query, limit)

    @call("client.opportunities(client.search_request(search))")
    def search_request(self, search: Named) -> Call[dict[str, Any]]:
        """What was searched for, as it was sent."""
        return self._get(address(SEARCHES, search, "request"), _whole)

    @call("client.delete_search(search)")
    def delete_search(self, search: Named) -> Call[None]:
        """Forget what it found."""
        return self._delete(address(SEARCHES, search))

    def _with_the_rest(
        self, found: Opportunities, query: Mapping[str, str], limit: int | None
    ) -> Call[Opportunities]:
        """The pages after the first."""
        after, left = found["next"], None if limit is None else limit - len(found.windows)
        if after is None or left == 0:
            return found
        more = yield from self._windows(found, {**query, "cursor": str(after)}, left)
        windows = (*found.windows, *more)
        members = {**found.members, "windows": [one.members for one in windows], "next": None}
        return replace(found, members=members, windows=windows)

    def _windows(
        self, search: Named, query: Mapping[str, str], limit: int | None
    ) -> Call[list[Window]]:
        path = address(SEARCHES, search)
        return self._pages(Window, path, "windows", query, int(query["limit"]), limit)

    @call('client.next_pass(Path("my_city.json"))')
    def next_pass(
        self,
        request: Json,
        *,
        start: datetime | str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Plan]:
        """The plan of a request whose one session is moved to the next window of its target.

        Its times are not looked at.  The axes rest until two minutes before the window.
        """
        until_s = _until(timeout_s)
        asked = object_of(json.loads(body_of(request)))
        try:
            search = next_pass.search_of(asked, start)
            found = yield from ServiceCalls.opportunities(self, search, include=next_pass.TOLD)
        except Refused as refused:
            raise next_pass.as_in_plan(refused.problem) from None
        yield from self._delete(address(SEARCHES, found))
        moved = next_pass.moved_to(next_pass.first_window(found), asked)
        job = yield from self._submit(self._plans, moved, until_s=until_s)
        return (yield from self._wait(self._plans, job, progress, until_s, _plan_or_job))

    @call("[client.get(one.plan) for one in client.campaign(request).passes]")
    def campaign(
        self,
        request: Json,
        *,
        revises: str | None = None,
        frozen_until: str | None = None,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Campaign]:
        """Many targets over days: chosen, ordered and planned pass by pass."""
        until_s = _until(timeout_s)
        query = _given(revises=revises, frozen_until=frozen_until)
        job = yield from self._submit(CAMPAIGNS, request, query=query, until_s=until_s)
        return (yield from self._wait(CAMPAIGNS, job, progress, until_s, _campaign_or_job))

    @call('Path("looks.kml").write_bytes(client.export_campaign(campaign, "kml"))')
    def export_campaign(self, job: Named | Campaign, format_name: str) -> Call[bytes]:
        """Its looks as csv, geojson or kml, or each pass's table and request as a zip archive."""
        accept = {"Accept": CAMPAIGN_FILES.get(format_name, f"application/{format_name}")}
        ask = Ask(method="GET", path=address(CAMPAIGNS, job), headers=accept)
        return (yield from self._good(ask)).body

    @call("client.wait_for_campaign(client.campaigns(limit=1)[0])")
    def wait_for_campaign(
        self, job: Named, *, progress: OnProgress | None = None, timeout_s: float | None = None
    ) -> Call[Campaign]:
        """One that was posted before."""
        return self._wait(CAMPAIGNS, job, progress, _until(timeout_s), _campaign_or_job)

    @call('client.campaigns(state="done")')
    def campaigns(self, *, limit: int = 50, **filters: Unpack[Filters]) -> Call[list[Job]]:
        """Those there are, the latest first."""
        return self._jobs(CAMPAIGNS, limit, filters)

    @call('client.fly(plan, {"runs": 1000}).probability_in_frame')
    def fly(
        self,
        plan: Named,
        request: Json = b"{}",
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Flights]:
        """A plan flown many times with errors drawn anew; the request says `runs` and `seed`."""
        until_s = _until(timeout_s)
        job = yield from self._submit(
            address(self._plans, plan, "flights"), request, until_s=until_s
        )
        return (yield from self._wait(FLIGHTS, job, progress, until_s, _flights_or_job))

    @call("client.wait_for_flights(client.flights(plan)[0])")
    def wait_for_flights(
        self, job: Named, *, progress: OnProgress | None = None, timeout_s: float | None = None
    ) -> Call[Flights]:
        """Those that were posted before."""
        return self._wait(FLIGHTS, job, progress, _until(timeout_s), _flights_or_job)

    @call('client.flights(plan, state="done")')
    def flights(
        self, plan: Named | None = None, *, limit: int = 50, **filters: Unpack[Filters]
    ) -> Call[list[Job]]:
        """Those there are of a plan, of all unless given, the latest first."""
        path = FLIGHTS if plan is None else address(self._plans, plan, "flights")
        return self._jobs(path, limit, filters)

    @call("client.delete_flights(client.flights(plan)[0])")
    def delete_flights(self, job: Named) -> Call[None]:
        """Cancel them, or delete them when they are flown."""
        return self._delete(address(FLIGHTS, job))

    @call('client.estimate_vertical([Path("ahead.png")], request).nadir_body')
    def estimate_vertical(self, images: Sequence[File], request: Json) -> Call[Vertical]:
        """The nadir in body axes from one image file per camera."""
        parts = [("request", "request.json", body_of(request), "application/json")]
        parts += [
            ("images", f"image-{number}", content_of(image), "application/octet-stream")
            for number, image in enumerate(images)
        ]
        return self._read_as(
            Vertical, Ask(method="POST", path="/v1/horizon/estimates", parts=parts)
        )

    @call('client.compare(plan, Path("flown.csv")).time_offset_s.value')
    def compare(self, request: Json | str | Plan, csv: File | None = None) -> Call[Comparison]:
        """What flew beside a plan: its samples in the request, or in a CSV file.

        The request may be the plan itself, or its id, where a file has the rest.
        """
        return self._read_as(Comparison, _comparison(request, csv, "json"))

    @call('Path("flown.png").write_bytes(client.draw_comparison(plan, Path("flown.csv")))')
    def draw_comparison(
        self, request: Json | str | Plan, csv: File | None = None, format_name: str = "png"
    ) -> Call[bytes]:
        """The same as a picture: png or svg."""
        return (yield from self._good(_comparison(request, csv, format_name))).body

    @call('client.platforms()[0]["field_of_view_deg"]')
    def platforms(self) -> Call[list[Known]]:
        """Those that a request can name, each as it may write out its own."""
        return self._list("platforms")

    @call('client.places("Las Ve")[0].name')
    def places(self, begin: str, *, limit: int = 8) -> Call[list[Known]]:
        """The places whose names begin so, for a target of mode place."""
        return self._list("places", {"begin": begin, "limit": str(limit)})

    @call('client.stars("Veg")[0]["hip"]')
    def stars(self, begin: str, *, limit: int = 8) -> Call[list[Known]]:
        """The stars whose names begin so, for a target of mode star."""
        return self._list("stars", {"begin": begin, "limit": str(limit)})

    def _list(self, kind: str, query: Mapping[str, str] | None = None) -> Call[list[Known]]:
        return self._get(f"/v1/{kind}", lambda members: read_list(Known, members, kind), query)


class Carrier(CarrierCalls, Waiting):
    """Plans of one carrier of an instrument, waited for."""


class AsyncCarrier(CarrierCalls, Awaiting):
    """The same, awaited."""


class Calls(ServiceCalls, Carrier):
    """All calls, waited for; `spacecraft` has those for plans of the imaging spacecraft."""

    def __init__(self, exchange: Exchange) -> None:
        super().__init__(exchange, PLANS)
        self.spacecraft = Carrier(exchange, SPACECRAFT_PLANS)


def _whole(members: Members) -> dict[str, Any]:
    return members if isinstance(members, dict) else dict(members)


def _window_query(include: Include, limit: int | None) -> dict[str, str]:
    page = PROBABLE_A_PAGE if "probability" in include else WINDOWS_A_PAGE
    query = {"limit": str(page if limit is None else min(limit, page))}
    return query | ({"include": ",".join(include)} if include else {})


def _given(**query: str | None) -> dict[str, str]:
    return {name: value for name, value in query.items() if value is not None}


def _plan_or_job(members: Members) -> Plan | Job:
    return read(Plan, members) if "table" in members else read(Job, members)


def _campaign_or_job(members: Members) -> Campaign | Job:
    job = read(Job, members)
    is_none = job.is_open or job.state == "cancelled" or members.get("choice") is None
    return job if is_none else read(Campaign, members)


def _flights_or_job(members: Members) -> Flights | Job:
    job = read(Job, members)
    return read(Flights, members) if job.state == "done" else job


def _raise_unmade(job: Job) -> NoReturn:
    if job.state == "cancelled":
        raise Cancelled(job.id)
    try:
        problem = problem_of(object_of(job.problem))
    except MISREAD as error:
        raise BadAnswer(f"{job.id} is {job.state}, and nothing readable says why") from error
    raise Refused(problem)


def _until(timeout_s: float | None) -> float | None:
    return None if timeout_s is None else time.monotonic() + timeout_s


def _and_a_look(until_s: float | None) -> float | None:
    """What is done in time is told, though it takes a moment longer to fetch."""
    return None if until_s is None else max(until_s, time.monotonic()) + LOOK_S


def _catch_up(path: str, heard: Events) -> Call[None]:
    """With what a broken connection kept from who wants to be told, for a while."""
    seen: str | None = ""  # no event's id
    heard.until_s = min(heard.until_s or math.inf, time.monotonic() + CATCH_UP_S)
    while heard.progress is not None and not heard.has_ended and seen != heard.last_id:
        seen = heard.last_id
        yield from _listen(path, heard)
        if time.monotonic() >= heard.until_s:
            return


def _listen(path: str, heard: Events) -> Call[None]:
    """To its events until they end, the connection breaks or time is up: then it is looked at."""
    ask = Ask(
        method="GET",
        path=path,
        headers=heard.headers,
        on_line=heard.take,
        silence_s=heard.silence_s,
        until_s=math.inf if heard.until_s is None else heard.until_s,
    )
    try:
        reply = yield ask
    except (NoAnswer, TimeIsUp):
        return
    if reply.status >= 400 and reply.status not in (429, 503):
        raise Refused(refusal_of(reply))


def _comparison(request: Json | str | Plan, csv: File | None, format_name: str) -> Ask:
    if isinstance(request, str | Plan):
        request = {"plan": str(getattr(request, "id", request))}
    ask = post(COMPARISONS, request, query={"format": format_name})
    if csv is not None:
        parts = (
            ("request", "request.json", body_of(request), "application/json"),
            ("samples", "samples.csv", content_of(csv), "text/csv"),
        )
        ask = replace(ask, headers={}, body=None, parts=parts)
    return ask
