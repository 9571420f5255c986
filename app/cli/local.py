"""All calls answered in this process, and what the command alone asks for."""

import json
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from http import HTTPStatus
from pathlib import Path
from threading import Lock
from typing import Any, ClassVar

from app.cli.planner import Members, OnProgress, told_progress
from app.here import Desk, Kept, reporting, told_pass
from app.ids import new_id
from app.requests.json_reader import json_document
from app.requests.plan import read_plan_request
from app.store.packed import pack, unpack, unzip
from app.work.plan import packed_plan, segment_of, stored_plan
from app.work.progress import Progress, report
from app.work.result import Part, Result
from planner.base.errors import FieldError, InvalidInput, InvalidRequest
from planner.world.frames.time_scales import utc_from_text
from slewtrack.client.asking import Ask, Reply
from slewtrack.client.calls import Calls, Exchange


class Local(Calls):
    """Each plan is kept for as long as the command runs; refusals are raised as they are."""

    def __init__(self) -> None:
        self._desk = _CommandsDesk()
        super().__init__(Exchange(self._reply, lambda error: error, patience_s=0.0))

    async def _reply(self, ask: Ask) -> Reply:
        return Reply(status=HTTPStatus.OK, headers={}, body=self._desk.answer(ask))

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
        plan_id = str(document.get("id") or new_id())
        asked = request.read_bytes()
        self._desk.put(plan_id, Kept(lambda _: body, True, asked, _packed(document, asked)))
        return plan_id


class _CommandsDesk(Desk):
    kept_max: ClassVar[int] = sys.maxsize

    def table_file(self, made: Kept, format_name: str) -> bytes:
        """A picture, pdf too, though its verification failed."""
        from planner.output.export.figure import draw_plan
        from planner.output.export.figure_parts import FORMATS

        if format_name not in FORMATS:
            return super().table_file(made, format_name)
        plan = stored_plan(made.request, unpack(made.table_columns))
        return draw_plan(plan, format_name, datetime.now(UTC))

    def choose(self, body: bytes) -> Result:
        return choose_here(body)

    def fly(self, parts: Sequence[Part], runs: int) -> Sequence[bytes]:
        """On all processors, each part in a child."""
        from app.jobs.kinds import RUNS
        from app.jobs.worker_process import Stop, run_in_worker
        from app.work.flights import fly_part

        done, stops, one_at_a_time = [0] * len(parts), [Stop() for _ in parts], Lock()

        def tell(part: int, now: Progress) -> None:
            with one_at_a_time:
                done[part] = now.done or 0
                report("runs", sum(done), runs)

        def fly(part: int) -> bytes:
            body, told = parts[part].request, partial(tell, part)
            bounds, stop = RUNS.bounds, stops[part]
            return run_in_worker(bounds, fly_part, body, stop=stop, on_progress=told).document

        with ThreadPoolExecutor(os.cpu_count()) as threads:
            try:
                return [*threads.map(fly, range(len(stops)))]
            finally:
                for stop in stops:
                    stop.request()


def choose_here(body: bytes) -> Result:
    """A campaign, of carriers with much to find on all processors, each in a child."""
    from app.jobs.kinds import CAMPAIGN, CARRIERS
    from app.jobs.shares import Places, Sharing
    from app.jobs.worker_process import Stop, Task, run_here
    from app.requests.campaign import read_campaign_request
    from app.work.campaign import choose
    from planner.planning.campaigns.apart import carriers_apart

    request = read_campaign_request(body)
    places = Places(take=lambda: True, leave=lambda: None, most=(os.cpu_count() or 1) - 1)
    task = Task(job_id="", bounds=CAMPAIGN.bounds, work=choose, arguments=())
    sharing = Sharing(run_task=run_here, places=places, attempts=1)

    def tell(progress: Progress) -> None:
        report(progress.stage, progress.done, progress.of)

    made: list[bytes] = []
    while given := carriers_apart(request, made):
        made = sharing.make(CARRIERS, given, task, Stop(), tell)
    return choose(body, request, made)


def chosen(request: bytes, progress: OnProgress) -> dict[str, Any]:
    """A campaign's choice and passes, without their plans."""
    with reporting(progress):
        made = choose_here(request)
    return {"choice": json.loads(unzip(made.document)), "passes": [*map(told_pass, made.parts)]}


def _packed(plan: Members, request: bytes) -> bytes:
    """The table of a plan's answer as it is kept; raises InvalidRequest."""
    from planner.base.commands import table_of
    from planner.world.plan import FlightPlan

    scenario, table = read_plan_request(request), plan["table"]
    try:
        flown = FlightPlan(
            scenario=scenario,
            segments=tuple(
                segment_of(*(one[name] for name in ("kind", "session", "start", "stop")))
                for one in plan["segments"]
            ),
            table=table_of(utc_from_text(table["epoch"]), scenario.platform.channels, table),
        )
    except (KeyError, TypeError, ValueError) as fault:
        detail = f"is no whole answer of a plan of this request: {fault}"
        raise InvalidRequest(FieldError(field="PLAN_OR_REQUEST", detail=detail)) from None
    return pack(packed_plan(flown))
