"""Flights of a plan: the request, the runs flown in parts, and the probabilities they tell."""

import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict, TypeAdapter

from app.answers.job import JobResponse, job_out
from app.answers.members import to_json, to_members
from app.requests.json_reader import JsonReader
from app.store.job import Job
from app.store.packed import PackedColumns, pack, unpack, unzip
from app.work.plan import require_verified_table, stored_plan
from app.work.progress import report
from app.work.result import Part, Result
from planner.base.answer_members import answer
from planner.base.errors import InvalidInput
from planner.inflight.flights.outcomes import RunOutcomes
from planner.inflight.flights.request import FlightsRequest
from planner.inflight.flights.summary import PlanFlights, joined, summarise
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from planner.inflight.flights.scene import SessionScene

FLOWN_MAX_S = 1e6  # of flight in all runs together: some ten minutes of a core
_PART_S = 1e4  # of flight in one part: some five seconds
FLIGHTS_READER = JsonReader(FlightsRequest)


@answer
class FlightsResponse(PlanFlights, JobResponse):
    """Flights of a plan as they stand."""


def flights_found(
    head: Mapping[str, Any], parts: "Sequence[tuple[int, list[RunOutcomes]]]"
) -> dict[str, Any]:
    """The members of PlanFlights.

    head: of no run, as it is told.  parts: each from which run on, and its outcomes by session; in
    any order.
    """
    by_part = [sessions for _, sessions in sorted(parts, key=lambda part: part[0])]
    if not by_part:
        return dict(head)
    runs = [joined(parts) for parts in zip(*by_part, strict=True)]
    found, warnings = summarise(runs), [*head["warnings"]]
    told = to_members(found)
    for number, (one, flown) in enumerate(zip(head["sessions"], found.sessions, strict=True)):
        told["sessions"][number] = one | told["sessions"][number]
        warnings += flown.doubts(one["session"], one["budget_probability_in_frame"])
    return {**head, **told, "flown": len(runs[0].holds), "warnings": warnings}


def flights_json(job: Job, document: bytes | None, parts: Sequence[Any]) -> bytes:
    """A FlightsResponse as UTF-8 JSON; document: of a head, None before there is one."""
    if document is None:
        asked = {name: job.options[name] for name in ("runs", "seed")}
        head = to_members(PlanFlights(plan=job.plan_id or "", **asked))
    else:
        head = json.loads(unzip(document))
    return to_json(to_members(job_out(job)) | flights_found(head, parts))


@dataclass(frozen=True, kw_only=True)
class PlanToFly:
    """What is flown, as a child is sent it, and by whom it was planned.

    asked: the request for flights.  request: the plan's.  table_columns: its stored table.
    first, count: of the runs of a part.
    """

    __pydantic_config__ = ConfigDict(ser_json_bytes="base64", val_json_bytes="base64")

    plan_id: str
    asked: bytes
    request: bytes
    table_columns: bytes
    first: int = 0
    count: int = 0

    def to_bytes(self, first: int = 0, count: int = 0) -> bytes:
        return to_json(replace(self, first=first, count=count))


PLAN_TO_FLY = TypeAdapter(PlanToFly)


def prepare_flights(body: bytes, _: object = None) -> Result:
    """Fly it once as planned, and split the runs; raises a Refusal."""
    from planner.inflight.flights.nominal import flights_as_planned
    from planner.inflight.flights.scene import session_scenes

    report("as planned")
    what = PLAN_TO_FLY.validate_json(body)
    plan = _plan(what)
    scenes = session_scenes(plan)
    asked = FLIGHTS_READER.read(what.asked)
    counts = _runs_by_part(scenes, asked.runs)
    head = flights_as_planned(plan, scenes, what.plan_id, asked)
    firsts = [sum(counts[:number]) for number in range(len(counts))]
    return Result(
        content=(zlib.compress(to_json(head)),),
        parts=tuple(
            Part(
                request=what.to_bytes(first=first, count=count),
                name=f"{asked.name} runs from {first}",
            )
            for first, count in zip(firsts, counts, strict=True)
        ),
    )


def fly_part(body: bytes, _: object = None) -> Result:
    from planner.inflight.flights.runs import fly_runs
    from planner.inflight.flights.scene import session_scenes

    what = PLAN_TO_FLY.validate_json(body)
    plan = _plan(what)
    asked = FLIGHTS_READER.read(what.asked)
    outcomes = fly_runs(
        session_scenes(plan),
        asked.seed,
        what.first,
        what.count,
        lambda done: report("runs", done, what.count),
    )
    return Result(content=(packed_outcomes(outcomes, what.first),))


def packed_outcomes(sessions: Sequence[RunOutcomes], first: int) -> bytes:
    return pack(
        PackedColumns(
            columns={
                f"{number}.{name}": values
                for number, runs in enumerate(sessions)
                for name, values in runs.columns.items()
            },
            facts={"first": first, "sessions": len(sessions), "causes": sessions[0].causes},
        )
    )


def unpacked_outcomes(packed: bytes) -> tuple[int, list[RunOutcomes]]:
    """The first run's number, and the outcomes by session."""
    part = unpack(packed)
    sessions = []
    for number in range(part.facts["sessions"]):
        columns: dict[str, Any] = {
            name.partition(".")[2]: column
            for name, column in part.columns.items()
            if name.startswith(f"{number}.")
        }
        columns |= {name: columns[name] > 0.5 for name in ("holds", "sharp")}
        sessions.append(RunOutcomes(causes=tuple(part.facts["causes"]), **columns))
    return part.facts["first"], sessions


def _plan(what: PlanToFly) -> FlightPlan:
    packed = unpack(what.table_columns)
    require_verified_table(packed)
    return stored_plan(what.request, packed)


def _runs_by_part(scenes: Sequence["SessionScene"], runs: int) -> list[int]:
    """Of even numbers but for the last; raises InvalidInput."""
    flown_s = sum(float(scene.table.t_s[-1]) for scene in scenes)
    if runs > (most := int(FLOWN_MAX_S / flown_s)):
        raise InvalidInput(
            f"{runs} runs of {flown_s:.0f} s each are {runs * flown_s:.3g} s of flight, and "
            f"{FLOWN_MAX_S:.0e} s may be asked for at a time: ask for {most} runs at most",
            field="runs",
        )
    size = 2 * max(int(_PART_S / flown_s / 2.0), 1)
    whole, rest = divmod(runs, size)
    return [size] * whole + [rest] * (rest > 0)
