"""The chosen scans as sessions of a body, joined by its slews into one table.

Orbital orientation is the body's idle attitude: it begins there unless told otherwise, waits
there while there is time, and ends there.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from planner.base.commands import ROWS_PER_S, CommandTable, Motion
from planner.base.errors import InfeasibleSlew, NotVisible, Refusal, TrackBreaksLimit, Unreachable
from planner.motion.attitude.problem import rows_of
from planner.planning.sessions.assembly import pair_joins
from planner.planning.sessions.plan import Plan
from planner.planning.sessions.platforms.mover import Join, TrackBranch
from planner.planning.sessions.platforms.registry import mover_of
from planner.spacecraft.imaging.baselines import AttitudeSlewComparison, compare
from planner.spacecraft.imaging.candidates import Candidate
from planner.spacecraft.imaging.ground_arc import GroundArc, scan_q_body_from_eci
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.table import TICK_S, ImagingWindow
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms import BodyPlatform
from planner.world.scenario import BoundedLead, InitialState, Scenario, Session, SlewOptions
from planner.world.targets.ground_path import GroundPathTarget, PathPoint


@dataclass(frozen=True, kw_only=True)
class TimelineOptions:
    """How scans, slews and waits follow each other."""

    more_ticks_min: int = 3  # asked for between two scans whose slew doesn't fit
    # turned by a slew of the longest time at the largest rate: from looking ahead to the side
    longest_rad: float = math.radians(63.0)
    never_s: float = 40.0  # told as missing where no slew was found, however long
    rest_before_s: float = 20.0  # a slew onto a scan leaves the idle attitude about so long before
    back_least_s: float = 2.0  # to turn back: the least bound of a slew's time that there is


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
    """joins: onto each window, a session of the scenario in the same order, and back."""

    scenario: Scenario
    joins: list[Join]
    windows: tuple[ImagingWindow, ...]


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """A slew with too little time: between which candidates (None: the session's ends), how many
    ticks apart they should be, and about how much time is missing.

    is_unheld: the second can't be scanned at all, whatever is before it.
    """

    before: int | None
    after: int | None
    ticks: int
    missing_s: float
    why: InfeasibleSlew
    is_unheld: bool = False


class SlewsDoNotFit(Exception):
    """Every misfit of a timeline."""

    def __init__(self, misfits: Sequence[Misfit]) -> None:
        super().__init__("; ".join(one.why.detail for one in misfits))
        self.misfits = tuple(misfits)


@dataclass(frozen=True, kw_only=True)
class Outcomes:
    """What was found of scans, and of the slews between them (None: the session's ends).

    A refusal stands with the time that is missing, in which a slew was found.
    """

    ways: dict[Scan, TrackBranch | Refusal] = field(default_factory=dict)
    slews: dict[tuple[Scan | None, Scan | None], "Join | _NeedsTime"] = field(default_factory=dict)


class _NeedsTime(NamedTuple):
    why: InfeasibleSlew
    missing_s: float


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


def scenario_of(session: ImagingSession, scans: tuple[Scan, ...]) -> Scenario:
    """Each scan a session of the body, on the same clock."""
    request = session.request
    most_s = OPTIONS.longest_rad / float(session.platform.envelope.by_order_rad[0].min())
    return Scenario(
        name=request.name,
        platform=session.platform,
        orbit=request.orbit,
        initial_state=InitialState(
            epoch=request.start, q_body_from_eci_xyzw=request.initial_q_body_from_eci_xyzw
        ),
        sessions=tuple(_session_of(session, scan) for scan in scans),
        slew=SlewOptions(
            objective=request.objective, lead=BoundedLead(max_duration_s=round(most_s, 1))
        ),
        final_state="idle",
    )


def _session_of(session: ImagingSession, scan: Scan) -> Session:
    arc = scan.arc
    points = tuple(
        PathPoint(
            latitude_deg=math.degrees(latitude_rad),
            longitude_deg=math.remainder(math.degrees(longitude_rad), 360.0),
            height_m=arc.height_m,
        )
        for latitude_rad, longitude_rad in zip(arc.latitude_rad, arc.longitude_rad, strict=True)
    )
    return Session(
        name=session.request.requests[scan.request].name,
        target=GroundPathTarget(
            points=points, line="plane", speed_m_s=arc.length_m() / arc.duration_s
        ),
        start=shifted_utc(session.epoch_utc, scan.first_row / ROWS_PER_S),
        stop=shifted_utc(session.epoch_utc, scan.last_row / ROWS_PER_S),
    )


def build_timeline(
    session: ImagingSession, scans: tuple[Scan, ...], outcomes: Outcomes | None = None
) -> Timeline:
    """Scan in order, from orbital orientation or the request's initial attitude.

    outcomes: of earlier attempts at the same session, kept by the caller.
    Raises SlewsDoNotFit with every pair that needs more time.
    """
    builder = _Builder(session, scans, Outcomes() if outcomes is None else outcomes)
    for number, scan in enumerate(scans):
        builder.scan(number, scan)
    builder.come_back(scans[-1])
    if builder.misfits:
        raise SlewsDoNotFit(builder.misfits)
    return builder.timeline()


class _Builder:
    """Joins so far; `before` is left at `row`, moving as `state` says."""

    def __init__(
        self, session: ImagingSession, scans: tuple[Scan, ...], outcomes: Outcomes
    ) -> None:
        self.session, self.scans, self.outcomes = session, scans, outcomes
        self.scenario = scenario_of(session, scans)
        self.mover = mover_of(self.scenario)
        self.before: Scan | None = None
        self.row, self.state = 0, self.mover.initial(session.ephemeris)
        self.joins: list[Join] = []
        self.misfits: list[Misfit] = []

    def scan(self, number: int, scan: Scan) -> None:
        """A slew onto it, and its track.  What doesn't fit is noted and taken for done."""
        way = self._way(number, scan)
        if isinstance(way, Refusal):
            self._note(scan, _NeedsTime(InfeasibleSlew(way.detail, limit=way.limit), 0.0), True)
            return
        join = self._slew(scan, way, (way.rows.start - self.row) / ROWS_PER_S)
        if isinstance(join, Join):
            self.joins.append(join)
        else:
            self._note(scan, join)
        self.before, self.row = scan, way.rows.stop
        self.state = self.mover.state_at(way, way.rows.stop)

    def come_back(self, last: Scan) -> None:
        """To orbital orientation, by the session's end."""
        if not self.joins or self.before is not last:
            return
        slots, key = self.outcomes.slews, (last, None)
        if key not in slots:
            slots[key] = self._back()
        join = slots[key]
        if isinstance(join, Join):
            self.joins.append(join)
        else:
            self._note(None, join)

    def _back(self) -> Join | _NeedsTime:
        left_s = (self.session.last_row - self.row) / ROWS_PER_S
        slew = self.scenario.slew
        assert isinstance(slew.lead, BoundedLead)  # as scenario_of gives it
        assert slew.lead.max_duration_s is not None
        most_s = min(left_s, slew.lead.max_duration_s)
        if most_s < OPTIONS.back_least_s:
            why = InfeasibleSlew("no time is left to turn back before the session's end")
            return _NeedsTime(why, OPTIONS.back_least_s - left_s)
        lead = BoundedLead(max_duration_s=round(most_s, 1))
        hasty = mover_of(replace(self.scenario, slew=replace(slew, lead=lead)))
        try:
            final = hasty.with_final_slew(self.session.ephemeris, self.joins[-1:])[-1]
        except InfeasibleSlew as why:
            return _needs_time(why, left_s, 0.0)
        return replace(final, stop_row=self.session.last_row)

    def _way(self, number: int, scan: Scan) -> TrackBranch | Refusal:
        """The scan's track, of two senses the one that its arc says."""
        if scan not in self.outcomes.ways:
            at_s = np.array([scan.first_row / ROWS_PER_S])
            q_body_from_eci = scan_q_body_from_eci(
                scan.arc, np.zeros(1), self.session.ephemeris, self.session.instants(at_s)
            )
            still = np.zeros((1, 3))
            there = Motion(np.asarray(q_body_from_eci.inv().as_quat()), still, still)
            try:
                [self.outcomes.ways[scan], *_] = self.mover.ways(
                    self.session.ephemeris, number, self.scenario.sessions[number], self.row, there
                )
            except (NotVisible, Unreachable, TrackBreaksLimit) as why:
                self.outcomes.ways[scan] = why
        return self.outcomes.ways[scan]

    def _slew(self, scan: Scan, way: TrackBranch, available_s: float) -> Join | _NeedsTime:
        key = (self.before, scan)
        if key not in self.outcomes.slews:
            try:
                join = self.mover.slew_onto(way, self.row, self.state)
                if join.slew.wait and self.scenario.slew.objective == "minimum_time":
                    join = self._hastened(way, join)
                self.outcomes.slews[key] = join
            except InfeasibleSlew as why:
                there = self.mover.state_at(way, way.rows.start)
                least_s = self.mover.least_s(self.state, there)
                self.outcomes.slews[key] = _needs_time(why, available_s, least_s)
        return self.outcomes.slews[key]

    def _hastened(self, way: TrackBranch, join: Join) -> Join:
        """Out of its wait in the least time, too, from when on the scan's line is followed."""
        idle = rows_of(join.slew.slew.motion, slice(1))
        quick = self.mover.slew_onto(way, join.slew_row, idle)
        return replace(join, slew=replace(join.slew, slew=quick.slew.slew), join_row=quick.join_row)

    def _note(self, after: Scan | None, found: _NeedsTime, is_unheld: bool = False) -> None:
        before = self.before
        start_row = 0 if before is None else before.last_row
        stop_row = self.session.last_row if after is None else after.first_row
        missing_ticks = math.ceil(found.missing_s / TICK_S - 1e-6)
        self.misfits.append(
            Misfit(
                before=None if before is None else before.candidate,
                after=None if after is None else after.candidate,
                ticks=stop_row - start_row + max(missing_ticks, OPTIONS.more_ticks_min),
                missing_s=found.missing_s,
                why=found.why,
                is_unheld=is_unheld,
            )
        )

    def timeline(self) -> Timeline:
        """All of it."""
        numbers = [scan.request for scan in self.scans]
        return Timeline(
            scenario=self.scenario,
            joins=self.joins,
            windows=tuple(
                ImagingWindow(
                    request=self.session.request.requests[scan.request].name,
                    look=numbers[:k].count(scan.request),
                    first_row=scan.first_row,
                    last_row=scan.last_row,
                )
                for k, scan in enumerate(self.scans)
            ),
        )


def planned_slews(platform: BodyPlatform, plan: Plan, joins: list[Join]) -> Iterator[PlannedSlew]:
    """Of a plan made of these joins."""
    row = 0
    for run, (window, join) in zip(plan.slews, pair_joins(plan.scenario, joins), strict=True):
        slews = [(join.slew_row, join.join_row, window, run.wall_s)]
        if join.brake_rows:
            slews.insert(0, (row, row + join.brake_rows, None, 0.0))
        for first_row, last_row, onto, solve_s in slews:
            comparison = compare(
                table_rows(plan.table, first_row, last_row),
                platform,
                plan.scenario.slew.objective,
                run.status,
                solve_s,
            )
            yield PlannedSlew(
                first_row=first_row, last_row=last_row, window=onto, comparison=comparison
            )
        row = join.stop_row


def table_rows(table: CommandTable, first_row: int, last_row: int) -> Motion:
    """Of a body, both included."""
    rows = slice(first_row, last_row + 1)
    assert table.acceleration_rad_s2 is not None  # a body's table has it
    return Motion(table.position[rows], table.rate_rad_s[rows], table.acceleration_rad_s2[rows])


def _needs_time(why: InfeasibleSlew, available_s: float, least_s: float) -> _NeedsTime:
    """How much time is missing about; of what isn't a matter of time, a lot."""
    needs_s = max(why.needs_s or 0.0, least_s)
    if why.limit != "duration" or not available_s < needs_s < math.inf:
        return _NeedsTime(why, OPTIONS.never_s)
    return _NeedsTime(why, min(needs_s - available_s, OPTIONS.never_s))
