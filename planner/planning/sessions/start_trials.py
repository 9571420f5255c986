"""Trials of whether a session can be flown if it is moved."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import datetime

import numpy as np

from planner.base import effort
from planner.base.arrays import Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.errors import InfeasibleSlew, Refusal
from planner.motion.pointing.line_of_sight import STENCIL
from planner.planning.sessions.platforms.mover import Mover, RowSpan, TrackBranch
from planner.planning.sessions.sequence import RefusedSession
from planner.planning.sessions.track_branches import OPTIONS as TRACK_BRANCH_OPTIONS
from planner.planning.sessions.track_branches import (
    los_on_rows,
    session_rows,
)
from planner.world.frames.time_scales import elapsed_s
from planner.world.orbits import Ephemeris
from planner.world.scenario import Session
from planner.world.targets import BenchMotionTarget

# The longest stretch of a refused session over which its target can be held.

LOOKS_MAX = 20_000  # of more than an hour not every row is looked at


def longest_hold(refused: RefusedSession, ephemeris: Ephemeris) -> RowSpan | None:
    """Rows of the session as asked; None where nothing of it can be held, or that isn't known.

    On one branch throughout: seen, within stops and limits and out of all cones and masks, and
    within the rules among sessions.  Whether it can be slewed onto is not looked at.
    """
    scenario, wanted, target = refused.scenario, refused.wanted, refused.session.target
    start = max(wanted.start, refused.from_row + 1)
    if isinstance(target, BenchMotionTarget) or wanted.stop - start < 2 * STENCIL:
        return None
    stride = math.ceil((wanted.stop - start) / LOOKS_MAX)
    count = (wanted.stop - start) // stride + 1
    rows = RowSpan(start=start, stop=start + (count - 1) * stride)
    effort.charge(TRACK_BRANCH_OPTIONS.hold + TRACK_BRANCH_OPTIONS.hold_row * count)
    try:
        los = los_on_rows(scenario, ephemeris, target, rows, count)
        ways = tuple(refused.mover.held(ephemeris, refused.session, los, refused.state))
    except Refusal:  # nothing is known of the orbit or attitude then
        return None
    t_s, aside_s = los.instants.t_s, TRACK_BRANCH_OPTIONS.grid_tolerance_s
    seen = (los.clearance_rad[1:] >= 0.0) & (los.clearance_rad[:-1] >= 0.0)
    seen &= t_s[:-1] >= refused.cadence.soonest_s(refused.number) - aside_s
    seen &= t_s[1:] <= refused.cadence.kept_until_s(refused.number) + aside_s
    longest: RowSpan | None = None
    for held in ways:
        cells = _longest_run(held & seen)
        if longest is None or (cells.stop - cells.start) * stride > longest.stop - longest.start:
            longest = RowSpan(start=start + cells.start * stride, stop=start + cells.stop * stride)
    return longest if longest is not None and longest.stop > longest.start else None


def _longest_run(held: Mask) -> RowSpan:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]))).reshape(-1, 2)
    if not len(edges):
        return RowSpan(start=0, stop=0)
    start, stop = edges[np.argmax(edges[:, 1] - edges[:, 0])].tolist()
    return RowSpan(start=start, stop=stop)


# By start and stop of a session: whether its slew is found, and starts at which it about is.
Slewed = dict[tuple[datetime, datetime], tuple[bool, tuple[int, ...]]]


@dataclass(frozen=True, kw_only=True)
class Trials:
    """The refused session from a start row on; every method may end by WorkLimitReached.

    seen: runs of rows in which its target can be seen, none other are tried.  stop_utc: the
    stop that goes with a start row.  held: rows over which the target is known to be held, none
    other are tried; None where that isn't known.  slewed: what was tried before.
    kept_work_rows: of `effort`, that is to be left.
    """

    refused: RefusedSession
    ephemeris: Ephemeris
    seen: list[RowSpan]
    stop_utc: Callable[[int], datetime]
    held: RowSpan | None = None
    slewed: Slewed = field(default_factory=dict)
    kept_work_rows: float = 0.0
    _latest: dict[tuple[datetime, datetime, bool], tuple[TrackBranch, ...]] = field(
        default_factory=dict
    )
    _needed_rows: list[int] = field(default_factory=list)

    @property
    def mover(self) -> Mover:
        return self.refused.mover

    @property
    def _joins_early(self) -> bool:
        return self.refused.scenario.slew.objective == "minimum_time"

    def moved_session(self, start_row: int) -> Session | None:
        """The session with its times moved; None where there is no such session."""
        refused = self.refused
        start_utc = refused.utc(start_row)
        stop_utc = self.stop_utc(start_row)
        if start_row <= refused.from_row or elapsed_s(stop_utc, start_utc) < COMMAND_STEP_S:
            return None
        try:
            moved = replace(
                refused.session,
                target=refused.session.target.unbound(refused.session.start),
                start=start_utc,
                stop=stop_utc,
                keyhole="refuse",  # a start that needs no compromise, and no second of solving
            )
        except ValueError:  # the target itself is not known then
            return None
        rows = session_rows(moved, refused.epoch_utc)
        runs = self.seen if self.held is None else [self.held]
        inside = any(run.start <= rows.start and rows.stop <= run.stop for run in runs)
        times = (elapsed_s(at, refused.epoch_utc) for at in (start_utc, stop_utc))
        return moved if inside and refused.cadence.keeps(refused.number, *times) else None

    def ends_may(self, start_row: int) -> bool:
        """Whether the session's first and last rows leave it open: milliseconds, even of hours."""
        moved = self.moved_session(start_row)
        if moved is None:
            return False
        rows = session_rows(moved, self.refused.epoch_utc)
        if rows.stop - rows.start < 2 * STENCIL or isinstance(moved.target, BenchMotionTarget):
            return True
        begun_utc = self.refused.utc(rows.start + STENCIL - 1)
        ended_utc = self.refused.utc(rows.stop - STENCIL + 1)
        first = self._branches_at(replace(moved, stop=begun_utc))
        if not self._joins_early:
            first = tuple(branch for branch in first if self._may_be_slewed(branch))
        return bool(first) and bool(self._branches_at(replace(moved, start=ended_utc)))

    def may_succeed(self, start_row: int) -> bool:
        """Whether the session can be held, and closed forms leave its slew open."""
        moved = self.moved_session(start_row)
        if moved is None:
            return False
        if self.held is not None and not self._joins_early:
            return self.ends_may(start_row)
        branches = self._branches_at(moved)
        if any(self._may_be_slewed(branch) for branch in branches):
            return True
        if not branches or not self._joins_early:
            return False
        return any(self._may_be_slewed(branch) for branch in self._branches_at(moved, early=True))

    def feasible_session(self, start_row: int) -> Session | None:
        """The moved session, if its slew is really found."""
        moved = self.moved_session(start_row)
        if moved is None:
            return None
        times = moved.start, moved.stop
        self._needed_rows.clear()
        if times not in self.slewed:
            branches = self._branches_at(moved, early=True)
            is_slewed = any(self._is_slewed(branch) for branch in branches)
            self.slewed[times] = is_slewed, tuple(self._needed_rows)
        is_slewed, self._needed_rows[:] = self.slewed[times]
        return moved if is_slewed else None

    @property
    def needed_row(self) -> int:
        """A start at which the session tried last is about feasible; -1 where that isn't known."""
        return min(self._needed_rows, default=-1)

    def _branches_at(self, session: Session, *, early: bool = False) -> tuple[TrackBranch, ...]:
        """None where the session can't be held, or nothing is known of orbit or attitude then.

        early: with the time in which its track may be joined before it begins.
        """
        key = session.start, session.stop, early and self._joins_early
        if key not in self._latest:
            found = self._branches_anew(session, early=early)
            self._latest.clear()  # a session of hours fills megabytes
            self._latest[key] = found
        return self._latest[key]

    def _branches_anew(self, session: Session, *, early: bool) -> tuple[TrackBranch, ...]:
        refused = self.refused
        rows = session_rows(session, refused.epoch_utc)
        from_row = refused.from_row if early else rows.start
        try:
            return self.mover.ways(self.ephemeris, refused.number, session, from_row, refused.state)
        except Refusal:
            return ()

    def _may_be_slewed(self, branch: TrackBranch) -> bool:
        """Whether closed forms leave open that a slew succeeds; microseconds, cones aside."""
        state, from_row, join_row = self.refused.state, self.refused.from_row, branch.rows.start
        there = self.mover.state_at(branch, join_row)
        if self.mover.may_slew(state, there, join_row - from_row):
            return True
        # The durations a slew can take have gaps: an earlier row may be within reach.
        return self.mover.first_row_in_reach(branch, from_row, state, join_row) is not None

    def _is_slewed(self, branch: TrackBranch) -> bool:
        """A track that can be joined where its session begins needs no search for an earlier row.

        Where cones leave no branch that is found quickly, none is sought for long.
        """
        may_be_early = self._joins_early and not self.refused.scenario.keeps_out
        return self._is_found(branch, early=False) or (
            may_be_early and self._is_found(branch, early=True)
        )

    def _is_found(self, branch: TrackBranch, *, early: bool) -> bool:
        refused = self.refused
        if not self._may_be_slewed(branch):
            return False
        try:
            self.mover.slew_onto(
                branch, refused.from_row, refused.state, thorough=False, early=early
            )
        except Refusal as refusal:
            if isinstance(refusal, InfeasibleSlew) and refusal.needs_s is not None:
                self._needed_rows.append(self._row_in_time(branch, refusal.needs_s))
            return False
        return True

    def _row_in_time(self, branch: TrackBranch, needs_s: float) -> int:
        """At which the session may begin, where a slew to its first row takes so long.

        At another row of the track it takes about as much more or less as closed forms say.
        """
        refused, here, mover = self.refused, branch.rows.start, self.mover
        needed_rows = math.ceil(needs_s * ROWS_PER_S - 1e-6)
        row = refused.from_row + needed_rows
        if here < row <= branch.rows.stop:
            least_s, there_s = (
                mover.least_s(refused.state, mover.state_at(branch, at)) for at in (here, row)
            )
            slope = needed_rows * (there_s / least_s - 1.0) / (row - here)
            if slope < 1.0:
                row = math.ceil(here + (row - here) / (1.0 - slope) - 1e-6)
        return row + branch.settle_rows
