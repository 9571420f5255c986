"""The answers of a service made in this process, by what the service's children run.

Plans are kept for as long as the process runs, the last `KEPT_MAX` of them.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from http import HTTPStatus
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from app.ids import new_id
from slewtrack.client.asking import Ask, Reply
from slewtrack.client.calls import (
    PLATFORM,
    SPACECRAFT,
    CarrierCalls,
    Exchange,
    ServiceCalls,
    Waiting,
)

if TYPE_CHECKING:
    from app.work.progress import Progress
    from app.work.result import Result

KEPT_MAX = 1000
_NAMES = ("platforms", "places", "stars")
_KEPT = ("plans", "campaigns", "flights", "opportunities")


class HereCarrier(CarrierCalls, Waiting):
    """Plans and opportunities of one carrier of an instrument, made in this process."""


class Here(ServiceCalls, HereCarrier):
    """The calls of `Client` without a service; `spacecraft` has those of the spacecraft."""

    def __init__(self) -> None:
        exchange = Exchange(answer=Desk().reply, meaning=lambda error: error, patience_s=0.0)
        HereCarrier.__init__(self, exchange, PLATFORM)
        self.spacecraft = HereCarrier(exchange, SPACECRAFT)


@dataclass(frozen=True)
class Kept:
    """What was made under an id: its whole answer, and of a plan its request and packed table."""

    text: Callable[[], bytes]
    passed: bool = True
    request: bytes = b""
    table_columns: bytes = b""


@dataclass(frozen=True)
class Work:
    """One exchange: what is asked, the id in its address, and whether of the spacecraft."""

    ask: Ask
    id: str
    is_spacecraft: bool

    @property
    def body(self) -> bytes:
        """The request; in a form it is the first part."""
        return self.ask.parts[0][2] if self.ask.parts else self.ask.body or b""

    @property
    def files(self) -> tuple[bytes, ...]:
        """Of a form, after the request."""
        return tuple(content for _, _, content, _ in self.ask.parts[1:])


class Desk:
    """Answers one request after the other; a refusal is told as a service tells it."""

    def __init__(self) -> None:
        self._kept: dict[str, Kept] = {}
        self._open: dict[str, Callable[[], Kept]] = {}

    async def reply(self, ask: Ask) -> Reply:
        """Raises what `on_line` does, and what is our own failure."""
        from app.answers.problem import problem_of
        from planner.base.errors import Refusal

        try:
            return Reply(status=HTTPStatus.OK, headers={}, body=self._body(ask))
        except Refusal as refusal:
            problem = problem_of(refusal)
            told = json.dumps(problem).encode()
            return Reply(status=problem["status"], headers={}, body=told)

    def _body(self, ask: Ask) -> bytes:
        steps = ask.path.removeprefix("/v1/").split("/")
        is_spacecraft = steps[0] == "spacecraft"
        kind, *rest = steps[is_spacecraft:]
        found_id = unquote(rest.pop(0)) if rest and kind in _KEPT else ""
        way = "/".join((kind, *(["ID"] if found_id else []), *rest))
        if f"{ask.method} {way}" not in _WAYS:
            raise _invalid(f"{ask.method} {way} needs a service, which slewtrack.Client asks")
        return _WAYS[f"{ask.method} {way}"](self, Work(ask, found_id, is_spacecraft))

    def keep(self, make: Callable[[], Kept]) -> str:
        """The id of what is made now, in place of the oldest."""
        kept_id = new_id()
        self._keep(kept_id, make())
        return kept_id

    def _keep(self, kept_id: str, kept: Kept) -> None:
        self._kept[kept_id] = kept
        while len(self._kept) > KEPT_MAX:
            del self._kept[next(iter(self._kept))]

    def begin(self, make: Callable[[], Kept]) -> bytes:
        """As a job, which is carried out when its events are listened to."""
        job_id = new_id()
        self._open[job_id] = make
        return _job(job_id)

    def kept(self, kept_id: str) -> Kept:
        """Raises InvalidInput."""
        if kept_id not in self._kept:
            raise _invalid(f"this process has made no {kept_id[:80]!r}, or has let go of it")
        return self._kept[kept_id]

    def whole(self, work: Work) -> bytes:
        """The answer, or the job that waits."""
        return _job(work.id) if work.id in self._open else _told(work.id, self.kept(work.id))

    def carry_out(self, work: Work) -> bytes:
        """Tell the events of what waits; it begins anew where `on_line` ended it before."""
        line, make = work.ask.on_line, self._open.get(work.id)
        if line is None or make is None:
            return b""

        def tell(event: str, told: Mapping[str, Any]) -> None:
            for text in (f"event: {event}", f"data: {json.dumps(told)}", ""):
                line(text)

        tell("state", {"state": "queued"})
        with _reporting(lambda now: tell("progress", vars(now))):
            kept = make()
        del self._open[work.id]
        self._keep(work.id, kept)
        tell("state", {"state": "done" if kept.passed else "failed"})
        return b""

    def forget(self, work: Work) -> bytes:
        """What is kept or waits."""
        self._open.pop(work.id, None)
        self._kept.pop(work.id, None)
        return b""


def _told(kept_id: str, kept: Kept) -> bytes:
    return b'{"id": "%s", ' % kept_id.encode() + kept.text().lstrip()[1:]


def _job(job_id: str) -> bytes:
    return json.dumps({"id": job_id, "state": "queued", "name": ""}).encode()


def _invalid(detail: str, field: str | None = None) -> Exception:
    from planner.base.errors import InvalidInput

    return InvalidInput(detail, field=field)


@contextmanager
def _reporting(tell: "Callable[[Progress], None]") -> Iterator[None]:
    from app.work import progress

    progress.report_through(tell)
    try:
        yield
    finally:
        progress.report_through(lambda _: None)


def _plan(desk: Desk, work: Work) -> bytes:
    from app.answers.members import provenance
    from app.requests.plan import read_plan_request
    from app.requests.spacecraft import read_spacecraft_request
    from app.work.plan import try_plan
    from app.work.spacecraft import try_session

    if "dry_run" in work.ask.query:
        origin = provenance(datetime.now(UTC), work.body)
        if work.is_spacecraft:
            return try_session(read_spacecraft_request(work.body), origin)
        return try_plan(read_plan_request(work.body), origin)
    make = partial(_made_plan, work.body, is_spacecraft=work.is_spacecraft)
    if work.ask.until_s is not None or "wait" not in work.ask.headers["Prefer"]:
        return desk.begin(make)
    plan_id = desk.keep(make)
    return _told(plan_id, desk.kept(plan_id))


def _made_plan(body: bytes, *, is_spacecraft: bool = False) -> Kept:
    from app.work.plan import plan_and_pack
    from app.work.spacecraft import plan_and_pack_session

    return _kept_plan(body, (plan_and_pack_session if is_spacecraft else plan_and_pack)(body))


def _kept_plan(body: bytes, new: "Result") -> Kept:
    from app.store.packed import unzip
    from app.work.plan import stored_table_json
    from app.work.spacecraft import stored_session_json

    def text() -> bytes:
        table_json = stored_table_json if new.iterations is not None else stored_session_json
        head = {"state": new.state, "revision": 1, "revises": None, "requested_by": None}
        table = table_json(new.table_columns)
        members = json.dumps(head).encode()[:-1]
        return b"".join((members, b",", unzip(new.document)[1:-1], b',"table":', table, b"}"))

    return Kept(text, new.state == "done", body, new.table_columns)


def _table(desk: Desk, work: Work) -> bytes:
    from app.work.plan import stored_table_file, stored_table_json
    from app.work.spacecraft import stored_session_file, stored_session_json
    from planner.output.export import EXPORTERS
    from planner.spacecraft.export import IMAGING_EXPORTERS

    made, format_name = desk.kept(work.id), work.ask.query.get("format")
    if format_name is None:
        return (stored_session_json if work.is_spacecraft else stored_table_json)(
            made.table_columns
        )
    formats = {*(IMAGING_EXPORTERS if work.is_spacecraft else EXPORTERS)}
    if format_name not in formats:
        raise _invalid(
            f"must be one of {', '.join(sorted(formats))}, not {format_name!r}", "format"
        )
    write = stored_session_file if work.is_spacecraft else stored_table_file
    return write(made.request, made.table_columns, format_name, datetime.now(UTC))


def _view(desk: Desk, work: Work) -> bytes:
    from app.work.view import AskedView, stored_plan_view, stored_session_view

    made, step_s = desk.kept(work.id), work.ask.query.get("step_s")
    asked = AskedView(
        plan_id=work.id,
        verified=made.passed,
        format_name=None,
        step_s=None if step_s is None else float(step_s),
        pixel_arcsec=None,
        created_utc=datetime.now(UTC),
    )
    view = stored_session_view if work.is_spacecraft else stored_plan_view
    return view(made.request, made.table_columns, asked)


def _opportunities(_: Desk, work: Work) -> bytes:
    from app.answers.members import provenance
    from app.answers.opportunities import whole_opportunities
    from app.requests.opportunities import read_opportunity_request
    from app.requests.spacecraft import read_imaging_opportunity_request
    from app.work.campaign import answer_opportunities
    from app.work.spacecraft import answer_imaging_opportunities

    origin = provenance(datetime.now(UTC), work.body)
    if work.is_spacecraft:
        asked = read_imaging_opportunity_request(work.body)
        return whole_opportunities(new_id(), answer_imaging_opportunities(asked, origin))
    found = answer_opportunities(read_opportunity_request(work.body), origin)
    return whole_opportunities(new_id(), found)


def _campaign(desk: Desk, work: Work) -> Kept:
    from app.store.packed import unzip
    from app.work.campaign import choose, plan_pass
    from app.work.progress import report

    chosen, passes = choose(work.body), []
    for number, part in enumerate(chosen.parts):
        report("plans", number, len(chosen.parts))
        tried = plan_pass(part)
        new, facts = tried.plan, tried.part.facts
        plan_id = (
            new_id() if new is None else desk.keep(partial(_kept_plan, tried.part.request, new))
        )
        told = {name: facts[name] for name in ("start", "stop", "looks", "left_out")}
        state, problem = (
            ("refused", {"detail": tried.refusal}) if new is None else (new.state, None)
        )
        told |= {"number": facts["pass"], "plan": plan_id, "state": state, "problem": problem}
        passes.append(told)
    report("plans", len(passes), len(passes))
    members = {
        "state": "done",
        "name": json.loads(work.body).get("name", ""),
        "choice": json.loads(unzip(chosen.document)),
        "passes": passes,
    }
    return Kept(json.dumps(members).encode)


def _flights(made: Kept, work: Work) -> Kept:
    from app.answers.flights import FlightsHead, flights_found
    from app.answers.members import from_store, to_json
    from app.store.packed import unzip
    from app.work.flights import PlanToFly, fly_part, prepare_flights, unpacked_outcomes

    new = prepare_flights(
        PlanToFly(
            plan_id=work.id,
            asked=work.body,
            request=made.request,
            table_columns=made.table_columns,
        ).to_bytes()
    )
    outcomes = [unpacked_outcomes(fly_part(part.request).document) for part in new.parts]
    head = from_store(FlightsHead, json.loads(unzip(new.document)))
    found = to_json(flights_found(head, outcomes))
    return Kept(lambda: b'{"state": "done", "name": "", ' + found[1:])


def _vertical(_: Desk, work: Work) -> bytes:
    from app.answers.members import provenance
    from app.requests.horizon import read_estimate_request
    from app.work.horizon import estimate_json

    origin = provenance(datetime.now(UTC), work.body, *work.files)
    return estimate_json(read_estimate_request(work.body), work.files, origin)


def _comparison(desk: Desk, work: Work) -> bytes:
    from app.answers.members import provenance
    from app.requests.telemetry import read_comparison_head, read_comparison_request
    from app.work.telemetry import FILES, SentTelemetry, compare_stored

    if work.files:
        sent = SentTelemetry(request=read_comparison_head(work.body), samples=work.files[0])
    else:
        request, samples = read_comparison_request(work.body)
        sent = SentTelemetry(request=request, samples=samples)
    made, now_utc, picture = (
        desk.kept(sent.request.plan),
        datetime.now(UTC),
        work.ask.query["format"],
    )
    if picture not in (*FILES, "json"):
        raise _invalid(f"must be one of {', '.join(FILES)}, not {picture!r}", "format")
    return compare_stored(
        made.request,
        made.table_columns,
        sent,
        provenance(now_utc, work.body, *work.files),
        None if picture == "json" else picture,
        now_utc,
    )


def _names(kind: str, _: Desk, work: Work) -> bytes:
    from app.answers.members import to_json
    from app.answers.names import KnownPlaces, KnownStars, PlatformList
    from planner.world.platforms import PLATFORMS, definition_of
    from planner.world.targets.autocomplete import places_beginning, stars_beginning

    query = work.ask.query
    if kind == "platforms":
        return to_json(PlatformList(platforms=[*map(definition_of, PLATFORMS.values())]))
    begin, limit = query["begin"], int(query["limit"])
    if kind == "places":
        return to_json(KnownPlaces(places=places_beginning(begin, limit)))
    return to_json(KnownStars(stars=stars_beginning(begin, limit)))


_WAYS: dict[str, Callable[[Desk, Work], bytes]] = {
    "POST plans": _plan,
    "POST opportunities": _opportunities,
    "POST campaigns": lambda desk, work: desk.begin(partial(_campaign, desk, work)),
    "POST plans/ID/flights": lambda desk, work: desk.begin(
        partial(_flights, desk.kept(work.id), work)
    ),
    "POST horizon/estimates": _vertical,
    "POST telemetry/comparisons": _comparison,
    "GET plans/ID/table": _table,
    "GET plans/ID/view": _view,
    "GET plans/ID/request": lambda desk, work: desk.kept(work.id).request,
    **{f"GET {kind}/ID": Desk.whole for kind in ("plans", "campaigns", "flights")},
    **{f"GET {kind}/ID/events": Desk.carry_out for kind in ("plans", "campaigns", "flights")},
    **{f"DELETE {kind}/ID": Desk.forget for kind in _KEPT},
    **{f"GET {kind}": partial(_names, kind) for kind in _NAMES},
}
