"""Campaigns: the choice, a plan request for each pass, the answers, and files of looks."""

import gc
import io
import json
import re
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING, Any

from app.answers.job import JobResponse, job_out
from app.answers.members import to_json, to_members
from app.answers.problem import Problem
from app.ids import JobState
from app.requests.campaign import read_campaign_request
from app.requests.json_reader import json_document, json_fields
from app.requests.plan import read_plan_request, write_plan_request
from app.store.job import Job, Listing
from app.store.packed import unzip
from app.work.plan import plan_and_pack, stored_table_file
from app.work.progress import report
from app.work.result import Part, Result
from planner.base.answer_members import Count, NotNegative, answer, member_names
from planner.base.csv_cells import csv_lines
from planner.base.errors import InvalidInput, Refusal
from planner.output.export.geojson import geojson_of
from planner.output.export.kml import kml_of
from planner.output.export.map_features import MapFeature, PlanMap
from planner.output.export.plan_map import target_features
from planner.planning.campaigns import CampaignRequest, FleetRequest
from planner.planning.campaigns.apart import carriers_apart, looks_found
from planner.planning.campaigns.chosen import ChosenLook
from planner.planning.campaigns.revision import PassResources
from planner.planning.campaigns.told import CampaignChoiceOut, FleetChoiceOut, told_of
from planner.world.frames.time_scales import utc_from_text, utc_text

if TYPE_CHECKING:
    from planner.planning.campaigns import ChosenPass

_CARRIED_OVER = ("platform", "orbit", "attitude", "slew")  # the last where it is as asked
_SESSION = re.compile(r"sessions\.(\d+)(\.|$)")
CSV = "text/csv"
_ARCHIVE = "application/zip"
_MAPS = {"application/geo+json": geojson_of, "application/vnd.google-earth.kml+xml": kml_of}
SUFFIXES = dict(zip((CSV, *_MAPS, _ARCHIVE), (".csv", ".geojson", ".kml", ".zip"), strict=True))


@dataclass(frozen=True, kw_only=True)
class LookLeftOut:
    """A look that planning refused, and why.

    target: id of the target, as the request gives it. E.g. `"Denver"`.
    because: the refusal's reason. E.g. `"alpha needs 2.500 s to slew but only 1.000 s remain"`.
    """

    target: str
    because: str


@dataclass(frozen=True, kw_only=True)
class CampaignPassOut:
    """Looks planned together: from rest at `start` to rest at `stop`.

    number: from 0, in order of time; of a revision after that of the passes that stay. E.g. `1`.
    plan: id of its plan, GET /v1/plans/{id}. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    state: state of the work on that plan.
    start: row 0 of its table; UTC. E.g. `"2015-02-27T17:32:46.000Z"`.
    stop: last row of its table; UTC. E.g. `"2015-02-27T17:38:08.000Z"`.
    resources: levels as it starts and as it stops; null without any.
    looks: those chosen for this pass.
    left_out: looks that could not be flown; a plan without them took the place of the one that was
    refused.
    problem: the reason why there is no plan; null when there is one or may be.
    """

    number: Count
    plan: str
    state: JobState
    start: str
    stop: str
    resources: PassResources | None
    looks: list[ChosenLook]
    left_out: list[LookLeftOut]
    problem: Problem | None


@dataclass(frozen=True, kw_only=True)
class FleetPassOut(CampaignPassOut):
    """Looks of one of several carriers planned together.

    carrier: id of the carrier that flies it. E.g. `"north"`.
    """

    carrier: str


@dataclass(frozen=True, kw_only=True)
class PlannedOut:
    """Progress of the passes' plans.

    done: passes with a verified plan.
    open: passes that wait or are being planned.
    refused: passes that can't be flown.
    failed: passes whose planning broke down.
    cancelled: passes that were given up on request.
    looks: in plans that are made.
    value: of the looks in plans that are made.
    """

    done: Count
    open: Count
    refused: Count
    failed: Count
    cancelled: Count
    looks: Count
    value: NotNegative


@answer
class CampaignResponse(JobResponse):
    """A campaign as it stands.

    choice: the looks chosen; null until they are.
    planned: progress of the passes' plans.
    passes: those with looks, in order of time.
    """

    choice: CampaignChoiceOut | FleetChoiceOut | None
    planned: PlannedOut
    passes: list[FleetPassOut | CampaignPassOut]


@dataclass(frozen=True, kw_only=True)
class CampaignDryRun:
    """The request is well formed; whether anything can be seen was not looked at.

    valid: always true; what isn't is refused.
    name: the request's.
    targets: number of targets.
    """

    valid: bool
    name: str
    targets: Count


def may_be_shared(body: bytes) -> bool:
    """Whether it names carriers, whose looks could be found apart."""
    return b'"carriers"' in body


def split_by_carrier(
    body: bytes,
    request: CampaignRequest | FleetRequest | None = None,
    found: Sequence[bytes] = (),
) -> Sequence[bytes]:
    """What each carrier is to find, as `carriers_apart`."""
    return carriers_apart(request or read_campaign_request(body), found)


def choose(
    body: bytes,
    request: CampaignRequest | FleetRequest | None = None,
    found: list[bytes] | None = None,
) -> Result:
    """Read unless that is done, choose and write down; raises a Refusal.

    found: by `find_looks`, of every carrier or none; emptied.
    """
    from app.work.cluster_prices import priced_by_workers
    from planner.planning.campaigns import choose_what_is_asked, priced_here

    request = request or read_campaign_request(body)
    document = json.loads(body)  # passes say orbit, platform and targets in its own words
    looks = looks_found(found or ())
    if found:
        found.clear()  # memory holds it once
        gc.freeze()  # all of it stays: looking for garbage there took a second each time
    priced_by = priced_by_workers if looks else priced_here
    requests, campaign = choose_what_is_asked(request, report, looks, priced_by)
    words = {"": document}
    asked = {target["id"]: target["target"] for target in document["targets"]}
    if isinstance(request, FleetRequest):
        words = {one["id"]: one for one in document["carriers"]}
    first = campaign.revision.next_number if campaign.revision else 0
    return Result(
        content=(zlib.compress(to_json(told_of(request, campaign))),),
        parts=tuple(
            _part(document, asked, words[flight.carrier], requests[flight.carrier], number, flight)
            for number, flight in enumerate(campaign.passes, first)
        ),
    )


def require_both(
    revises: str | None,
    frozen_until: str | None,
    fields: tuple[str, str] = ("query.revises", "query.frozen_until"),
    names: tuple[str, str] = ("`revises`", "`frozen_until`"),
) -> None:
    """Raises InvalidInput where one of the two is given alone."""
    if (revises is None) != (frozen_until is None):
        raise InvalidInput(
            f"must be given, too: {names[0]} names a campaign, and {names[1]} says which of its "
            "passes stay",
            field=fields[revises is not None],
        )


def revised(body: bytes, frozen_until: str | None, campaign: Mapping[str, Any]) -> bytes:
    """The request with what it revises: the looks of a campaign, by its answer.

    Looks that planning refused, or that were never planned, are none of them.
    """
    document = json_document(body)
    if not isinstance(document, dict):
        raise InvalidInput("the request must be a JSON object")
    if "revises" in document:
        raise InvalidInput(
            "is given already; leave it out of the request, or revise no other campaign",
            field="revises",
        )
    choice = campaign.get("choice", campaign)
    looks = [
        {name: look.get(name) for name in ("target", "part", "start", "stop", "value")}
        | {"carrier": one.get("carrier"), "plan": one["plan"]}
        | {"pass_start": one["start"], "pass_stop": one["stop"], "pass_number": one["number"]}
        | {"pass_resources": one.get("resources")}
        for one in campaign["passes"]
        if one["state"] == "done"
        for look in one["looks"]
    ]
    told = {(look["plan"], look["pass_start"]) for look in looks}
    frozen = [one for one in _frozen(choice) if (one["plan"], one["pass_start"]) not in told]
    document["revises"] = {"frozen_until": frozen_until, "looks": [*frozen, *looks]}
    return json.dumps(document).encode()


def _frozen(choice: Mapping[str, Any]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = (choice.get("revision") or {}).get("frozen", [])
    return found


def plans_that_stay(choice: Mapping[str, Any]) -> list[str]:
    """Ids of the plans of a revision's passes that stay."""
    return [*dict.fromkeys(look["plan"] for look in _frozen(choice) if look["plan"])]


def _part(
    document: Mapping[str, Any],
    asked: Mapping[str, Any],
    own: Mapping[str, Any],
    request: CampaignRequest,
    number: int,
    flight: "ChosenPass",
) -> Part:
    """asked: targets in their words, by id.  own: the carrier's, of a campaign of one all."""
    from planner.planning.campaigns import scenario_of

    scenario = scenario_of(request, flight, number)
    carried = _CARRIED_OVER if scenario.slew == request.slew else _CARRIED_OVER[:-1]
    words = {name: own[name] for name in carried if name in own}
    target_words = [
        asked[look.target] if look.path is None else json_fields(look.path) for look in flight.looks
    ]
    if any("terrain" in told for told in (document, *target_words)):
        target_words = []  # the heights are written out: no pass holds the grid
    looks = [to_members(look) for look in flight.looks]
    return Part(
        request=write_plan_request(scenario, words, target_words),
        name=scenario.name,
        listing=_listing(scenario.platform.name, looks),
        facts={
            "pass": number,
            **({"carrier": flight.carrier} if flight.carrier else {}),
            "start": utc_text(flight.start_utc),
            "stop": utc_text(flight.stop_utc),
            "looks": looks,
            "left_out": [],
            **({"resources": vars(flight.held)} if flight.held else {}),
        },
    )


def _listing(platform: str, looks: Sequence[Mapping[str, Any]]) -> Listing:
    """By the targets' ids, from the first look to the last."""
    return Listing(
        platform=platform,
        start_utc=utc_from_text(looks[0]["start"]),
        stop_utc=utc_from_text(looks[-1]["stop"]),
        targets=tuple(look["target"] for look in looks),
    )


def plan_pass(part: Part) -> tuple[Part, Result | Refusal]:
    """The pass, without what can't be flown of it, and its plan, or why it has none."""
    while True:
        try:
            return part, plan_and_pack(part.request)
        except Refusal as refusal:
            repaired = without_refused(part, refusal.field, refusal.detail)
            if repaired is None:
                return part, refusal
            part = repaired


def without_refused(part: Part, field: str | None, detail: str) -> Part | None:
    """The pass without the look that can't be flown, or else the one of least worth; of an imaging
    mode without any of its scans.

    None when no look would be left.  field: the refusal's.
    """
    looks = part.facts["looks"]
    row = int(named[1]) if (named := _SESSION.match(field or "")) else len(looks)
    if row >= len(looks):
        row = min(range(len(looks)), key=lambda number: looks[number]["value"])
    refused = looks[row]["target"]
    kept = [look for look in looks if look["target"] != refused]
    if not kept:
        return None
    request = json.loads(part.request)
    sessions = request["sessions"]
    request["sessions"] = [s for s in sessions if (s.get("of") or s.get("id")) != refused]
    left_out = {"target": refused, "because": detail}
    return replace(
        part,
        request=json.dumps(request).encode(),
        listing=_listing(part.listing.platform, kept),
        facts={**part.facts, "looks": kept, "left_out": [*part.facts["left_out"], left_out]},
    )


def campaign_json(job: Job, document: bytes | None, parts: Sequence[Job]) -> bytes:
    """A CampaignResponse as UTF-8 JSON.

    document: what was chosen, None before.  parts: all plans of its passes, the oldest first.
    """
    latest = {part.options["campaign"]["pass"]: part for part in parts}
    by_number = [latest[number] for number in sorted(latest)]
    return to_json(
        to_members(job_out(job))
        | {
            "choice": None if document is None else json.loads(unzip(document)),
            "planned": to_members(_planned_out(by_number)),
            "passes": [_pass_members(part) for part in by_number],
        }
    )


def _pass_members(part: Job) -> dict[str, Any]:
    facts, job = part.options["campaign"], to_members(job_out(part))
    told = {"resources": None, **facts, "number": facts["pass"], "plan": part.id}
    told |= {name: job[name] for name in ("state", "problem")}
    return {name: told[name] for name in FleetPassOut.__dataclass_fields__ if name in told}


def _planned_out(parts: Sequence[Job]) -> PlannedOut:
    states = [one.state for one in parts]
    made = [one.options["campaign"]["looks"] for one in parts if one.state == "done"]
    values = [look["value"] for looks in made for look in looks]
    return PlannedOut(
        done=states.count("done"),
        open=states.count("queued") + states.count("running"),
        refused=states.count("refused"),
        failed=states.count("failed"),
        cancelled=states.count("cancelled"),
        looks=len(values),
        value=sum(values, 0.0),
    )


@dataclass(frozen=True)
class MadePass:
    """A pass whose plan is made.

    facts: what its campaign says of it.
    """

    facts: Mapping[str, Any]
    plan: str
    request: bytes
    table_columns: bytes
    planned_utc: datetime

    @property
    def number(self) -> int:
        """From 1."""
        return int(self.facts["pass"]) + 1

    @property
    def of(self) -> dict[str, Any]:
        """By which looks are told apart: the pass, and its carrier where there are several."""
        carrier = {"carrier": self.facts["carrier"]} if "carrier" in self.facts else {}
        return {"pass": self.number, **carrier}


def campaign_file(media_type: str, body: bytes, passes: Sequence[MadePass]) -> bytes:
    """In one of `SUFFIXES`; body: the campaign's request."""
    if media_type == CSV:
        return _looks_csv(passes)
    if media_type == _ARCHIVE:
        return _archive(passes)
    request = read_campaign_request(body)
    notes = ("looks at targets in the sky have no place on a map",)
    features = tuple(_map_features(passes))
    return _MAPS[media_type](PlanMap(name=request.name, notes=notes, features=features))


def _looks_csv(passes: Sequence[MadePass]) -> bytes:
    return looks_csv({**one.of, **look} for one in passes for look in one.facts["looks"]).encode()


def looks_csv(looks: Iterable[Mapping[str, Any]]) -> str:
    """One line per look, with the number of its pass, and its carrier where there are several."""
    told = list(looks)
    own = ["pass", "carrier"] if any("carrier" in look for look in told) else ["pass"]
    names = [*own, *member_names(ChosenLook).values()]
    return csv_lines([names, *([look[name] for name in names] for look in told)])


def _map_features(passes: Sequence[MadePass]) -> Iterator[MapFeature]:
    for one in passes:
        sessions = read_plan_request(one.request).sessions
        for look, session in zip(one.facts["looks"], sessions, strict=False):  # then a rest
            members = dict(look)
            label, *times = (members.pop(name) for name in ("target", "start", "stop"))
            start_utc, stop_utc = map(utc_from_text, times)
            facts = {**one.of, "plan": one.plan, **members}
            yield from target_features(session.target, (start_utc, stop_utc), label, facts)


def _archive(passes: Sequence[MadePass]) -> bytes:
    """Of each pass its command table and its request, and the table of looks."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:

        def add(name: str, made_utc: datetime, file: bytes) -> None:
            entry = zipfile.ZipInfo(name, made_utc.timetuple()[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file)

        for one in passes:
            table = stored_table_file(one.request, one.table_columns, "csv", one.planned_utc)
            add(f"pass-{one.number}.csv", one.planned_utc, table)
            add(f"pass-{one.number}-request.json", one.planned_utc, one.request)
        add("looks.csv", max(one.planned_utc for one in passes), _looks_csv(passes))
    return content.getvalue()
