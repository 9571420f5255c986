"""Can a session be flown if it is moved, and what does it cost to find out?

The cost is counted, not timed: one request always gets one answer, however busy the machine.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from planner.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.errors import Refusal
from planner.frames.time_scales import elapsed_s, shifted_utc
from planner.gimbal.track import AxisTrack
from planner.joining import EARLY_ROWS, Rows, Way, joined, may_be_slewed, session_rows, ways_to_hold
from planner.line_of_sight import STENCIL
from planner.orbits import Ephemeris
from planner.scenario import Scenario, Session
from planner.slew import BACKENDS, AxisState
from planner.targets import BenchMotionTarget, Target, TimedTarget

# About microseconds on a core of 2024.
HOLD_US = 5_000  # of any stretch of a target
HOLD_ROW_US = 10  # of each of its rows: line of sight, angles, limits
CONES_SHARE = 0.5  # more, with cones to keep out of
CLOSED_FORM_US = 250  # of both axes at one row
SOLVE_US, SOLVE_ROW_US = 120_000, 2  # of a slew's rows
EARLY_SOLVES = 4  # slews solved until a track is joined early or not at all
DETOUR_US, DETOUR_ROW_US = 350_000, 8


class WorkSpent(Exception):
    """What was to be done next is more than is left: no refusal, the search ends."""


@dataclass
class Work:
    """What a search may still cost."""

    left_us: float

    def spend(self, us: float) -> None:
        """Raises WorkSpent, before the work is begun."""
        if us > self.left_us:
            raise WorkSpent
        self.left_us -= us


@dataclass(frozen=True, kw_only=True)
class _CountedTrack(AxisTrack):
    """A track each look at which is counted: closed forms look at it once a row."""

    work: Work

    def motion(
        self, t_s: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        self.work.spend(CLOSED_FORM_US)
        return super().motion(t_s)


@dataclass(frozen=True, kw_only=True)
class Refused:
    """A session that can't be flown as asked.

    number: its index.  state: of the axes at from_row, from which its slew begins.
    """

    scenario: Scenario
    number: int
    from_row: int
    state: tuple[AxisState, ...]

    @property
    def session(self) -> Session:
        return self.scenario.sessions[self.number]

    @property
    def epoch_utc(self) -> datetime:
        return self.scenario.initial_state.epoch

    @property
    def wanted(self) -> Rows:
        return session_rows(self.session, self.epoch_utc)


@dataclass(frozen=True, kw_only=True)
class Trials:
    """The refused session from a start row on; every method raises WorkSpent.

    seen: runs of rows in which its target can be seen, none other are tried.  stop_utc: the
    stop that goes with a start row.
    """

    refused: Refused
    ephemeris: Ephemeris
    seen: list[Rows]
    stop_utc: Callable[[int], datetime]
    work: Work

    def session(self, start_row: int) -> Session | None:
        """With its times moved; None where there is no such session."""
        refused = self.refused
        start_utc = shifted_utc(refused.epoch_utc, start_row / ROWS_PER_S)
        stop_utc = self.stop_utc(start_row)
        if start_row <= refused.from_row or elapsed_s(stop_utc, start_utc) < COMMAND_STEP_S:
            return None
        try:
            moved = replace(
                refused.session,
                target=_unbound(refused.session),
                start=start_utc,
                stop=stop_utc,
                keyhole="refuse",  # a start that needs no compromise, and no second of solving
            )
        except ValueError:  # the target itself is not known then
            return None
        rows = session_rows(moved, refused.epoch_utc)
        inside = any(run.start <= rows.start and rows.stop <= run.stop for run in self.seen)
        return moved if inside else None

    def ends_may(self, start_row: int) -> bool:
        """Whether the session's first and last rows leave it open: milliseconds, even of hours."""
        moved = self.session(start_row)
        if moved is None:
            return False
        rows = session_rows(moved, self.refused.epoch_utc)
        if rows.stop - rows.start < 2 * STENCIL or isinstance(moved.target, BenchMotionTarget):
            return True
        begun_utc, ended_utc = (
            shifted_utc(self.refused.epoch_utc, row / ROWS_PER_S)
            for row in (rows.start + STENCIL - 1, rows.stop - STENCIL + 1)
        )
        first = self._ways(replace(moved, stop=begun_utc))
        if self.refused.scenario.slew.objective != "minimum_time":
            first = tuple(way for way in first if self._may_be_slewed(way))
        return bool(first) and bool(self._ways(replace(moved, start=ended_utc)))

    def may(self, start_row: int) -> bool:
        """Whether the session can be held, and closed forms leave its slew open."""
        moved = self.session(start_row)
        if moved is None:
            return False
        ways = self._ways(moved)
        if any(self._may_be_slewed(way) for way in ways):
            return True
        if not ways or self.refused.scenario.slew.objective != "minimum_time":
            return False
        return any(self._may_be_slewed(way) for way in self._ways(moved, early=True))

    def flown(self, start_row: int) -> Session | None:
        """The moved session, if its slew is really found."""
        moved = self.session(start_row)
        if moved is None:
            return None
        ways = self._ways(moved, early=True)
        return moved if any(self._is_slewed(way) for way in ways) else None

    def _ways(self, session: Session, *, early: bool = False) -> tuple[Way, ...]:
        """None where the session can't be held, or nothing is known of orbit or attitude then.

        early: with the time in which its track may be joined before it begins.
        """
        refused = self.refused
        rows = session_rows(session, refused.epoch_utc)
        from_row = refused.from_row if early else rows.start
        count = rows.stop - rows.start
        if early and refused.scenario.slew.objective == "minimum_time":
            count += min(rows.start - from_row, EARLY_ROWS)
        cones = CONES_SHARE * len(refused.scenario.slew.keep_out)
        self.work.spend((HOLD_US + HOLD_ROW_US * count) * (1.0 + cones))
        angle_rad = np.array([axis.angle_rad for axis in refused.state])
        try:
            ways = ways_to_hold(
                refused.scenario, self.ephemeris, refused.number, session, from_row, angle_rad
            )
        except Refusal:
            return ()
        counted = (_CountedTrack(**vars(way.track), work=self.work) for way in ways)
        return tuple(replace(way, track=track) for way, track in zip(ways, counted, strict=True))

    def _may_be_slewed(self, way: Way) -> bool:
        refused = self.refused
        return may_be_slewed(refused.scenario, way, refused.from_row, refused.state)

    def _is_slewed(self, way: Way) -> bool:
        """A track that can be joined where its session begins needs no search for an earlier row.

        Where cones leave no way that is found quickly, none is sought for long.
        """
        scenario = self.refused.scenario
        cones = bool(scenario.slew.keep_out)
        rows = way.rows.start - self.refused.from_row
        solve_us = SOLVE_US + SOLVE_ROW_US * rows
        if cones:
            solve_us = DETOUR_US + DETOUR_ROW_US * rows
        if scenario.slew.objective != "minimum_time" or not self._keeps_limits:
            return self._found(scenario, way, solve_us)
        smooth = replace(scenario, slew=replace(scenario.slew, objective="smooth"))
        if self._found(smooth, way, solve_us):
            return True
        return not cones and self._found(scenario, way, EARLY_SOLVES * solve_us)

    @property
    def _keeps_limits(self) -> bool:
        return BACKENDS[self.refused.scenario.slew.method].keeps_limits

    def _found(self, scenario: Scenario, way: Way, solve_us: float) -> bool:
        refused = self.refused
        if not may_be_slewed(scenario, way, refused.from_row, refused.state):
            return False
        self.work.spend(solve_us)
        try:
            joined(scenario, way, refused.from_row, refused.state, thorough=False)
        except Refusal:
            return False
        return True


def _unbound(session: Session) -> Target:
    """The target as it was asked for: what began with the session will begin with the moved one."""
    target = session.target
    if isinstance(target, TimedTarget) and target.start == session.start:
        return replace(target, start=None)
    return target
