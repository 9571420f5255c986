"""Exchanges of the service's clients, answered in this process by what its children run."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, ClassVar
from urllib.parse import unquote

from app.answers.members import PlanHead, provenance, to_json, whole_answer
from app.answers.problem import problem_of
from app.ids import new_id
from app.requests.plan import read_plan_request
from app.store.packed import unzip
from app.work.plan import plan_and_pack, stored_table_file, stored_table_json, try_plan
from app.work.progress import OnProgress, report, report_through
from app.work.result import Part, Result
from planner.base.errors import InvalidInput, Refusal
from planner.output.export import EXPORTERS

if TYPE_CHECKING:
    from app.work.campaign import MadePass
    from app.work.telemetry import SentTelemetry
    from planner.inflight.telemetry.compare import Comparison
    from slewtrack.client.asking import Ask

_NAMES = ("platforms", "places", "stars")
_KEPT = ("plans", "campaigns", "flights", "opportunities")


@dataclass(frozen=True)
class Kept:
    """What was made: the whole answer under an id, its request, a plan's packed table, of a
    campaign the passes with plans, and of an imaging session the plan of its body.
    """

    text: Callable[[str], bytes]
    passed: bool = True
    request: bytes = b""
    table_columns: bytes = b""
    passes: "Sequence[MadePass]" = ()
    as_plan: Callable[[str], bytes] | None = None


@dataclass(frozen=True)
class LocalAsk:
    """One exchange: what is asked, the id in its address, and whether of the spacecraft."""

    ask: "Ask"
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
    """Answers one request after the other and keeps what it makes, the last `kept_max` plans."""

    kept_max: ClassVar[int] = 1000

    def __init__(self) -> None:
        self._kept: dict[str, Kept] = {}
        self._open: dict[str, Callable[[], Kept]] = {}

    def answer(self, ask: "Ask") -> bytes:
        """The body of the reply; raises Refusals, what `on_line` does, and our own failures."""
        steps = ask.path.removeprefix("/v1/").split("/")
        is_spacecraft = steps[0] == "spacecraft"
        kind, *rest = steps[is_spacecraft:]
        found_id = unquote(rest.pop(0)) if rest and kind in _KEPT else ""
        way = "/".join((kind, *(["ID"] if found_id else []), *rest))
        if f"{ask.method} {way}" not in _WAYS:
            raise InvalidInput(f"{ask.method} {way} needs a service, which slewtrack.Client asks")
        return _WAYS[f"{ask.method} {way}"](self, LocalAsk(ask, found_id, is_spacecraft))

    def table_file(self, made: Kept, format_name: str) -> bytes:
        """Of a plan; raises Unverified."""
        _require_format(format_name, EXPORTERS)
        return stored_table_file(made.request, made.table_columns, format_name, datetime.now(UTC))

    def choose(self, body: bytes) -> Result:
        from app.work.campaign import choose

        return choose(body)

    def fly(self, parts: Sequence[Part], _runs: int) -> Sequence[bytes]:
        """The outcomes of all runs, packed, part by part."""
        from app.work.flights import fly_part

        return [fly_part(part.request).document for part in parts]

    def keep(self, make: Callable[[], Kept]) -> str:
        """The id of what is made now, in place of the oldest."""
        self.put(kept_id := new_id(), make())
        return kept_id

    def put(self, kept_id: str, kept: Kept) -> None:
        """In place of what was under the id."""
        self._kept[kept_id] = kept
        while len(self._kept) > self.kept_max:
            del self._kept[next(iter(self._kept))]

    def begin(self, make: Callable[[], Kept]) -> bytes:
        """As a job, which is carried out when its events are listened to."""
        self._open[job_id := new_id()] = make
        return _job(job_id)

    def planned(self, plan_ids: Sequence[str]) -> "list[MadePass]":
        """Passes of campaigns with these plans that are kept yet."""
        found = {one.plan: one for kept in self._kept.values() for one in kept.passes}
        return [found[plan_id] for plan_id in plan_ids if plan_id in found]

    def kept(self, kept_id: str) -> Kept:
        if kept_id not in self._kept:
            raise InvalidInput(f"this process has made no {kept_id[:80]!r}, or has let go of it")
        return self._kept[kept_id]

    def whole(self, work: LocalAsk) -> bytes:
        """The answer, or the job that waits."""
        if work.id in self._open:
            return _job(work.id)
        made = self.kept(work.id)
        return (made.text if work.is_spacecraft else made.as_plan or made.text)(work.id)

    def campaign(self, work: LocalAsk) -> bytes:
        """The answer, or one of a campaign's files."""
        from app.work.campaign import SUFFIXES, campaign_file

        media_type = work.ask.headers.get("Accept", "application/json")
        if media_type not in SUFFIXES:
            formats = ("json", *(suffix[1:] for suffix in SUFFIXES.values()))
            _require_format(media_type.removeprefix("application/"), formats)
            return self.whole(work)
        made = self.kept(work.id)
        if not made.passes:
            raise InvalidInput("there is no file of looks: the campaign has no plan", field="ID")
        return campaign_file(media_type, made.request, made.passes)

    def carry_out(self, work: LocalAsk) -> bytes:
        """Tell the events of what waits; it begins anew where `on_line` ended it before."""
        line, make = work.ask.on_line, self._open.get(work.id)
        if line is None or make is None:
            return b""

        def tell(event: str, told: Mapping[str, Any]) -> None:
            for text in (f"event: {event}", f"data: {json.dumps(told)}", ""):
                line(text)

        tell("state", {"state": "queued"})
        with reporting(lambda now: tell("progress", vars(now))):
            kept = make()
        del self._open[work.id]
        self.put(work.id, kept)
        tell("state", {"state": "done" if kept.passed else "failed"})
        return b""

    def forget(self, work: LocalAsk) -> bytes:
        self._open.pop(work.id, None)
        self._kept.pop(work.id, None)
        return b""


def _job(job_id: str) -> bytes:
    return json.dumps({"id": job_id, "state": "queued", "name": ""}).encode()


def _require_format(name: str, formats: Iterable[str]) -> None:
    if name not in formats:
        raise InvalidInput(
            f"must be one of {', '.join(sorted(formats))}, not {name!r}", field="format"
        )


@contextmanager
def reporting(tell: OnProgress) -> Iterator[None]:
    report_through(tell)
    try:
        yield
    finally:
        report_through(lambda _: None)


def _plan(desk: Desk, work: LocalAsk) -> bytes:
    if "dry_run" in work.ask.query:
        origin = provenance(datetime.now(UTC), work.body)
        if work.is_spacecraft:
            from app.requests.spacecraft import read_spacecraft_request
            from app.work.spacecraft import try_session

            return try_session(read_spacecraft_request(work.body), origin)
        return try_plan(read_plan_request(work.body), origin)
    make = partial(_made_plan, work.body, is_spacecraft=work.is_spacecraft)
    if work.ask.until_s is not None or "wait" not in work.ask.headers["Prefer"]:
        return desk.begin(make)
    plan_id = desk.keep(make)
    return desk.kept(plan_id).text(plan_id)


def _made_plan(body: bytes, *, is_spacecraft: bool) -> Kept:
    if not is_spacecraft:
        return _kept_plan(body, plan_and_pack(body))
    from app.work.spacecraft import plan_and_pack_session, stored_session_json

    new = plan_and_pack_session(body)
    plan = _kept_plan(body, new)
    return replace(plan, text=partial(_whole, new, stored_session_json, 2), as_plan=plan.text)


def _kept_plan(body: bytes, new: Result) -> Kept:
    text = partial(_whole, new, stored_table_json, 0)
    return Kept(text, new.state == "done", body, new.table_columns)


def _whole(new: Result, table_json: Callable[[bytes], bytes], part: int, plan_id: str) -> bytes:
    head = PlanHead(id=plan_id, state=new.state, revision=1, revises=None, requested_by=None)
    return whole_answer(head, unzip(new.content[part]), table_json(new.table_columns))


def _table(desk: Desk, work: LocalAsk) -> bytes:
    made, format_name = desk.kept(work.id), work.ask.query.get("format")
    if format_name is not None:
        return desk.table_file(made, format_name)
    if not work.is_spacecraft:
        return stored_table_json(made.table_columns)
    from app.work.spacecraft import stored_session_json

    return stored_session_json(made.table_columns)


def _view(desk: Desk, work: LocalAsk) -> bytes:
    from app.work.view import AskedView, stored_plan_view

    made, step_s = desk.kept(work.id), work.ask.query.get("step_s")
    asked = AskedView(
        plan_id=work.id,
        verified=made.passed,
        format_name=None,
        step_s=None if step_s is None else float(step_s),
        pixel_arcsec=None,
        created_utc=datetime.now(UTC),
    )
    return stored_plan_view(made.request, made.table_columns, asked)


def _opportunities(desk: Desk, work: LocalAsk) -> bytes:
    """Found, or told of again by page."""
    from app.work.searches import (
        WindowsAsked,
        find_windows,
        read_opportunity_request,
        read_windows,
        search_json,
    )

    query, request = work.ask.query, work.body
    asked = WindowsAsked(
        cursor=int(query.get("cursor", 0)),
        limit=int(query["limit"]),
        target=query.get("target"),
        include=frozenset(filter(None, query.get("include", "").split(","))),
    )
    if work.id:
        made = desk.kept(work.id)
        page = read_windows(made.request, made.table_columns, asked)
        return search_json(work.id, made.text(work.id), page)
    found, page = find_windows(
        read_opportunity_request(request), provenance(datetime.now(UTC), request), asked
    )
    kept_id = desk.keep(lambda: Kept(lambda _: found.head, True, request, found.edges))
    return search_json(kept_id, found.head, page)


def _campaign(desk: Desk, work: LocalAsk) -> Kept:
    from app.work.campaign import (
        MadePass,
        plan_pass,
        plans_that_stay,
        require_both,
        revised,
    )

    body, query = work.body, work.ask.query
    before, frozen_until = query.get("revises"), query.get("frozen_until")
    require_both(before, frozen_until)
    if before is not None:
        body = revised(body, frozen_until, json.loads(desk.kept(before).text(before)))
    chosen, passes = desk.choose(body), []
    choice = json.loads(unzip(chosen.document))
    made: list[MadePass] = desk.planned(plans_that_stay(choice))
    for number, wanted in enumerate(chosen.parts):
        report("plans", number, len(chosen.parts))
        part, new = plan_pass(wanted)
        if isinstance(new, Refusal):
            passes.append(told_pass(part, "refused", problem=problem_of(new)))
        else:
            plan_id = desk.keep(partial(_kept_plan, part.request, new))
            if new.state == "done":
                at_utc, columns = datetime.now(UTC), new.table_columns
                made.append(MadePass(part.facts, plan_id, part.request, columns, at_utc))
            passes.append(told_pass(part, new.state, plan=plan_id))
    report("plans", len(passes), len(passes))
    members = {
        "state": "done",
        "name": json.loads(body).get("name", ""),
        "choice": choice,
        "passes": passes,
    }
    return Kept(
        lambda campaign_id: json.dumps({"id": campaign_id, **members}).encode(),
        request=body,
        passes=made,
    )


def told_pass(
    part: Part, state: str = "queued", plan: str = "", problem: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    names = ("carrier", "start", "stop", "looks", "left_out", "resources")
    facts = {name: part.facts[name] for name in names if name in part.facts}
    return {**facts, "number": part.facts["pass"], "state": state, "plan": plan, "problem": problem}


def _flights(desk: Desk, work: LocalAsk) -> Kept:
    from app.work.flights import (
        PlanToFly,
        flights_found,
        prepare_flights,
        unpacked_outcomes,
    )

    made = desk.kept(work.id)
    what = PlanToFly(
        plan_id=work.id, asked=work.body, request=made.request, table_columns=made.table_columns
    )
    new = prepare_flights(what.to_bytes())
    head = json.loads(unzip(new.document))
    outcomes = [unpacked_outcomes(packed) for packed in desk.fly(new.parts, head["runs"])]
    found = to_json(flights_found(head, outcomes))
    return Kept(
        lambda flights_id: b'{"id":"%s","state":"done","name":"",' % flights_id.encode() + found[1:]
    )


def _vertical(_: Desk, work: LocalAsk) -> bytes:
    from app.work.horizon import ESTIMATE_READER, estimate_json

    origin = provenance(datetime.now(UTC), work.body, *work.files)
    return estimate_json(ESTIMATE_READER.read(work.body), work.files, origin)


def _comparison(desk: Desk, work: LocalAsk) -> bytes:
    from app.work.telemetry import FILES, answer_json
    from planner.inflight.telemetry.figure import draw_comparison

    format_name, now_utc = work.ask.query["format"], datetime.now(UTC)
    _require_format(format_name, (*FILES, "pdf", "json"))
    sent, found = _compare(desk, work.body, *work.files)
    if format_name == "json":
        origin = provenance(now_utc, work.body, *work.files)
        return answer_json(found, sent.request, origin)
    if format_name in FILES:
        return FILES[format_name].write(found, now_utc)
    return draw_comparison(found, format_name, now_utc)


@lru_cache(maxsize=1)  # numbers and picture are asked for one after the other
def _compare(desk: Desk, body: bytes, *csv: bytes) -> "tuple[SentTelemetry, Comparison]":
    from app.store.packed import unpack
    from app.work.plan import stored_plan
    from app.work.telemetry import compare_sent, read_sent

    sent = read_sent(body, *csv)
    made = desk.kept(sent.request.plan)
    return sent, compare_sent(stored_plan(made.request, unpack(made.table_columns)), sent)


def _names(kind: str, _: Desk, work: LocalAsk) -> bytes:
    from app.answers.service import KnownPlaces, KnownStars, platform_list
    from planner.world.targets.autocomplete import places_beginning, stars_beginning

    query = work.ask.query
    if kind == "platforms":
        return to_json(platform_list())
    begin, limit = query["begin"], int(query["limit"])
    if kind == "places":
        return to_json(KnownPlaces(places=places_beginning(begin, limit)))
    return to_json(KnownStars(stars=stars_beginning(begin, limit)))


_WAYS: dict[str, Callable[[Desk, LocalAsk], bytes]] = {
    "POST plans": _plan,
    "POST opportunities": _opportunities,
    "POST campaigns": lambda desk, work: desk.begin(partial(_campaign, desk, work)),
    "POST plans/ID/flights": lambda desk, work: desk.begin(partial(_flights, desk, work)),
    "POST horizon/estimates": _vertical,
    "POST telemetry/comparisons": _comparison,
    "GET opportunities/ID": _opportunities,
    "GET plans/ID/table": _table,
    "GET plans/ID/view": _view,
    "GET plans/ID/request": lambda desk, work: desk.kept(work.id).request,
    **{f"GET {kind}/ID": Desk.whole for kind in ("plans", "flights")},
    "GET campaigns/ID": Desk.campaign,
    **{f"GET {kind}/ID/events": Desk.carry_out for kind in ("plans", "campaigns", "flights")},
    **{f"DELETE {kind}/ID": Desk.forget for kind in _KEPT},
    **{f"GET {kind}": partial(_names, kind) for kind in _NAMES},
}
