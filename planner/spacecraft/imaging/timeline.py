"""The chosen scans as sessions of a body, joined by its slews, and these in figures.

Orbital orientation is the body's idle attitude: it begins there unless told otherwise, waits
there while there is time, and ends there.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, Motion
from planner.base.errors import InfeasibleSlew, Refusal
from planner.base.mrp import BodyMotion
from planner.base.rotation import Rotation
from planner.motion.attitude.eigenaxis import eigenaxis_slew, quickest_eigenaxis
from planner.motion.attitude.problem import BodySlewProblem, between_rows, rows_of
from planner.motion.attitude.track import agility_limits
from planner.planning.sessions.plan import Plan
from planner.planning.sessions.platforms.mover import Join, Mover, RowSpan, TrackBranch
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.sequence import SessionRefused, sequence_sessions
from planner.planning.sessions.track_branches import seen_from_s
from planner.spacecraft.found import AttitudeSlewReport
from planner.spacecraft.imaging.session import GroundArc, ImagingSession
from planner.spacecraft.requests import ImagingWindow
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.plan import segment_rows
from planner.world.platforms import BodyPlatform
from planner.world.scenario import BoundedLead, InitialState, Scenario, Session, SlewOptions


@dataclass(frozen=True, kw_only=True)
class TimelineOptions:
    """How scans, slews and waits follow each other, and how closely slews are looked at."""

    # turned by a slew of the longest time at the largest rate, from looking ahead to the side; one
    # that turns farther, as about the vertical, has the time that suffices
    longest_rad: float = math.radians(63.0)
    any_jerk: float = 1e4  # times its limit: none
    instants: int = 400  # of a slew about the Euler axis
    between: tuple[float, ...] = (0.0, 0.5, 1.0)  # two rows


OPTIONS = TimelineOptions()


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """joins: onto each window, a session of the scenario in the same order, and back."""

    scenario: Scenario
    joins: list[Join]
    windows: tuple[ImagingWindow, ...]


class DoesNotFit(Exception):
    """A scan that isn't held, or the first onto which, or the last from which, no slew is found,
    and why."""

    def __init__(self, arc: GroundArc, why: Refusal) -> None:
        super().__init__(why.detail)
        self.arc, self.why = arc, why


def _scenario_of(session: ImagingSession, arcs: Sequence[GroundArc], names: list[str]) -> Scenario:
    """Each scan a session of the body, on the same clock."""
    request = session.request
    usual_s = OPTIONS.longest_rad / float(session.platform.envelope.by_order_rad[0].min())
    idle = session.ends(None, np.array([arcs[0].start_s, arcs[-1].stop_s]), 0.0)
    entries = [session.entries(arc, np.array([arc.start_s])) for arc in arcs]
    exits = [session.ends(arc, np.array([arc.start_s]), arc.scan_s) for arc in arcs]
    starts, goals = np.vstack([idle[:1], *exits]), np.vstack([*entries, idle[1:]])
    turns = Rotation.from_quat(starts[:, :4]).inv() * Rotation.from_quat(goals[:, :4])
    is_far = turns.magnitude() > OPTIONS.longest_rad
    far_ticks = session.slews.ticks(starts[is_far], goals[is_far])
    most_s = max(round(usual_s, 1), far_ticks.max(initial=0) * COMMAND_STEP_S)
    return Scenario(
        name=request.name,
        platform=session.platform,
        orbit=request.orbit,
        initial_state=InitialState(
            epoch=request.start, q_body_from_eci_xyzw=request.initial_q_body_from_eci_xyzw
        ),
        sessions=tuple(
            Session(
                name=name,
                target=arc.path,
                start=shifted_utc(request.start, arc.first_row / ROWS_PER_S),
                stop=shifted_utc(request.start, arc.last_row / ROWS_PER_S),
            )
            for name, arc in zip(names, arcs, strict=True)
        ),
        slew=SlewOptions(
            objective=request.objective,
            lead=BoundedLead(max_duration_s=most_s),
        ),
        final_state="idle",
        final_by=shifted_utc(request.start, session.duration_s),
    )


def build_timeline(session: ImagingSession, arcs: Sequence[GroundArc]) -> Timeline:
    """Scan in order of time, from orbital orientation or the request's initial attitude, and back.

    Raises DoesNotFit; SearchEnded, InfeasibleSlew where it is the initial attitude's fault.
    """
    names = [session.request.requests[one.request].name for one in arcs]
    scenario, ephemeris = _scenario_of(session, arcs, names), session.ephemeris
    mover = mover_of(scenario)
    try:
        joins = sequence_sessions(scenario, ephemeris, mover, prove=False)
    except SessionRefused as refused:
        raise DoesNotFit(arcs[refused.session.number], refused.refusal) from None
    try:
        *onto, final = mover.with_final_slew(ephemeris, joins)
    except InfeasibleSlew as why:
        raise DoesNotFit(arcs[-1], why) from None
    if scenario.slew.objective == "minimum_time":
        onto = [
            _hastened(mover, ephemeris, *one) for one in zip(scenario.sessions, onto, strict=True)
        ]
    return Timeline(
        scenario=scenario,
        joins=[*onto, replace(final, stop_row=round(session.duration_s / COMMAND_STEP_S))],
        windows=tuple(
            ImagingWindow(
                request=name,
                look=one.look,
                first_row=one.first_row,
                last_row=one.last_row,
            )
            for name, one in zip(names, arcs, strict=True)
        ),
    )


def _hastened(mover: Mover, ephemeris: Ephemeris, session: Session, join: Join) -> Join:
    """Out of its wait, if any, in the least time, too, from when on the scan's line is followed."""
    if not join.slew.wait:
        return join
    track, joined_s = join.track, join.join_row / ROWS_PER_S
    branch = TrackBranch(
        session=session,
        track=track,
        rows=RowSpan(start=join.join_row, stop=join.stop_row),
        seen_from_s=max(seen_from_s(track.los, joined_s), float(track.t_s[0])),
        ephemeris=ephemeris,
        settle_rows=join.settle_rows,
    )
    idle = rows_of(join.slew.slew.motion, slice(1))
    try:
        quick = mover.slew_onto(branch, join.slew_row, idle)
    except InfeasibleSlew:  # no quicker one is found than that which is known
        return join
    return replace(join, slew=replace(join.slew, slew=quick.slew.slew), join_row=quick.join_row)


def report_slews(platform: BodyPlatform, plan: Plan) -> Iterator[AttitudeSlewReport]:
    """In order of time, those back to orbital orientation among them."""
    table, runs = plan.table, {run.session: run for run in plan.slews}
    assert table.acceleration_rad_s2 is not None  # a body's table has it
    whole = Motion(table.position, table.rate_rad_s, table.acceleration_rad_s2)
    for one in plan.segments:
        if one.kind not in ("brake", "slew"):
            continue
        first, last = segment_rows(table, one)
        run, is_slew = runs[one.session], one.kind == "slew"
        yield AttitudeSlewReport(
            start_utc=one.start_utc,
            stop_utc=one.stop_utc,
            onto=one.session if is_slew else None,
            method="ocp",
            time_from="ocp" if plan.scenario.slew.objective == "minimum_time" else None,
            status=run.status,
            solve_s=run.wall_s if is_slew else 0.0,
            **compare(rows_of(whole, slice(first, last + 1)), platform),
        )


def compare(motion: Motion, platform: BodyPlatform) -> dict[str, float]:
    """Figures of a slew's rows, its ends among them, as `AttitudeSlewReport` names them.

    The torque rate's peak, of this slew and of the eigenaxis one of the same duration, is what
    shakes the modes; it is counted without the momentum that is turned with the body.
    """
    row = len(motion.position) - 1
    limits, inertia_kg_m2 = agility_limits(platform), np.array(platform.inertia_kg_m2)
    problem = BodySlewProblem(
        start=rows_of(motion, slice(1)),
        goal=rows_of(motion, slice(-1, None)),
        first_arrival_row=row,
        limits=limits,
    )
    abrupt = replace(limits, jerk_rad_s3=OPTIONS.any_jerk * limits.jerk_rad_s3)
    duration_s = row / ROWS_PER_S
    same_time = eigenaxis_slew(problem, row, duration_s=duration_s)

    def peak_n_m_s(body: BodyMotion) -> float:
        torque_rates = body.jerk_body_rad_s3.reshape(-1, 3) @ inertia_kg_m2
        return float(np.max(np.linalg.norm(torque_rates, axis=1)))

    even_s = np.linspace(0.0, duration_s, OPTIONS.instants)
    return {
        "angle_rad": float(problem.angles_rad[0]),
        "duration_s": duration_s,
        "eigenaxis_s": quickest_eigenaxis(problem)[0].duration_s,
        "bang_coast_bang_s": quickest_eigenaxis(replace(problem, limits=abrupt))[0].duration_s,
        "torque_rate_peak_n_m_s": peak_n_m_s(between_rows(motion, np.array(OPTIONS.between))[1]),
        "eigenaxis_torque_rate_peak_n_m_s": peak_n_m_s(same_time.motion(even_s)[1]),
    }
