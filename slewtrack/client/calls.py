"""The calls to a service, each written once: a generator of requests that reads their answers.

`Client` waits for a call, `AsyncClient` awaits it; neither knows what is asked.
"""

import functools
import math
import time
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Concatenate, Generic, NoReturn, ParamSpec, TypeVar, Unpack, overload

from slewtrack.client import answers, asking
from slewtrack.client.answers import (
    Campaign,
    Columns,
    Flights,
    Job,
    Members,
    Opportunities,
    Plan,
    Window,
)
from slewtrack.client.asking import (
    PAUSE_S,
    Ask,
    Call,
    Json,
    address,
    body_of,
    object_of,
    post,
    refusal_of,
)
from slewtrack.client.events import Events, OnProgress, TimeIsUp
from slewtrack.client.filters import Filters, query_of
from slewtrack.client.problems import (
    MISREAD,
    BadAnswer,
    Cancelled,
    NoAnswer,
    NotFinished,
    Refused,
    problem_of,
)

P = ParamSpec("P")
T = TypeVar("T")

PLATFORM = ("/v1/plans", "/v1/opportunities")
SPACECRAFT = ("/v1/spacecraft/plans", "/v1/spacecraft/opportunities")
CAMPAIGNS = "/v1/campaigns"
FLIGHTS = "/v1/flights"
COMPARISONS = "/v1/telemetry/comparisons"
WAIT_S = 30  # of a POST, for what takes no longer
JOBS_A_PAGE, WINDOWS_A_PAGE = 200, 1000  # at most, for the service
ENTRIES_MAX = 1_000_000  # of a list that is asked for whole
LOOK_S = 1.0
CATCH_UP_S = 45.0
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


class call(Generic[P, T]):  # noqa: N801 (a decorator)
    """A method that yields what to ask: waited for or awaited, as its holder carries it out."""

    def __init__(self, method: Callable[Concatenate[Any, P], Call[T]]) -> None:
        self._method = method

    @overload
    def __get__(self, holder: None, owner: type) -> Callable[Concatenate[Any, P], Call[T]]: ...
    @overload
    def __get__(self, holder: Waiting, owner: type) -> Callable[P, T]: ...
    @overload
    def __get__(self, holder: Awaiting, owner: type) -> Callable[P, Coroutine[Any, Any, T]]: ...
    def __get__(self, holder: Any, owner: type) -> Any:
        if holder is None:
            return self._method
        return functools.wraps(self._method)(
            lambda *words, **names: holder._run(self._method(holder, *words, **names))
        )


class CarrierCalls:
    """Plans and opportunities of one carrier of an instrument, as a service keeps them."""

    def __init__(self, exchange: Exchange, paths: tuple[str, str]) -> None:
        self._exchange = exchange
        self._plans, self._searches = paths

    @call
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

    @call
    def check(self, request: Json) -> Call[Members]:
        """Whether a request for a plan flies, and what to know before; nothing is kept."""
        return self._read(post(self._plans, request, query={"dry_run": "true"}), dict)

    @call
    def submit(self, request: Json, *, revises: str | None = None) -> Call[Job]:
        """A plan to be made; `wait` for it."""
        return self._submit(self._plans, request, query=_given(revises=revises))

    @call
    def wait(
        self, plan_id: str, *, progress: OnProgress | None = None, timeout_s: float | None = None
    ) -> Call[Plan]:
        """The plan once it is made."""
        return self._wait(self._plans, plan_id, progress, _until(timeout_s), _plan_or_job)

    @call
    def get(self, plan_id: str) -> Call[Plan]:
        """A plan that is made."""
        ask = Ask(method="GET", path=address(self._plans, plan_id))
        made = yield from self._read(ask, _plan_or_job)
        if isinstance(made, Plan):
            return made
        if made.is_open:
            raise NotFinished(plan_id, made.state)
        _raise_unmade(made)

    @call
    def request(self, plan_id: str) -> Call[dict[str, Any]]:
        """What a plan was asked for by, as it was sent; `plan` takes it as it is."""
        return self._get(address(self._plans, plan_id, "request"), dict)

    @call
    def plans(self, *, limit: int = 50, **filters: Unpack[Filters]) -> Call[list[Job]]:
        """Those there are, the latest first."""
        return self._jobs(self._plans, limit, filters)

    @call
    def table(self, plan_id: str) -> Call[Columns]:
        """The command table of a plan."""
        return self._get(address(self._plans, plan_id, "table"), answers.columns_of)

    @call
    def export(self, plan_id: str, format_name: str) -> Call[bytes]:
        """The table as a file: csv, netcdf, aem, czml, geojson, kml, png and more."""
        path, query = address(self._plans, plan_id, "table"), {"format": format_name}
        return (yield from self._good(Ask(method="GET", path=path, query=query))).body

    @call
    def view(self, plan_id: str, *, step_s: float | None = None) -> Call[Columns]:
        """What there is to see along a plan: `carrier.latitude_deg`, `targets.0.azimuth_deg`."""
        query = {} if step_s is None else {"step_s": repr(step_s)}
        return self._get(address(self._plans, plan_id, "view"), answers.columns_of, query)

    @call
    def delete(self, plan_id: str) -> Call[None]:
        """Cancel it, or delete it when it is finished."""
        return self._delete(address(self._plans, plan_id))

    @call
    def opportunities(self, request: Json) -> Call[Opportunities]:
        """When each target can be seen; what is found is kept."""
        return self._read(post(self._searches, request), answers.opportunities_of)

    @call
    def searches(self, *, limit: int = 50, **filters: Unpack[Filters]) -> Call[list[Job]]:
        """Searches for opportunities that are kept, the latest first."""
        return self._jobs(self._searches, limit, filters)

    @call
    def get_search(self, search_id: str) -> Call[Opportunities]:
        """All that one found."""
        return self._get(address(self._searches, search_id), answers.opportunities_of)

    @call
    def windows(
        self, search_id: str, *, target: str | None = None, limit: int | None = None
    ) -> Call[list[Window]]:
        """What one found of the target with this id, of all unless given; the first `limit`."""
        path, query = address(self._searches, search_id, "windows"), _given(target=target)
        return self._pages(path, "windows", query, WINDOWS_A_PAGE, limit, answers.window_of)

    @call
    def search_request(self, search_id: str) -> Call[dict[str, Any]]:
        """What was searched for, as it was sent."""
        return self._get(address(self._searches, search_id, "request"), dict)

    @call
    def delete_search(self, search_id: str) -> Call[None]:
        """Forget what it found."""
        return self._delete(address(self._searches, search_id))

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
        return self._read(replace(ask, until_s=_and_a_look(until_s)), answers.job_of)

    def _jobs(self, path: str, limit: int, filters: Filters) -> Call[list[Job]]:
        """The latest first, page after page until there are so many."""
        kind = path.rpartition("/")[2]
        return self._pages(path, kind, query_of(filters), JOBS_A_PAGE, limit, answers.job_of)

    def _pages(
        self,
        path: str,
        member: str,
        query: Mapping[str, str],
        page: int,
        limit: int | None,
        read: Callable[[Members], T],
    ) -> Call[list[T]]:
        """All entries of a list, or the first `limit`, asked for in pages."""

        def entries(members: Members) -> tuple[list[T], str | None]:
            after = members["next"]
            return [*map(read, answers.objects_of(members, member))], after and str(after)

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
        job_id: str,
        progress: OnProgress | None,
        until_s: float | None,
        read: Callable[[Members], T | Job],
    ) -> Call[T]:
        """What is there when the work has ended; raises Refused, Cancelled, NotFinished."""
        one = Ask(method="GET", path=address(path, job_id))
        events = address(path, job_id, "events")
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
    """All that a service is asked beside what both carriers have."""

    @call
    def campaign(
        self, request: Json, *, progress: OnProgress | None = None, timeout_s: float | None = None
    ) -> Call[Campaign]:
        """Many targets over days: chosen, ordered and planned pass by pass."""
        until_s = _until(timeout_s)
        job = yield from self._submit(CAMPAIGNS, request, until_s=until_s)
        return (yield from self._wait(CAMPAIGNS, job.id, progress, until_s, _campaign_or_job))

    @call
    def wait_for_campaign(
        self,
        campaign_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Campaign]:
        """One that was posted before."""
        return self._wait(CAMPAIGNS, campaign_id, progress, _until(timeout_s), _campaign_or_job)

    @call
    def campaigns(self, *, limit: int = 50, **filters: Unpack[Filters]) -> Call[list[Job]]:
        """Those there are, the latest first."""
        return self._jobs(CAMPAIGNS, limit, filters)

    @call
    def fly(
        self,
        plan_id: str,
        request: Json,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Flights]:
        """A plan flown many times with errors drawn anew; `runs` and `seed` of them."""
        until_s = _until(timeout_s)
        path = address(self._plans, plan_id, "flights")
        job = yield from self._submit(path, request, until_s=until_s)
        return (yield from self._wait(FLIGHTS, job.id, progress, until_s, _flights_or_job))

    @call
    def wait_for_flights(
        self,
        flights_id: str,
        *,
        progress: OnProgress | None = None,
        timeout_s: float | None = None,
    ) -> Call[Flights]:
        """Those that were posted before."""
        return self._wait(FLIGHTS, flights_id, progress, _until(timeout_s), _flights_or_job)

    @call
    def flights(
        self, plan_id: str | None = None, *, limit: int = 50, **filters: Unpack[Filters]
    ) -> Call[list[Job]]:
        """Those there are of a plan, of all unless given, the latest first."""
        path = FLIGHTS if plan_id is None else address(self._plans, plan_id, "flights")
        return self._jobs(path, limit, filters)

    @call
    def delete_flights(self, flights_id: str) -> Call[None]:
        """Cancel them, or delete them when they are flown."""
        return self._delete(address(FLIGHTS, flights_id))

    @call
    def estimate_vertical(self, images: Sequence[bytes], request: Json) -> Call[Members]:
        """The nadir in body axes from one image file per camera."""
        parts = [("request", "request.json", body_of(request), "application/json")]
        parts += [
            ("images", f"image-{number}", image, "application/octet-stream")
            for number, image in enumerate(images)
        ]
        return self._read(Ask(method="POST", path="/v1/horizon/estimates", parts=parts), dict)

    @call
    def compare(self, request: Json, csv: bytes | None = None) -> Call[Members]:
        """What flew beside a kept plan: its samples in the request, or in a CSV file."""
        return self._read(_comparison(request, csv, "json"), dict)

    @call
    def draw_comparison(
        self, request: Json, csv: bytes | None = None, format_name: str = "png"
    ) -> Call[bytes]:
        """The same as a picture: png or svg."""
        return (yield from self._good(_comparison(request, csv, format_name))).body

    @call
    def platforms(self) -> Call[Sequence[Members]]:
        """Those that a request can name, each as it may write out its own."""
        return self._list("platforms")

    @call
    def places(self, begin: str, *, limit: int = 8) -> Call[Sequence[Members]]:
        """The places whose names begin so, for a target of mode place."""
        return self._list("places", {"begin": begin, "limit": str(limit)})

    @call
    def stars(self, begin: str, *, limit: int = 8) -> Call[Sequence[Members]]:
        """The stars whose names begin so, for a target of mode star."""
        return self._list("stars", {"begin": begin, "limit": str(limit)})

    def _list(self, kind: str, query: Mapping[str, str] | None = None) -> Call[Sequence[Members]]:
        return self._get(f"/v1/{kind}", lambda members: answers.objects_of(members, kind), query)


def _given(**query: str | None) -> dict[str, str]:
    return {name: value for name, value in query.items() if value is not None}


def _plan_or_job(members: Members) -> Plan | Job:
    return answers.plan_of(members) if "table" in members else answers.job_of(members)


def _campaign_or_job(members: Members) -> Campaign | Job:
    job = answers.job_of(members)
    is_none = job.is_open or job.state == "cancelled" or members.get("choice") is None
    return job if is_none else answers.campaign_of(members)


def _flights_or_job(members: Members) -> Flights | Job:
    job = answers.job_of(members)
    return answers.flights_of(members) if job.state == "done" else job


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
    while heard.is_wanted and not heard.has_ended and seen != heard.last_id:
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


def _comparison(request: Json, csv: bytes | None, format_name: str) -> Ask:
    ask = post(COMPARISONS, request, query={"format": format_name})
    if csv is not None:
        parts = (
            ("request", "request.json", body_of(request), "application/json"),
            ("samples", "samples.csv", csv, "text/csv"),
        )
        ask = replace(ask, headers={}, body=None, parts=parts)
    return ask
