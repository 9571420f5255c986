"""What is asked of a service, and what its answers mean."""

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NoReturn

from slewtrack import answers
from slewtrack.answers import Campaign, Columns, Flights, Job, Members, Opportunities, Plan, Window
from slewtrack.asking import PAUSE_S, Ask, Call, Json, body_of, document, good, post, refusal_of
from slewtrack.events import Events, OnProgress, TimeIsUp
from slewtrack.filters import Filters, query_of
from slewtrack.problems import Cancelled, NoAnswer, NotFinished, Refused, problem_of

PLANS, SPACECRAFT_PLANS = "/v1/plans", "/v1/spacecraft/plans"
SEARCHES, SPACECRAFT_SEARCHES = "/v1/opportunities", "/v1/spacecraft/opportunities"
CAMPAIGNS = "/v1/campaigns"
FLIGHTS = "/v1/flights"
COMPARISONS = "/v1/telemetry/comparisons"
WAIT_S = 30  # of a POST, for what takes no longer
JOBS_A_PAGE, WINDOWS_A_PAGE = 200, 1000  # at most, for the service


def submit(path: str, request: Json, revises: str | None, patience_s: float) -> Call[Job]:
    """Accepted, not waited for."""
    query = {} if revises is None else {"revises": revises}
    ask = post(path, request, query=query, prefer="respond-async")
    return answers.job_of((yield from document(ask, patience_s)))


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
    ask = post(
        path,
        request,
        query={} if revises is None else {"revises": revises},
        prefer=f"wait={wait_s}" if progress is None else "respond-async",
    )
    members = yield from document(ask, patience_s)
    if "table" in members:
        return answers.plan_of(members)
    if timeout_s is not None and progress is None:
        timeout_s -= wait_s
    return (yield from wait_for_plan(path, members["id"], progress, timeout_s, patience_s))


def wait_for_plan(
    path: str,
    job_id: str,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
) -> Call[Plan]:
    """The plan once it is made; raises Refused, Cancelled, NotFinished."""
    members = yield from _wait(path, job_id, progress, timeout_s, patience_s)
    if "table" not in members:
        _raise_unmade(members)
    return answers.plan_of(members)


def campaign(
    request: Json, progress: OnProgress | None, timeout_s: float | None, patience_s: float
) -> Call[Campaign]:
    """Submitted and waited for, all passes planned."""
    job = yield from submit(CAMPAIGNS, request, None, patience_s)
    return (yield from wait_for_campaign(job.id, progress, timeout_s, patience_s))


def wait_for_campaign(
    job_id: str, progress: OnProgress | None, timeout_s: float | None, patience_s: float
) -> Call[Campaign]:
    """The campaign once all its passes are planned."""
    members = yield from _wait(CAMPAIGNS, job_id, progress, timeout_s, patience_s)
    if members.get("choice") is None or members["state"] == "cancelled":
        _raise_unmade(members)
    return answers.campaign_of(members)


def fly(
    plan_id: str,
    request: Json,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
) -> Call[Flights]:
    """Submitted and waited for, all runs flown."""
    job = yield from submit(flights_path(plan_id), request, None, patience_s)
    return (yield from wait_for_flights(job.id, progress, timeout_s, patience_s))


def wait_for_flights(
    job_id: str, progress: OnProgress | None, timeout_s: float | None, patience_s: float
) -> Call[Flights]:
    """The flights once all runs are flown; raises Refused, Cancelled, NotFinished."""
    members = yield from _wait(FLIGHTS, job_id, progress, timeout_s, patience_s)
    if members["state"] != "done":
        _raise_unmade(members)
    return answers.flights_of(members)


def flights_path(plan_id: str) -> str:
    """Where a plan's flights are posted and listed."""
    return f"{PLANS}/{plan_id}/flights"


def _raise_unmade(members: Members) -> NoReturn:
    if problem := members.get("problem"):
        raise Refused(problem_of(problem))
    raise Cancelled(members["id"])


def _wait(
    path: str,
    job_id: str,
    progress: OnProgress | None,
    timeout_s: float | None,
    patience_s: float,
) -> Call[Members]:
    """What is at the address when the work on it has ended."""
    until_s = None if timeout_s is None else time.monotonic() + timeout_s
    one = Ask(method="GET", path=f"{path}/{job_id}")
    heard = Events(progress, until_s)
    while True:
        members = yield from document(one, patience_s)
        if members["state"] not in ("queued", "running"):
            yield from _catch_up(f"{path}/{job_id}/events", heard)
            return members
        if until_s is not None and time.monotonic() >= until_s:
            raise NotFinished(job_id, members["state"])
        yield from _listen(f"{path}/{job_id}/events", heard)
        one = replace(one, after_s=0.0 if heard.has_ended else PAUSE_S)


def _catch_up(path: str, heard: Events) -> Call[None]:
    """With what a broken connection kept from who wants to be told."""
    seen: str | None = ""  # no event's id
    while heard.is_wanted and not heard.has_ended and seen != heard.last_id:
        seen = heard.last_id
        yield from _listen(path, heard)


def _listen(path: str, heard: Events) -> Call[None]:
    """To its events until they end, the connection breaks or time is up: then it is looked at."""
    ask = Ask(
        method="GET",
        path=path,
        headers=heard.headers,
        on_line=heard.take,
        silence_s=heard.silence_s,
    )
    try:
        reply = yield ask
    except (NoAnswer, TimeIsUp):
        return
    if reply.status >= 400 and reply.status not in (429, 503):
        raise Refused(refusal_of(reply))


def plan_at(path: str, plan_id: str, patience_s: float) -> Call[Plan]:
    """One that is made; raises Refused with 404 or with why it was not made, NotFinished."""
    ask = Ask(method="GET", path=f"{path}/{plan_id}")
    members = yield from document(ask, patience_s)
    if members["state"] in ("queued", "running"):
        raise NotFinished(plan_id, members["state"])
    if "table" not in members:
        _raise_unmade(members)
    return answers.plan_of(members)


def table(path: str, plan_id: str, patience_s: float) -> Call[Columns]:
    """Its columns."""
    ask = Ask(method="GET", path=f"{path}/{plan_id}/table", headers={"Accept": "application/json"})
    return answers.columns_of((yield from document(ask, patience_s)))


def export(path: str, plan_id: str, format_name: str, patience_s: float) -> Call[bytes]:
    """A file of its table."""
    ask = Ask(method="GET", path=f"{path}/{plan_id}/table", query={"format": format_name})
    return (yield from good(ask, patience_s)).body


def view(path: str, plan_id: str, step_s: float | None, patience_s: float) -> Call[Columns]:
    """What there is to see along it."""
    query = {} if step_s is None else {"step_s": repr(step_s)}
    ask = Ask(method="GET", path=f"{path}/{plan_id}/view", query=query)
    return answers.columns_of((yield from document(ask, patience_s)))


def request_at(path: str, job_id: str, patience_s: float) -> Call[dict[str, Any]]:
    """What it was asked for by."""
    ask = Ask(method="GET", path=f"{path}/{job_id}/request")
    return dict((yield from document(ask, patience_s)))


def jobs(path: str, limit: int, filters: Filters, patience_s: float) -> Call[list[Job]]:
    """The latest first, page after page until there are so many."""
    entries = yield from _pages(
        path, path.rpartition("/")[2], query_of(filters), JOBS_A_PAGE, limit, patience_s
    )
    return [answers.job_of(entry) for entry in entries]


def _pages(
    path: str,
    member: str,
    query: Mapping[str, str],
    page: int,
    limit: int | None,
    patience_s: float,
) -> Call[list[Members]]:
    """All entries of a list, or the first `limit`, asked for in pages."""
    found: list[Members] = []
    while limit is None or len(found) < limit:
        count = page if limit is None else min(limit - len(found), page)
        ask = Ask(method="GET", path=path, query={**query, "limit": str(count)})
        members = yield from document(ask, patience_s)
        found += members[member]
        if members["next"] is None:
            break
        query = {**query, "cursor": str(members["next"])}
    return found


def opportunities(path: str, request: Json, patience_s: float) -> Call[Opportunities]:
    """Windows of a request."""
    return answers.opportunities_of((yield from document(post(path, request), patience_s)))


def opportunities_at(path: str, search_id: str, patience_s: float) -> Call[Opportunities]:
    """Those a search found before."""
    ask = Ask(method="GET", path=f"{path}/{search_id}", headers={"Accept": "application/json"})
    return answers.opportunities_of((yield from document(ask, patience_s)))


def windows(
    path: str, search_id: str, target: str | None, limit: int | None, patience_s: float
) -> Call[list[Window]]:
    """Of a search, or of one of its targets."""
    query = {} if target is None else {"target": target}
    where = f"{path}/{search_id}/windows"
    found = yield from _pages(where, "windows", query, WINDOWS_A_PAGE, limit, patience_s)
    return [answers.window_of(one) for one in found]


def estimate_vertical(images: Sequence[bytes], request: Json, patience_s: float) -> Call[Members]:
    """The members of a horizon estimate."""
    parts = [("request", "request.json", body_of(request), "application/json")]
    parts += [
        ("images", f"image-{number}", image, "application/octet-stream")
        for number, image in enumerate(images)
    ]
    ask = Ask(method="POST", path="/v1/horizon/estimates", parts=parts)
    return (yield from document(ask, patience_s))


def compare(
    request: Json, csv: bytes | None, format_name: str | None, patience_s: float
) -> Call[bytes]:
    """What flew beside a plan: the answer, or a picture in a format."""
    ask = post(COMPARISONS, request, query={} if format_name is None else {"format": format_name})
    if csv is not None:
        parts = (
            ("request", "request.json", body_of(request), "application/json"),
            ("samples", "samples.csv", csv, "text/csv"),
        )
        ask = replace(ask, headers={}, body=None, parts=parts)
    return (yield from good(ask, patience_s)).body


def comparison(request: Json, csv: bytes | None, patience_s: float) -> Call[Members]:
    """The answer's members."""
    members: Members = json.loads((yield from compare(request, csv, "json", patience_s)))
    return members


def platforms(patience_s: float) -> Call[Sequence[Members]]:
    """Each as a request may write out its own."""
    members = yield from document(Ask(method="GET", path="/v1/platforms"), patience_s)
    found: Sequence[Members] = members["platforms"]
    return found


def known_names(kind: str, begin: str, limit: int, patience_s: float) -> Call[Sequence[Members]]:
    """The places or stars whose names begin so."""
    query = {"begin": begin, "limit": str(limit)}
    members = yield from document(Ask(method="GET", path=f"/v1/{kind}", query=query), patience_s)
    found: Sequence[Members] = members[kind]
    return found


def check(path: str, request: Json, patience_s: float) -> Call[Members]:
    """The answer to a dry run; raises Refused when it doesn't fly."""
    return (yield from document(post(path, request, query={"dry_run": "true"}), patience_s))


def delete(path: str, job_id: str, patience_s: float) -> Call[None]:
    """Cancelled, or deleted when it is finished."""
    yield from good(Ask(method="DELETE", path=f"{path}/{job_id}"), patience_s)
