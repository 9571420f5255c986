"""Makes one attitude for every instant of the chosen candidates: rest, slews, scans.

Orbital orientation until the first slew must begin and after the last one; between scans a
slew onto the next one's profile, which is then followed until the camera starts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.commands import ROWS_PER_S
from planner.base.mrp import BodyMotion
from planner.base.rotation import Rotation
from planner.spacecraft.imaging.candidates import Candidate
from planner.spacecraft.imaging.ground_arc import GroundArc
from planner.spacecraft.imaging.session import AttitudeAt, ImagingSession, initial_profile
from planner.spacecraft.slews.slew_choice import (
    AttitudeSlewComparison,
    SlewNeedsTime,
    compare,
    slew_onto,
)
from planner.spacecraft.slews.slew_problem import AttitudeSlew, AttitudeSlewProblem, EndState
from planner.spacecraft.slews.slew_time import MovingEnds
from planner.spacecraft.table import TICK_S, ImagingWindow


@dataclass(frozen=True, kw_only=True)
class TimelineOptions:
    """How scans, turns and rests follow each other."""

    more_ticks_min: int = 3  # asked for between two scans whose slew doesn't fit
    # a slew onto a scan leaves orbital orientation about so long before
    rest_before_s: float = 20.0
    rest_after_s: float = 150.0  # longer pauses are spent in orbital orientation
    profile_margin_s: float = 1.0  # around the rows it is used for


OPTIONS = TimelineOptions()


@dataclass(frozen=True, kw_only=True)
class Scan:
    """One stretch of imaging: rows first_row .. last_row scan the arc.

    candidate, request: numbers of those it belongs to.
    """

    candidate: int
    request: int
    arc: GroundArc
    first_row: int
    last_row: int


@dataclass(frozen=True, kw_only=True)
class PlannedSlew:
    """A slew from row first_row to last_row; window: the number of the imaging window it leads
    to, None for orbital orientation."""

    first_row: int
    last_row: int
    window: int | None
    comparison: AttitudeSlewComparison


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """Attitudes and motion of all rows, n and (n, 3), with what they are made of."""

    q_body_from_eci: Rotation
    motion: BodyMotion
    slews: tuple[PlannedSlew, ...]
    windows: tuple[ImagingWindow, ...]


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """A slew with too little time: between which candidates (None: the session's ends), and
    how many ticks apart they should be."""

    before: int | None
    after: int | None
    ticks: int
    why: SlewNeedsTime


class SlewsDoNotFit(Exception):
    """Every misfit of a timeline."""

    def __init__(self, misfits: Sequence[Misfit]) -> None:
        super().__init__("; ".join(one.why.detail for one in misfits))
        self.misfits = tuple(misfits)


@dataclass(frozen=True, kw_only=True)
class SlewSlot:
    """The room for a slew: from first_row to last_row, between two scans (None: the session's
    ends).

    window: as of a `PlannedSlew`.  late: it leaves as late as it can to arrive at last_row, else
    at first_row, arriving when done.
    """

    before: Scan | None
    after: Scan | None
    first_row: int
    last_row: int
    window: int | None = None
    late: bool = False


Outcomes = dict[SlewSlot, AttitudeSlew | SlewNeedsTime]


def scans_of(candidates: Sequence[Candidate], chosen: Sequence[int]) -> tuple[Scan, ...]:
    """The arcs of the chosen candidates in order of time."""
    scans = [
        Scan(
            candidate=k,
            request=candidates[k].request,
            arc=arc,
            first_row=round(arc.start_s / TICK_S),
            last_row=round(arc.start_s / TICK_S) + arc.ticks,
        )
        for k in chosen
        for arc in candidates[k].arcs
    ]
    return tuple(sorted(scans, key=lambda scan: scan.first_row))


def build_timeline(
    session: ImagingSession, scans: tuple[Scan, ...], outcomes: Outcomes | None = None
) -> Timeline:
    """Scan in order, from orbital orientation or the request's initial attitude, which is left
    at once.

    outcomes: of slews tried in earlier attempts at the same session, kept by the caller.
    Raises SlewsDoNotFit with every pair that needs more time.
    """
    builder = _Builder(session, {} if outcomes is None else outcomes)
    builder.leave_initial_attitude(scans[0] if scans else None)
    before: Scan | None = None
    for number, scan in enumerate(scans):
        builder.slew_onto_scan(before, scan, number)
        builder.follow(scan.last_row + 1)
        before = scan
    if before is not None:
        now, last = builder.row, session.last_row
        slot = SlewSlot(before=before, after=None, first_row=now, last_row=last)
        builder.slew(builder.span(None, now, last), slot)
    builder.follow(session.last_row)
    if builder.misfits:
        raise SlewsDoNotFit(builder.misfits)
    return _assemble_timeline(builder, scans)


class _Builder:
    """Collects stretches in order; `row` is the last one decided, `profile` is followed there."""

    def __init__(self, session: ImagingSession, outcomes: Outcomes) -> None:
        self.session = session
        self.outcomes = outcomes
        self.stretches: list[tuple[int, AttitudeAt]] = []
        self.slews: list[tuple[SlewSlot, int, AttitudeSlewProblem, AttitudeSlew]] = []
        self.misfits: list[Misfit] = []
        self.row = 0
        self.profile = initial_profile(session.request, session.ephemeris)

    def span(self, arc: GroundArc | None, first_row: int, last_row: int) -> AttitudeAt:
        """The profile of an arc (None: orbital orientation) over some rows."""
        start_s, stop_s = first_row * TICK_S, last_row * TICK_S
        profile = self.session.profile(
            arc, start_s - OPTIONS.profile_margin_s, stop_s + OPTIONS.profile_margin_s
        )
        return profile.attitude_at

    def follow(self, until_row: int) -> None:
        self.stretches.append((until_row, self.profile))
        self.row = until_row

    def leave_initial_attitude(self, first: Scan | None) -> None:
        """Slew to orbital orientation, if not in it: in half the time to the first scan, or as much
        more as the slew onto that leaves."""
        last = self.session.last_row
        orbital = self.span(None, 0, last)
        if self.session.request.initial_q_body_from_eci_xyzw is None:
            self.profile = orbital
            return
        until = last
        if first is not None:
            until = max(first.first_row // 2, first.first_row - self.ticks_onto(first, orbital))
        self.slew(orbital, SlewSlot(before=None, after=first, first_row=0, last_row=until))

    def ticks_onto(self, scan: Scan, orbital: AttitudeAt) -> int:
        """Estimate of the slew onto a scan from orbital orientation."""
        profile = self.span(scan.arc, scan.first_row, scan.last_row)
        leaving = max(scan.first_row - round(OPTIONS.rest_before_s / TICK_S), 0)
        [ticks] = self.session.slew_time.ticks(
            MovingEnds.of(_end_state(orbital, leaving)),
            MovingEnds.of(_end_state(profile, scan.first_row)),
        )
        return int(ticks)

    def slew_onto_scan(self, before: Scan | None, scan: Scan, window: int) -> None:
        """By way of orbital orientation after a long pause."""
        settle_rows = math.ceil(self.session.spacecraft.slew.settle_s / TICK_S - 1e-6)
        arrive_row = scan.first_row - settle_rows
        pause_s = 0.0 if before is None else (scan.first_row - before.last_row) * TICK_S
        if pause_s > OPTIONS.rest_after_s:
            halfway = self.row + (arrive_row - self.row) // 2
            self.slew(
                self.span(None, self.row, scan.first_row),
                SlewSlot(before=before, after=scan, first_row=self.row, last_row=halfway),
            )
        # A scan's profile is continued backwards only so far: beyond, it leaves the ground.
        begin_row = max(self.row, scan.first_row - round(OPTIONS.rest_after_s / TICK_S))
        slot = SlewSlot(
            before=before,
            after=scan,
            first_row=self.row,
            last_row=arrive_row,
            window=window,
            late=before is None or pause_s > OPTIONS.rest_after_s,
        )
        self.slew(self.span(scan.arc, begin_row, scan.last_row + 1), slot)

    def slew(self, goal: AttitudeAt, slot: SlewSlot) -> None:
        """Slew onto the goal.  Outcomes are kept for the next attempt at the timeline; a slew
        that doesn't fit is noted and taken for done."""
        if slot not in self.outcomes:
            self.outcomes[slot] = self.try_slew(goal, slot)
        slew = self.outcomes[slot]
        if isinstance(slew, SlewNeedsTime):
            self.misfits.append(self.misfit(slot, slew))
            self.row = slot.last_row
        else:
            rows = round(slew.duration_s / TICK_S)
            if slot.late:
                self.follow(slot.last_row - rows)
            problem = self.problem(goal, self.row, self.row + rows)
            self.slews.append((slot, self.row, problem, slew))
            self.profile = _slew_profile(slew, self.row * TICK_S)
            self.follow(self.row + rows)
        self.profile = goal

    def try_slew(self, goal: AttitudeAt, slot: SlewSlot) -> AttitudeSlew | SlewNeedsTime:
        def problem_at(duration_s: float) -> AttitudeSlewProblem:
            rows = round(duration_s / TICK_S)
            start_row = slot.last_row - rows if slot.late else slot.first_row
            return self.problem(goal, start_row, start_row + rows)

        available_s = (slot.last_row - slot.first_row) * TICK_S
        try:
            return slew_onto(problem_at, available_s, self.session.request.objective)
        except SlewNeedsTime as why:
            return why

    def problem(self, goal: AttitudeAt, start_row: int, end_row: int) -> AttitudeSlewProblem:
        spacecraft = self.session.spacecraft
        return AttitudeSlewProblem(
            start=_end_state(self.profile, start_row),
            end=_end_state(goal, end_row),
            momentum_eci_n_m_s=self.session.momentum_eci_n_m_s,
            inertia_kg_m2=np.array(spacecraft.inertia_kg_m2),
            limits=spacecraft.slew,
        )

    def misfit(self, slot: SlewSlot, why: SlewNeedsTime) -> Misfit:
        start_row = 0 if slot.before is None else slot.before.last_row
        stop_row = self.session.last_row if slot.after is None else slot.after.first_row
        missing_ticks = math.ceil(why.missing_s / TICK_S - 1e-6)
        return Misfit(
            before=None if slot.before is None else slot.before.candidate,
            after=None if slot.after is None else slot.after.candidate,
            ticks=stop_row - start_row + max(missing_ticks, OPTIONS.more_ticks_min),
            why=why,
        )


def _slew_profile(slew: AttitudeSlew, start_s: float) -> AttitudeAt:
    return lambda t_s: slew.attitude_at(t_s - start_s)


def _end_state(profile: AttitudeAt, row: int) -> EndState:
    q_body_from_eci, motion = profile(np.array([row * TICK_S]))
    return EndState(
        q_body_from_eci=q_body_from_eci[0],
        omega_body_rad_s=motion.omega_body_rad_s[0],
        alpha_body_rad_s2=motion.alpha_body_rad_s2[0],
    )


def _assemble_timeline(builder: _Builder, scans: tuple[Scan, ...]) -> Timeline:
    session = builder.session
    attitudes, motions, row = [], [], 0
    for until_row, stretch in builder.stretches:
        rows = np.arange(row, until_row + (until_row == session.last_row))
        if len(rows):
            q_body_from_eci, motion = stretch(rows / ROWS_PER_S)
            attitudes.append(q_body_from_eci)
            motions.append(motion)
            row = int(rows[-1]) + 1
    numbers = [scan.request for scan in scans]
    windows = tuple(
        ImagingWindow(
            request=session.request.requests[scan.request].name,
            look=numbers[:k].count(scan.request),
            first_row=scan.first_row,
            last_row=scan.last_row,
        )
        for k, scan in enumerate(scans)
    )
    return Timeline(
        q_body_from_eci=Rotation.concatenate(attitudes),
        motion=BodyMotion(*(np.concatenate(column) for column in zip(*motions, strict=True))),
        slews=tuple(
            PlannedSlew(
                first_row=first_row,
                last_row=first_row + round(slew.duration_s / TICK_S),
                window=slot.window,
                comparison=compare(problem, slew),
            )
            for slot, first_row, problem, slew in builder.slews
        ),
        windows=windows,
    )
