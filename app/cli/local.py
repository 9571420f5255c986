"""Plans and all else made in this process, by what a service's children run."""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

from app.answers.members import new_head, provenance, to_json, whole_answer
from app.answers.problem import problem_of
from app.cli.planner import Members, OnProgress, ParsedAnswer
from app.cli.progress_bar import told_progress
from app.ids import new_id
from app.requests.json_reader import json_document
from app.requests.plan import read_plan_request
from app.store.packed import pack, unpack, unzip
from app.work.plan import (
    packed_plan,
    plan_and_pack,
    segment_of,
    stored_plan,
    stored_table_file,
    stored_table_json,
    try_plan,
)
from app.work.progress import Progress, report, report_through
from app.work.result import Part, Result
from planner.base.errors import FieldError, InvalidInput, InvalidRequest, Refusal
from planner.world.frames.time_scales import utc_from_text

if TYPE_CHECKING:
    from app.answers.flights import FlightsFound
    from app.requests.telemetry import ComparisonRequest
    from planner.inflight.telemetry.compare import Comparison


@dataclass(frozen=True)
class Made:
    """What was made, under an id of its own; text: makes the whole answer, as a service gives it.

    passed: a plan's verification.
    """

    id: str
    text: Callable[[], bytes]
    passed: bool = True

    @cached_property
    def members(self) -> Members:
        """Of the whole answer."""
        return ParsedAnswer(self.text())


@contextmanager
def _reporting(progress: OnProgress) -> Iterator[None]:
    """What the work inside reports of itself is told."""
    report_through(progress)
    try:
        yield
    finally:
        report_through(_ignore)


def _ignore(_: Progress) -> None:
    pass


class Local:
    """Each plan is kept for as long as the command runs."""

    def __init__(self) -> None:
        self._stored: dict[str, tuple[bytes, bytes]] = {}  # request and packed table, by id
        self._made: dict[str, Made] = {}
        self._compared: tuple[Members, tuple[ComparisonRequest, Comparison]] | None = None

    @cached_property
    def spacecraft(self) -> "LocalSpacecraft":
        """The same for the imaging spacecraft."""
        return LocalSpacecraft()

    def plan(self, request: bytes, *, progress: OnProgress = _ignore) -> Made:
        """Slews and tracks for every session, as a verified command table."""
        with _reporting(progress):
            return self._keep(request, plan_and_pack(request), stored_table_json)

    def _keep(self, request: bytes, new: Result, table_json: Callable[[bytes], bytes]) -> Made:
        head = new_head(new.state)
        self._stored[head.id] = (request, new.table_columns)

        def text() -> bytes:
            return whole_answer(head, unzip(new.document), table_json(new.table_columns))

        made = self._made[head.id] = Made(head.id, text, new.state == "done")
        return made

    def get(self, plan_id: str) -> Made:
        """A plan made before."""
        return self._made[plan_id]

    def request(self, plan_id: str) -> Members:
        """What a plan was asked for by."""
        return ParsedAnswer(self._stored[plan_id][0])

    def named(self, plan: str, request: Path | None) -> str:
        """The id of a plan in a file: planned anew from a request, or as an answer has it."""
        body = Path(plan).read_bytes()
        document = json_document(body)
        if not isinstance(document, dict) or "table" not in document:
            with told_progress("planning") as tell:
                return self.plan(body, progress=tell).id
        if request is None:
            raise InvalidInput(
                "PLAN_OR_REQUEST is a plan's answer, which doesn't hold the platform: name its "
                "request, too",
                field="--request",
            )
        return self._take(document, request.read_bytes())

    def _take(self, plan: Members, request: bytes) -> str:
        import numpy as np

        from planner.base.commands import CommandTable
        from planner.world.plan import FlightPlan

        scenario = read_plan_request(request)
        names, table = scenario.platform.axis_names, plan["table"]
        try:
            angle_rad, rate_rad_s = (
                np.radians(np.array([table[f"{name}{kind}"] for name in names], dtype=float).T)
                for kind in ("_deg", "_rate_deg_s")
            )
            flown = FlightPlan(
                scenario=scenario,
                segments=tuple(
                    segment_of(*(one[name] for name in ("kind", "session", "start", "stop")))
                    for one in plan["segments"]
                ),
                table=CommandTable(
                    epoch_utc=utc_from_text(table["epoch"]),
                    axis_names=names,
                    angle_rad=angle_rad,
                    rate_rad_s=rate_rad_s,
                ),
            )
        except (KeyError, TypeError, ValueError) as fault:
            detail = f"is no whole answer of a plan of this request: {fault}"
            raise InvalidRequest(FieldError(field="PLAN_OR_REQUEST", detail=detail)) from None
        plan_id = str(plan.get("id") or new_id())
        self._stored[plan_id] = (request, pack(packed_plan(flown)))
        return plan_id

    def check(self, request: bytes) -> Members:
        """Whether a request for a plan flies, and what to know before."""
        asked = read_plan_request(request)
        return ParsedAnswer(try_plan(asked, provenance(datetime.now(UTC), request)))

    def export(self, plan_id: str, format_name: str) -> bytes:
        """The table as a file; a picture, pdf too, though its verification failed."""
        from planner.output.export.figure import draw_plan
        from planner.output.export.figure_parts import FORMATS

        request, table_columns = self._stored[plan_id]
        now_utc = datetime.now(UTC)
        if format_name in FORMATS:
            return draw_plan(stored_plan(request, unpack(table_columns)), format_name, now_utc)
        return stored_table_file(request, table_columns, format_name, now_utc)

    def fly(self, plan_id: str, request: bytes, *, progress: OnProgress = _ignore) -> Made:
        """A plan flown many times with errors drawn anew."""
        from app.work.flights import PlanToFly, prepare_flights

        of_plan, table_columns = self._stored[plan_id]
        what = PlanToFly(
            plan_id=plan_id, asked=request, request=of_plan, table_columns=table_columns
        )
        with _reporting(progress):
            flown = to_json(_fly_parts(prepare_flights(what.to_bytes())))
        return Made("", lambda: flown)

    def opportunities(self, request: bytes) -> Made:
        """When each target can be seen."""
        from app.answers.opportunities import whole_opportunities
        from app.requests.opportunities import read_opportunity_request
        from app.work.campaign import answer_opportunities

        origin = provenance(datetime.now(UTC), request)
        found, new = answer_opportunities(read_opportunity_request(request), origin), new_id()
        return Made(new, lambda: whole_opportunities(new, found))

    def campaign(
        self, request: bytes, *, progress: OnProgress = _ignore, plans_too: bool = True
    ) -> Made:
        """Many targets over days: chosen, ordered and, if wanted, planned pass by pass."""
        from app.work.campaign import choose

        passes = []
        with _reporting(progress):
            chosen = choose(request)
        for number, part in enumerate(chosen.parts):
            progress(Progress(stage="plans", done=number, of=len(chosen.parts)))
            passes.append(self._plan_pass(part) if plans_too else _pass(part))
        told = {"choice": json.loads(unzip(chosen.document)), "passes": passes}
        return Made("", lambda: json.dumps(told).encode())

    def _plan_pass(self, part: Part) -> Members:
        """The pass, without what can't be flown of it."""
        from app.work.campaign import without_refused

        while True:
            try:
                made = self.plan(part.request)
                return _pass(part, "done" if made.passed else "failed", plan=made.id)
            except Refusal as refusal:
                repaired = without_refused(part, refusal.field, refusal.detail)
                if repaired is None:
                    return _pass(part, "refused", problem=problem_of(refusal))
                part = repaired

    def estimate_vertical(self, images: Sequence[bytes], request: bytes) -> Members:
        """The nadir in body axes from one image file per camera."""
        from app.requests.horizon import read_estimate_request
        from app.work.horizon import estimate_json

        origin = provenance(datetime.now(UTC), request, *images)
        return ParsedAnswer(estimate_json(read_estimate_request(request), images, origin))

    def compare(self, request: Members, csv: bytes) -> Members:
        """What flew beside a plan: its samples in a CSV file."""
        from app.work.telemetry import answer_json

        now_utc = datetime.now(UTC)
        asked, found = self._comparison(request, csv)
        return ParsedAnswer(answer_json(found, asked, asked.plan, provenance(now_utc, csv)))

    def draw_comparison(self, request: Members, csv: bytes, format_name: str) -> bytes:
        """The same as a picture: png, svg or pdf."""
        from planner.inflight.telemetry.figure import draw_comparison

        _, found = self._comparison(request, csv)
        return draw_comparison(found, format_name, datetime.now(UTC))

    def _comparison(self, request: Members, csv: bytes) -> "tuple[ComparisonRequest, Comparison]":
        """Made once for numbers and picture, which ask for it one after the other."""
        from app.requests.telemetry import read_comparison_head
        from app.work.telemetry import SentTelemetry, compare_sent

        if self._compared is None or self._compared[0] is not request:
            asked = read_comparison_head(json.dumps(request).encode())
            of_plan, table_columns = self._stored[asked.plan]
            plan = stored_plan(of_plan, unpack(table_columns))
            found = compare_sent(plan, SentTelemetry(request=asked, samples=csv))
            self._compared = (request, (asked, found))
        return self._compared[1]


class LocalSpacecraft(Local):
    """The same of the imaging spacecraft."""

    def plan(self, request: bytes, *, progress: OnProgress = _ignore) -> Made:
        """A session, as a verified attitude table."""
        from app.work.spacecraft import plan_and_pack_session, stored_session_json

        with _reporting(progress):
            return self._keep(request, plan_and_pack_session(request), stored_session_json)

    def check(self, request: bytes) -> Members:
        """Whether a session flies, and what to know before."""
        from app.requests.spacecraft import read_spacecraft_request
        from app.work.spacecraft import try_session

        origin = provenance(datetime.now(UTC), request)
        return ParsedAnswer(try_session(read_spacecraft_request(request), origin))

    def export(self, plan_id: str, format_name: str) -> bytes:
        """The table as a file."""
        from app.work.spacecraft import stored_session_file

        return stored_session_file(*self._stored[plan_id], format_name, datetime.now(UTC))


def _pass(
    part: Part, state: str = "queued", plan: str = "", problem: Members | None = None
) -> Members:
    """As a campaign's answer tells it."""
    facts = {name: part.facts[name] for name in ("start", "stop", "looks", "left_out")}
    return {**facts, "number": part.facts["pass"], "state": state, "plan": plan, "problem": problem}


def _fly_parts(new: Result) -> "FlightsFound":
    """On all processors, each part in a child."""
    from app.answers.flights import FlightsHead, flights_found
    from app.answers.members import from_store
    from app.jobs.kinds import RUNS
    from app.jobs.worker_process import Stop, run_in_worker
    from app.work.flights import fly_part, unpacked_outcomes

    head = from_store(FlightsHead, json.loads(unzip(new.document)))
    done, stops = [0] * len(new.parts), [Stop() for _ in new.parts]

    def tell(part: int, now: Progress) -> None:
        done[part] = now.done or 0
        report("runs", sum(done), head.runs)

    def fly(part: int) -> Result:
        body, told = new.parts[part].request, partial(tell, part)
        return run_in_worker(RUNS.bounds, fly_part, body, stop=stops[part], on_progress=told)

    with ThreadPoolExecutor(os.cpu_count()) as threads:
        try:
            parts = threads.map(fly, range(len(stops)))
            return flights_found(head, [unpacked_outcomes(part.document) for part in parts])
        finally:
            for stop in stops:
                stop.request()
