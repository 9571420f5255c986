"""The answer about flights of a plan: probabilities, contributors, and the flight as planned."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, SerializeAsAny

from app.answers.job import JobResponse, job_members
from app.answers.members import from_store, to_json
from app.store.job import Job
from app.store.packed import unzip
from planner.base.answer_members import Count, Member, Share, answer
from planner.base.arrays import Array
from planner.inflight.flights.contributors import Contributor
from planner.inflight.flights.outcomes import NominalSession
from planner.inflight.flights.summary import Histogram, joined, summarise
from planner.inflight.simulation.gyros.report import GyroSteadiness

if TYPE_CHECKING:
    from planner.inflight.flights.outcomes import RunOutcomes
    from planner.inflight.flights.summary import PlanFlights, SessionFlights

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


@dataclass(frozen=True, kw_only=True)
class SessionHead:
    """What is known of a session before any disturbed run.

    nominal: a NominalSession, as told.  saturated_s: by axis, how long its drive gives all it has
    when flown as planned.
    """

    session: int
    label: str
    budget_probability_in_frame: float
    nominal: Any
    saturated_s: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class FlightsHead:
    """What is known of all runs before any."""

    plan: str
    runs: int
    seed: int
    epoch: str | None
    sessions: list[SessionHead]


def flights_found(
    head: FlightsHead, parts: "Sequence[tuple[int, list[RunOutcomes]]]"
) -> FlightsFound:
    """parts: each from which run on, and its outcomes by session; in any order."""
    by_part = [sessions for _, sessions in sorted(parts, key=lambda part: part[0])]
    found = summarise([joined(runs) for runs in zip(*by_part, strict=True)]) if by_part else None
    sessions = [
        _session_out(told, found.sessions[number] if found else None)
        for number, told in enumerate(head.sessions)
    ]
    return FlightsFound(
        plan=head.plan,
        runs=head.runs,
        seed=head.seed,
        flown=found.in_frame.runs if found else 0,
        epoch=head.epoch,
        **_told_of(found),
        sessions=sessions,
        warnings=_warnings(head, found),
    )


def flights_json(job: Job, document: bytes | None, parts: Sequence[Any]) -> bytes:
    """A FlightsResponse as UTF-8 JSON; document: a FlightsHead, None before there is one."""
    if document is None:
        asked = {name: job.options[name] for name in ("runs", "seed")}
        head = FlightsHead(plan=job.plan_id or "", epoch=None, sessions=[], **asked)
    else:
        head = from_store(FlightsHead, json.loads(unzip(document)))
    return to_json(FlightsResponse(**job_members(job) | vars(flights_found(head, parts))))


def _told_of(found: "PlanFlights | SessionFlights | None") -> dict[str, Any]:
    if found is None:
        names = ("probability_in_frame", "in_frame_interval", "probability_sharp", "sharp_interval")
        return {**dict.fromkeys(names), "contributors": []}
    return {
        "probability_in_frame": found.in_frame.value,
        "in_frame_interval": found.in_frame.interval(),
        "probability_sharp": found.sharp.value,
        "sharp_interval": found.sharp.interval(),
        "contributors": found.contributors,
    }


def _session_out(told: SessionHead, flown: "SessionFlights | None") -> SessionFlightsOut:
    shown: dict[str, Any] = {it: getattr(flown, it, None) for it in ("smear_px", "miss_m", "gyros")}
    return SessionFlightsOut(
        session=told.session,
        label=told.label,
        budget_probability_in_frame=told.budget_probability_in_frame,
        **_told_of(flown),
        frames_held=flown.held_share if flown else None,
        frames_sharp=flown.sharp_share if flown else None,
        misses=flown.miss_rad if flown else None,
        **shown,
        nominal=told.nominal,
    )


def _warnings(head: FlightsHead, found: "PlanFlights | None") -> list[str]:
    warnings = [
        f"session {told.session + 1}: flown as planned, the drive of {axis} gives all its torque "
        f"for {saturated_s:.1f} s and falls behind its table; raise its drive's torque_reserve, or "
        "lower its friction or cable_tension_deg_s2, if the platform's are other than assumed"
        for told in head.sessions
        for axis, saturated_s in told.saturated_s.items()
        if saturated_s > 0.0
    ]
    if found is None:
        return warnings
    for told, flown in zip(head.sessions, found.sessions, strict=True):
        if flown.in_frame.differs_from(told.budget_probability_in_frame):
            low, high = flown.in_frame.interval()
            warnings.append(
                f"session {told.session + 1}: the plan's budget tells a probability of "
                f"{told.budget_probability_in_frame:.3f} that the target stays in the frame, the "
                f"flights {flown.in_frame.value:.3f} ({low:.3f} to {high:.3f}): more than chance; "
                "the budget is linear and knows no drives but their resolution: trust the flights"
            )
    return warnings
