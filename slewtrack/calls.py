"""The calls to a service, as generators of requests, and the reading of its answers."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NoReturn, TypeVar

from slewtrack import answers
from slewtrack.answers import Campaign, Columns, Flights, Job, Members, Opportunities, Plan, Window
from slewtrack.asking import (
    PAUSE_S,
    Ask,
    Call,
    Json,
    address,
    body_of,
    document,
    good,
    object_of,
    post,
    refusal_of,
)
from slewtrack.events import Events, OnProgress, TimeIsUp
from slewtrack.filters import Filters, query_of
from slewtrack.problems import (
    MISREAD,
    BadAnswer,
    Cancelled,
    NoAnswer,
    NotFinished,
    Refused,
    problem_of,
)

T = TypeVar("T")

PLANS, SPACECRAFT_PLANS = "/v1/plans", "/v1/spacecraft/plans"
SEARCHES, SPACECRAFT_SEARCHES = "/v1/opportunities", "/v1/spacecraft/opportunities"
CAMPAIGNS = "/v1/campaigns"
FLIGHTS = "/v1/flights"
COMPARISONS = "/v1/telemetry/comparisons"
WAIT_S = 30  # of a POST, for what takes no longer
JOBS_A_PAGE, WINDOWS_A_PAGE = 200, 1000  # at most, for the service
ENTRIES_MAX = 1_000_000  # of a list that is asked for whole
LOOK_S = 1.0
CATCH_UP_S = 45.0


def submit(
    path: str,
    request: Json,
    revises: str | None,
    patience_s: float,
    until_s: float | None = None,
) -> Call[Job]:
    """Accepted, not waited for."""
    query = {} if revises is None else {"revises": revises}
    ask = post(path, request, query=query, prefer="respond-async")
    ask = replace(ask, until_s=_and_a_look(until_s))
    return (yield from document(ask, patience_s, answers.job_of))


def plan(
    path: str,
    request: Json,
    revises: str | None,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
) -> Call[Plan]:
    """Submitted and waited for: in one exchange where nobody asks how far it is."""
    wait_s = WAIT_S if timeout_s is None else min(WAIT_S, int(timeout_s))
    until_s = _until(timeout_s)
    ask = post(
        path,
        request,
        query={} if revises is None else {"revises": revises},
        prefer=f"wait={wait_s}" if progress is None else "respond-async",
    )
    made = yield from document(replace(ask, until_s=_and_a_look(until_s)), patience_s, _made)
    if isinstance(made, Plan):
        return made
    return (yield from wait_for_plan(path, made.id, progress, _left_s(until_s), patience_s))


def _made(members: Members) -> Plan | Job:
    """What there is at the address of a plan."""
    return answers.plan_of(members) if "table" in members else answers.job_of(members)


def wait_for_plan(
    path: str,
    job_id: str,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
) -> Call[Plan]:
    """The plan once it is made; raises Refused, Cancelled, NotFinished."""
    made = yield from _wait(path, job_id, progress, timeout_s, patience_s, _made)
    if isinstance(made, Job):
        _raise_unmade(made)
    return made


def campaign(
    request: Json, progress: OnProgress | None, timeout_s: float | None, patience_s: float
) -> Call[Campaign]:
    """Submitted and waited for, all passes planned."""
    until_s = _until(timeout_s)
    job = yield from submit(CAMPAIGNS, request, None, patience_s, until_s)
    timeout_s = _left_s(until_s)
    return (yield from wait_for_campaign(job.id, progress, timeout_s, patience_s))


def wait_for_campaign(
    job_id: str, progress: OnProgress | None, timeout_s: float | None, patience_s: float
) -> Call[Campaign]:
    """The campaign once all its passes are planned."""
    made = yield from _wait(CAMPAIGNS, job_id, progress, timeout_s, patience_s, _chosen)
    if isinstance(made, Job):
        _raise_unmade(made)
    return made


def _chosen(members: Members) -> Campaign | Job:
    job = answers.job_of(members)
    is_none = job.is_open or job.state == "cancelled" or members.get("choice") is None
    return job if is_none else answers.campaign_of(members)


def fly(
    plan_id: str,
    request: Json,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
) -> Call[Flights]:
    """Submitted and waited for, all runs flown."""
    until_s = _until(timeout_s)
    job = yield from submit(flights_path(plan_id), request, None, patience_s, until_s)
    timeout_s = _left_s(until_s)
    return (yield from wait_for_flights(job.id, progress, timeout_s, patience_s))


def wait_for_flights(
    job_id: str, progress: OnProgress | None, timeout_s: float | None, patience_s: float
) -> Call[Flights]:
    """The flights once all runs are flown; raises Refused, Cancelled, NotFinished."""
    made = yield from _wait(FLIGHTS, job_id, progress, timeout_s, patience_s, _flown)
    if isinstance(made, Job):
        _raise_unmade(made)
    return made


def _flown(members: Members) -> Flights | Job:
    job = answers.job_of(members)
    return answers.flights_of(members) if job.state == "done" else job


def flights_path(plan_id: str) -> str:
    """Where a plan's flights are posted and listed."""
    return address(PLANS, plan_id, "flights")


def _raise_unmade(job: Job) -> NoReturn:
    if job.state == "cancelled":
        raise Cancelled(job.id)
    try:
        problem = problem_of(object_of(job.problem))
    except MISREAD as error:
        raise BadAnswer(f"{job.id} is {job.state}, and nothing readable says why") from error
    raise Refused(problem)


def _wait(
    path: str,
    job_id: str,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
    read: Callable[[Members], T | Job],
) -> Call[T | Job]:
    """What is at the address when the work on it has ended."""
    until_s = _until(timeout_s)
    one = Ask(method="GET", path=address(path, job_id))
    events = address(path, job_id, "events")
    heard = Events(progress, until_s)
    state = "queued"
    while True:
        try:
            found = yield from document(
                replace(one, until_s=_and_a_look(until_s)), patience_s, read
            )
        except NoAnswer:
            if until_s is not None and time.monotonic() >= until_s:
                raise NotFinished(job_id, state) from None
            raise
        if not (isinstance(found, Job) and found.is_open):
            yield from _catch_up(events, heard)
            return found
        state = found.state
        if until_s is not None and time.monotonic() >= until_s:
            raise NotFinished(job_id, state)
        yield from _listen(events, heard)
        one = replace(one, after_s=0.0 if heard.has_ended else PAUSE_S)


def _until(timeout_s: float | None) -> float | None:
    return None if timeout_s is None else time.monotonic() + timeout_s


def _left_s(until_s: float | None) -> float | None:
    return None if until_s is None else until_s - time.monotonic()


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


def plan_at(path: str, plan_id: str, patience_s: float) -> Call[Plan]:
    """One that is made; raises Refused with 404 or with why it was not made, NotFinished."""
    made = yield from document(Ask(method="GET", path=address(path, plan_id)), patience_s, _made)
    if isinstance(made, Plan):
        return made
    if made.is_open:
        raise NotFinished(plan_id, made.state)
    _raise_unmade(made)


def table(path: str, plan_id: str, patience_s: float) -> Call[Columns]:
    """Its columns."""
    where = address(path, plan_id, "table")
    ask = Ask(method="GET", path=where, headers={"Accept": "application/json"})
    return (yield from document(ask, patience_s, answers.columns_of))


def export(path: str, plan_id: str, format_name: str, patience_s: float) -> Call[bytes]:
    """A file of its table."""
    ask = Ask(method="GET", path=address(path, plan_id, "table"), query={"format": format_name})
    return (yield from good(ask, patience_s)).body


def view(path: str, plan_id: str, step_s: float | None, patience_s: float) -> Call[Columns]:
    """What there is to see along it."""
    query = {} if step_s is None else {"step_s": repr(step_s)}
    ask = Ask(method="GET", path=address(path, plan_id, "view"), query=query)
    return (yield from document(ask, patience_s, answers.columns_of))


def request_at(path: str, job_id: str, patience_s: float) -> Call[dict[str, Any]]:
    """What it was asked for by."""
    ask = Ask(method="GET", path=address(path, job_id, "request"))
    return (yield from document(ask, patience_s, dict))


def jobs(path: str, limit: int, filters: Filters, patience_s: float) -> Call[list[Job]]:
    """The latest first, page after page until there are so many."""
    kind = path.rpartition("/")[2]
    return (
        yield from _pages(
            path, kind, query_of(filters), JOBS_A_PAGE, limit, patience_s, answers.job_of
        )
    )


def _pages(
    path: str,
    member: str,
    query: Mapping[str, str],
    page: int,
    limit: int | None,
    patience_s: float,
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
        new, after = yield from document(ask, patience_s, entries)
        found += new
        if after is None:
            return found
        if not new or len(new) > count or (limit is None and len(found) >= most):
            raise BadAnswer(f"GET {path} is answered with pages that come to no end")
        query = {**query, "cursor": after}
    return found


def opportunities(path: str, request: Json, patience_s: float) -> Call[Opportunities]:
    """Windows of a request."""
    return (yield from document(post(path, request), patience_s, answers.opportunities_of))


def opportunities_at(path: str, search_id: str, patience_s: float) -> Call[Opportunities]:
    """Those a search found before."""
    where = address(path, search_id)
    ask = Ask(method="GET", path=where, headers={"Accept": "application/json"})
    return (yield from document(ask, patience_s, answers.opportunities_of))


def windows(
    path: str, search_id: str, target: str | None, limit: int | None, patience_s: float
) -> Call[list[Window]]:
    """Of a search, or of one of its targets."""
    query = {} if target is None else {"target": target}
    where = address(path, search_id, "windows")
    return (
        yield from _pages(
            where, "windows", query, WINDOWS_A_PAGE, limit, patience_s, answers.window_of
        )
    )


def estimate_vertical(images: Sequence[bytes], request: Json, patience_s: float) -> Call[Members]:
    """The members of a horizon estimate."""
    parts = [("request", "request.json", body_of(request), "application/json")]
    parts += [
        ("images", f"image-{number}", image, "application/octet-stream")
        for number, image in enumerate(images)
    ]
    ask = Ask(method="POST", path="/v1/horizon/estimates", parts=parts)
    return (yield from document(ask, patience_s, dict))


def compare(request: Json, csv: bytes | None, format_name: str, patience_s: float) -> Call[bytes]:
    """What flew beside a plan, as a picture in a format."""
    return (yield from good(_comparison(request, csv, format_name), patience_s)).body


def comparison(request: Json, csv: bytes | None, patience_s: float) -> Call[Members]:
    """The answer's members."""
    return (yield from document(_comparison(request, csv, "json"), patience_s, dict))


def _comparison(request: Json, csv: bytes | None, format_name: str) -> Ask:
    ask = post(COMPARISONS, request, query={"format": format_name})
    if csv is not None:
        parts = (
            ("request", "request.json", body_of(request), "application/json"),
            ("samples", "samples.csv", csv, "text/csv"),
        )
        ask = replace(ask, headers={}, body=None, parts=parts)
    return ask


def platforms(patience_s: float) -> Call[Sequence[Members]]:
    """Each as a request may write out its own."""
    return (yield from _list(Ask(method="GET", path="/v1/platforms"), "platforms", patience_s))


def known_names(kind: str, begin: str, limit: int, patience_s: float) -> Call[Sequence[Members]]:
    """The places or stars whose names begin so."""
    query = {"begin": begin, "limit": str(limit)}
    return (yield from _list(Ask(method="GET", path=f"/v1/{kind}", query=query), kind, patience_s))


def _list(ask: Ask, member: str, patience_s: float) -> Call[Sequence[Members]]:
    return (
        yield from document(ask, patience_s, lambda members: answers.objects_of(members, member))
    )


def check(path: str, request: Json, patience_s: float) -> Call[Members]:
    """The answer to a dry run; raises Refused when it doesn't fly."""
    return (yield from document(post(path, request, query={"dry_run": "true"}), patience_s, dict))


def delete(path: str, job_id: str, patience_s: float) -> Call[None]:
    """Cancelled, or deleted when it is finished."""
    yield from good(Ask(method="DELETE", path=address(path, job_id)), patience_s)
