"""Flights of a plan: the request, the runs flown in parts, and the probabilities they tell."""

import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import ConfigDict, Field, SerializeAsAny, TypeAdapter

from app.answers.job import JobResponse, job_members
from app.answers.members import to_json, to_members
from app.requests.json_reader import JsonReader
from app.store.job import Job
from app.store.packed import PackedColumns, pack, unpack, unzip
from app.work.plan import require_verified_table, stored_plan
from app.work.progress import report
from app.work.result import Part, Result
from planner.base.answer_members import Count, Member, Share, answer
from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.inflight.flights.contributors import Contributor
from planner.inflight.flights.outcomes import NominalSession, RunOutcomes
from planner.inflight.flights.request import FlightsRequest
from planner.inflight.flights.summary import Histogram, joined, summarise
from planner.inflight.simulation.gyros.report import GyroSteadiness
from planner.world.frames.time_scales import utc_text
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from planner.inflight.flights.scene import SessionScene
    from planner.inflight.flights.summary import PlanFlights, SessionFlights

T = TypeVar("T")
FLOWN_MAX_S = 1e6  # of flight in all runs together: some ten minutes of a core
_PART_S = 1e4  # of flight in one part: some five seconds
FLIGHTS_READER = JsonReader(FlightsRequest)
read_flights_request = FLIGHTS_READER.read
_End = Annotated[float, Member(least=0.0, greatest=1.0, decimals=6)]  # of an interval
_Quantiles = Annotated[Array, Member("", 0.0, decimals=6)]


@dataclass(frozen=True, kw_only=True)
class SessionFlightsOut:
    """A session under errors; null where no run is flown yet.

    session: its number in the plan.
    label: its name in lists.
    budget_probability_in_frame: the same probability by the plan's linear budget.
    probability_in_frame: share of the runs in which all frames hold the target.
    in_frame_interval: within which that probability lies with 95 % confidence (Wilson).
    probability_sharp: share of the runs in which all frames hold it smeared over less than a pixel.
    sharp_interval: within which that probability lies with 95 % confidence (Wilson).
    frames_held: share of all runs' frames that hold the target.
    frames_sharp: share of all runs' frames that hold it smeared over less than a pixel.
    smear_px: median of a run's frames; in 5, 50 and 95 % of the runs it is less. [pixels]
    miss_m: largest distance of the target from the boresight in a run, across the line of sight; in
    5, 50 and 95 % of the runs it is less; null for a target in the sky. [m]
    misses: the same as an angle, as a histogram.
    contributors: causes of the errors, the largest first.
    gyros: of a body with gyros, their steadiness in the worst of the runs; null without.
    nominal: the session flown as planned.
    """

    session: Count
    label: str
    budget_probability_in_frame: Share
    probability_in_frame: Share | None
    in_frame_interval: tuple[_End, ...] | None
    probability_sharp: Share | None
    sharp_interval: tuple[_End, ...] | None
    frames_held: Share | None
    frames_sharp: Share | None
    smear_px: _Quantiles | None
    miss_m: _Quantiles | None
    misses: Histogram | None
    contributors: list[Contributor]
    gyros: GyroSteadiness | None
    nominal: SerializeAsAny[NominalSession]  # as it was told and stored


@dataclass(frozen=True, kw_only=True)
class FlightsFound:
    """What the runs flown so far say of the plan.

    plan: id of the plan that is flown.
    runs: number of flights that were asked for.
    seed: of their errors.
    flown: number of runs flown so far; all numbers are of these.
    epoch: of `t_s`, the plan's row 0; UTC.
    probability_in_frame: share of the runs in which every frame of every session holds its target;
    null before any is flown.
    in_frame_interval: within which that probability lies with 95 % confidence (Wilson).
    probability_sharp: share of the runs in which each of these frames is smeared over less than a
    pixel, too; null before any run is flown.
    sharp_interval: within which that probability lies with 95 % confidence (Wilson).
    contributors: causes of the errors, the largest first; all sessions together.
    sessions: those that look at a target.
    warnings: cautions, such as a linear budget that doesn't agree with the flights. E.g.
    `["session 0: the budget tells a probability of 0.950, ..."]`.
    """

    plan: str
    runs: Annotated[int, Field(ge=2)]
    seed: Count
    flown: Count
    epoch: str | None
    probability_in_frame: Share | None
    in_frame_interval: tuple[_End, ...] | None
    probability_sharp: Share | None
    sharp_interval: tuple[_End, ...] | None
    contributors: list[Contributor]
    sessions: list[SessionFlightsOut]
    warnings: list[str]


@answer
class FlightsResponse(FlightsFound, JobResponse):
    """Flights of a plan as they stand."""


def flights_found(
    head: Mapping[str, Any], parts: "Sequence[tuple[int, list[RunOutcomes]]]"
) -> FlightsFound:
    """head: of no run, as it is told.  parts: each from which run on, and its outcomes by session;
    in any order."""
    by_part = [sessions for _, sessions in sorted(parts, key=lambda part: part[0])]
    sessions, told = [_filled(SessionFlightsOut, one) for one in head["sessions"]], dict(head)
    if by_part:
        found = summarise([joined(runs) for runs in zip(*by_part, strict=True)])
        both = [*zip(sessions, found.sessions, strict=True)]
        sessions = [
            replace(
                one,
                **_told_of(flown),
                frames_held=flown.held_share,
                frames_sharp=flown.sharp_share,
                smear_px=flown.smear_px,
                miss_m=flown.miss_m,
                misses=flown.miss_rad,
                gyros=flown.gyros,
            )
            for one, flown in both
        ]
        doubts = [text for one, flown in both for text in _doubts(one, flown)]
        told |= {**_told_of(found), "flown": found.in_frame.runs}
        told["warnings"] = [*told.get("warnings", ()), *doubts]
    return _filled(FlightsFound, told | {"sessions": sessions})


def flights_json(job: Job, document: bytes | None, parts: Sequence[Any]) -> bytes:
    """A FlightsResponse as UTF-8 JSON; document: of a head, None before there is one."""
    if document is None:
        head = {"plan": job.plan_id or "", "sessions": [], **job.options}
    else:
        head = json.loads(unzip(document))
    return to_json(FlightsResponse(**job_members(job) | vars(flights_found(head, parts))))


def _filled(kind: type[T], told: Mapping[str, Any]) -> T:
    """With what is known of it, which is nothing of flights before any."""
    told = {"flown": 0, "contributors": [], "warnings": [], **told}
    names = kind.__dataclass_fields__  # type: ignore[attr-defined]
    return kind(**{name: told.get(name) for name in names})


def _told_of(found: "PlanFlights | SessionFlights") -> dict[str, Any]:
    return {
        "probability_in_frame": found.in_frame.value,
        "in_frame_interval": found.in_frame.interval(),
        "probability_sharp": found.sharp.value,
        "sharp_interval": found.sharp.interval(),
        "contributors": found.contributors,
    }


def _doubts(told: SessionFlightsOut, flown: "SessionFlights") -> Iterator[str]:
    if flown.in_frame.differs_from(told.budget_probability_in_frame):
        low, high = flown.in_frame.interval()
        yield (
            f"session {told.session + 1}: the plan's budget tells a probability of "
            f"{told.budget_probability_in_frame:.3f} that the target stays in the frame, the "
            f"flights {flown.in_frame.value:.3f} ({low:.3f} to {high:.3f}): more than chance; "
            "the budget is linear and knows no drives but their resolution: trust the flights"
        )


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
    from planner.inflight.flights.scene import session_scenes

    report("as planned")
    what = PLAN_TO_FLY.validate_json(body)
    plan = _plan(what)
    scenes = session_scenes(plan)
    asked = read_flights_request(what.asked)
    counts = _runs_by_part(scenes, asked.runs)
    head = flights_head(plan, scenes, what)
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


def flights_head(
    plan: FlightPlan, scenes: Sequence["SessionScene"], what: PlanToFly
) -> FlightsFound:
    """What there is to tell before any disturbed run."""
    from planner.inflight.flights.nominal import nominal_session
    from planner.planning.sessions.platforms.registry import mover_of

    asked, table, sessions, warnings = read_flights_request(what.asked), plan.table, [], []
    for scene in scenes:
        budget = mover_of(plan.scenario).budget(scene.ephemeris, table, scene.number)
        assert budget is not None  # of a target that can be seen
        nominal = nominal_session(scene, asked.moving_object)
        told = {
            "session": scene.number,
            "label": plan.scenario.sessions[scene.number].label,
            "budget_probability_in_frame": budget.probability_in_frame,
            "nominal": to_members(nominal),
        }
        sessions.append(_filled(SessionFlightsOut, told))
        saturated = zip(plan.scenario.platform.dof_names, nominal.saturated_s, strict=True)
        warnings += [
            f"session {scene.number + 1}: flown as planned, the drive of {axis} gives all its "
            f"torque for {saturated_s:.1f} s and falls behind its table; raise its drive's "
            "torque_reserve, or lower its friction or cable_tension_deg_s2, if the platform's are "
            "other than assumed"
            for axis, saturated_s in saturated
            if saturated_s > 0.0
        ]
    epoch = utc_text(table.epoch_utc, 1)
    told = {"plan": what.plan_id, "runs": asked.runs, "seed": asked.seed, "epoch": epoch}
    return _filled(FlightsFound, told | {"sessions": sessions, "warnings": warnings})


def fly_part(body: bytes, _: object = None) -> Result:
    from planner.inflight.flights.runs import fly_runs
    from planner.inflight.flights.scene import session_scenes

    what = PLAN_TO_FLY.validate_json(body)
    plan = _plan(what)
    asked = read_flights_request(what.asked)
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
