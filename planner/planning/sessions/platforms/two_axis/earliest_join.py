"""The earliest instant at which a slew can reach the track."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from planner.base import effort
from planner.base.arrays import Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.effort import WorkLimitReached
from planner.base.errors import InfeasibleSlew
from planner.motion.detour.detour import avoid_cones
from planner.motion.pointing.keep_out import KeepOutView
from planner.motion.pointing.track import AxisTrack
from planner.motion.slew.feasibility import fits_without_jerk, next_duration_s, verdict
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem, axis_states, is_within
from planner.planning.sessions.platforms.two_axis.slew_timing import TimedSlew, slew_within_lead
from planner.world.platforms import AxisLimits
from planner.world.scenario import SlewOptions


@dataclass(frozen=True, kw_only=True)
class JoinSearchOptions:
    """How the first row is sought at which a track can be joined."""

    look: int = 45  # of `effort`: to look at a row by itself
    glance: int = 40  # of `effort`: to look at many rows at once
    glance_row: float = 0.1  # of `effort`: and at each of them
    near_s: float = 4.0  # closer than this to feasibility every row is tried
    # failures after which rows are left out: rows carry a slew a row or two late
    rows_in_turn: int = 4
    failures_most: int = 8  # then the track is not joined early; each may take half a second
    detour_rows: int = 10  # a detour takes a second longer or ten: rows tried between, then halved
    # a receding or approaching track changes the time needed by a second per second
    caution: float = 4.0


OPTIONS = JoinSearchOptions()


@dataclass(frozen=True, kw_only=True)
class EarliestJoin:
    """The slew that meets the track at t_s, on the track's clock and on a command row.

    search_truncated: whether the bound of work ended the search for an earlier row.
    """

    t_s: float
    timed: TimedSlew
    search_truncated: bool = False


def track_states(track: AxisTrack, t_s: float) -> tuple[AxisState, ...]:
    """What a slew must arrive with to follow the track from t_s on."""
    effort.count(OPTIONS.look)
    angle, rate, acceleration = track.motion(np.array([t_s]))
    return axis_states(angle[0], rate[0], acceleration[0])


@dataclass(frozen=True, kw_only=True, eq=False)
class Approach:
    """A slew onto a track from a state at start_s, all times on the track's clock.

    Whole multiples of 0.2 s on it are command rows.
    """

    track: AxisTrack
    limits: tuple[AxisLimits, ...]
    start: tuple[AxisState, ...]
    start_s: float

    def earliest_join(
        self,
        options: SlewOptions,
        *,
        after_s: float = -math.inf,
        until_s: float = math.inf,
        keep_out: KeepOutView | None = None,
    ) -> EarliestJoin | None:
        """The first command row at which the slew can join the track; None: on no row tried.

        after_s, until_s: other joins are of no use.  keep_out: its time counted from start_s.
        Each row is tested itself: by closed forms, which see the gaps in the durations that an
        axis can take, and where they leave it open by solving and flying the slew.  When solving
        fails row after row, rows are left out, more and more; with cones, all within two
        seconds.  The first success is then taken forward by halving, so that after a failure the
        join is one with a failure just before it, not surely the first.
        """

        join_at = partial(self._slew_to, options=options, keep_out=keep_out)
        bad: int | None = None
        failures = 0
        for row in self.rows_within_reach(after_s, min(until_s, float(self.track.t_s[-1]))):
            step = (
                OPTIONS.detour_rows
                if keep_out is not None
                else 2 ** max(failures - OPTIONS.rows_in_turn, 0)
            )
            if bad is not None and row < bad + step:
                continue
            timed = join_at(row)
            if timed is not None:
                return _earliest_good(join_at, row - 1 if bad is None else bad, row, timed)
            bad, failures = row, failures + 1
            if failures >= OPTIONS.failures_most:
                break
        return None

    def rows_within_reach(self, after_s: float, until_s: float) -> Iterator[int]:
        """Rows in order on which no closed form forbids the slew to end.

        The cheapest of them is asked for all rows at once, the others for those that it leaves.
        """
        first_s = max(self.start_s + COMMAND_STEP_S, float(self.track.t_s[0]), after_s)
        next_row = math.ceil(first_s * ROWS_PER_S - 1e-6)
        all_rows = np.arange(next_row, math.floor(until_s * ROWS_PER_S + 1e-6) + 1)
        if not all_rows.size:
            return
        effort.charge(OPTIONS.glance + OPTIONS.glance_row * all_rows.size)
        for row in all_rows[self._certify_rows(all_rows)].tolist():
            if row < next_row:
                continue
            end = track_states(self.track, row / ROWS_PER_S)
            available_s = row / ROWS_PER_S - self.start_s
            lacking_s = self._lacking_s(end, available_s)
            if lacking_s <= 0.0 and self._is_possible(end, available_s):
                yield row
            skipped_s = (
                lacking_s / OPTIONS.caution if OPTIONS.near_s < lacking_s < math.inf else 0.0
            )
            next_row = row + max(1, math.floor(skipped_s * ROWS_PER_S))

    def _slew_to(
        self, row: int, options: SlewOptions, keep_out: KeepOutView | None
    ) -> TimedSlew | None:
        end = track_states(self.track, row / ROWS_PER_S)
        duration_s = row / ROWS_PER_S - self.start_s
        if not self._is_possible(end, duration_s):
            return None
        problem = SlewProblem(
            axis_names=self.track.axis_names,
            limits=self.limits,
            start=self.start,
            end=end,
            duration_s=duration_s,
            avoid_modes=options.avoid_modes,
            keep_out=keep_out,
        )
        try:
            return slew_within_lead(
                problem,
                options,
                lambda part: avoid_cones(
                    optimal_slew(part, on_rows=True), thorough=False, prove=False
                ),
            )
        except InfeasibleSlew:
            return None

    def _certify_rows(self, rows: Indices) -> Mask:
        """Whether unlimited jerk and no stops would let the slew end on each of the rows."""
        duration_s = rows / ROWS_PER_S - self.start_s
        angle, rate, _ = self.track.motion(rows / ROWS_PER_S)
        fits = [
            fits_without_jerk(here, angle[:, axis], rate[:, axis], limit, duration_s)
            for axis, (here, limit) in enumerate(zip(self.start, self.limits, strict=True))
        ]
        return np.asarray(np.all(fits, axis=0))

    def _is_possible(self, end: tuple[AxisState, ...], duration_s: float) -> bool:
        return all(
            is_within(there, limit) and verdict(here, there, limit, duration_s).limit is None
            for here, there, limit in zip(self.start, end, self.limits, strict=True)
        )

    def _lacking_s(self, end: tuple[AxisState, ...], available_s: float) -> float:
        """How much longer than available_s the slowest axis needs; infinite: it can't at all."""
        needed_s = 0.0
        for here, there, limit in zip(self.start, end, self.limits, strict=True):
            least_s = next_duration_s(here, there, limit, 0.0) if is_within(there, limit) else None
            needed_s = max(needed_s, math.inf if least_s is None else least_s)
        return needed_s - available_s * (1.0 + 1e-9)


def _earliest_good(
    join_at: Callable[[int], TimedSlew | None], bad: int, good: int, timed: TimedSlew
) -> EarliestJoin:
    """Between a row too early and a good one: the first good one, or the first one found."""
    while good - bad > 1:
        middle = (good + bad) // 2
        try:
            found = join_at(middle)
        except WorkLimitReached:
            return EarliestJoin(t_s=good / ROWS_PER_S, timed=timed, search_truncated=True)
        if found is None:
            bad = middle
        else:
            good, timed = middle, found
    return EarliestJoin(t_s=good / ROWS_PER_S, timed=timed)
