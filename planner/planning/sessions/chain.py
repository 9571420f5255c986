"""The cheapest chain of slews through all sessions, step by step from way to way."""

from dataclasses import dataclass, replace
from functools import cache

from planner.base import effort
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew
from planner.motion.slew import AxisState
from planner.planning.sessions.earliest_join import track_states
from planner.planning.sessions.holding import GRID_TOLERANCE_S, Way
from planner.planning.sessions.joining import (
    Join,
    first_row_in_reach,
    may_slew_between,
    slew_onto,
)
from planner.planning.sessions.lead import least_slew_s
from planner.world.frames.time_scales import elapsed_s
from planner.world.scenario import Scenario

SPLITS = 8  # how finely a loss is shared between two sessions
CARE_SHARE = 0.4  # of the work that is left, for what isn't found at once; then for bettering it
CARE_MOST = 120_000  # for one slew: another one may do as well
SHUT_ROWS = 10  # which a slew that cones shut must at least have more: a try takes a second
TRIES_PER_PAIR = 6  # rows at which one slew is tried; the solver needs a row or two more at most
# Which eighths of what is lost the earlier of two sessions may bear; none: nothing is given up.
CONFLICTS: dict[str, tuple[int, ...]] = {
    "refuse": (),
    "shorten_later": (0,),
    "shorten_earlier": (SPLITS,),
    "least_loss": tuple(range(SPLITS + 1)),
}
States = tuple[AxisState, ...]


@dataclass(frozen=True, kw_only=True)
class Stand:
    """Where a slew begins: on a session's way, joined at `join_row`, or initially, in row 0."""

    way: Way | None
    join_row: int

    @property
    def last_row(self) -> int:
        return self.way.rows.stop if self.way else self.join_row


@dataclass(frozen=True, kw_only=True)
class ChainStep(Stand):
    """Onto a way: the row at which the stand before is left, and what that costs."""

    way: Way
    leave_row: int
    lost_rows: int
    slew_s: float


Steps = tuple[ChainStep, ...]
Pair = tuple[Way | None, Way]  # left and joined


def initial_state(scenario: Scenario) -> States:
    """The platform at row 0, axis by axis."""
    motions = (scenario.initial_motion(axis).tolist() for axis in scenario.platform.axis_names)
    return tuple(AxisState(angle_rad=q, rate_rad_s=v, acceleration_rad_s2=a) for q, v, a in motions)


class Chain:
    """The ways of each session, and the slews between them that solving found impossible.

    What was found out is kept, by ways and by rows: each search goes over it again.
    """

    def __init__(self, scenario: Scenario, sessions: list[tuple[Way, ...]]) -> None:
        self.scenario = scenario
        self.sessions = sessions
        self._barred: dict[Pair, set[tuple[int, int]]] = {}
        self._joins: dict[tuple[Pair, int, int], Join] = {}
        self._steps: dict[tuple[Pair, int, tuple[int, ...], int], ChainStep | None] = {}
        self._shut: dict[Pair, int] = {}
        self._may_slew = cache(self._try_slew)
        self._first_row_in_reach = cache(self._seek_row_in_reach)
        self._initial = initial_state(scenario)
        epoch_utc = scenario.initial_state.epoch
        self._session_span_s = cache(
            lambda way: [elapsed_s(at, epoch_utc) for at in (way.session.start, way.session.stop)]
        )
        self._track_states = cache(lambda way, row: track_states(way.track, row / ROWS_PER_S))
        self._care_left = CARE_SHARE * effort.remaining()
        self._is_search_truncated = False

    def solve(self, mode: str, count: int | None = None) -> tuple[Steps, list[Join]] | None:
        """The cheapest steps of the first `count` sessions, all, whose slews are all found."""
        while (steps := self.cheapest(CONFLICTS[mode], count)) is not None:
            joins: list[Join] = []
            for number, step in enumerate(steps):
                join = self._join(self.stand(steps[:number]), step)
                if join is None:
                    break
                if joins:
                    joins[-1] = replace(joins[-1], stop_row=step.leave_row)
                joins.append(join)
            else:
                return steps, joins
        return None

    def _join(self, stand: Stand, step: ChainStep) -> Join | None:
        """Solved once, whichever mode asks; None: undecided by closed form, then impossible."""
        pair, rows = (stand.way, step.way), (step.leave_row, step.join_row)
        if (pair, *rows) not in self._joins:
            way = replace(step.way, rows=replace(step.way.rows, start=step.join_row))
            state = self.state(stand.way, step.leave_row)
            try:
                self._joins[pair, *rows] = self._solve_join(way, step.leave_row, state)
            except InfeasibleSlew as refusal:
                self._barred.setdefault(pair, set()).add(rows)
                if refusal.limit == "keep_out":
                    self._shut[pair] = step.join_row - step.leave_row + SHUT_ROWS
                return None
        return self._joins[pair, *rows]

    def _solve_join(self, way: Way, from_row: int, state: States) -> Join:
        """Around cones what is found at once, else with care; without, with care as it lasts."""
        keeps_out = self.scenario.keeps_out
        if self.scenario.slew.objective == "minimum_time" and not keeps_out:
            join = self._with_care(way, from_row, state)
            if join is None:
                join = slew_onto(self.scenario, way, from_row, state, thorough=False, early=False)
                join = replace(join, search_truncated=True)
            return join
        try:
            return slew_onto(self.scenario, way, from_row, state, thorough=False, early=False)
        except InfeasibleSlew as refusal:
            shut = refusal
        careful = self._with_care(way, from_row, state, early=False) if keeps_out else None
        if careful is None:
            raise shut
        return careful

    def _with_care(
        self, way: Way, from_row: int, state: States, *, early: bool = True
    ) -> Join | None:
        """None where the work that may be done with care ends before anything is found."""
        join = None
        with at_most(min(CARE_MOST, self._care_left)) as care:
            try:
                join = slew_onto(self.scenario, way, from_row, state, early=early)
            finally:
                self._care_left -= care.done_rows
        self._is_search_truncated |= join is None
        return join

    def hurry(self) -> None:
        """From now on whatever is found at once will do."""
        self._care_left = 0.0
        self._is_search_truncated = True

    def improve(self, steps: Steps, joins: list[Join]) -> list[Join]:
        """The same chain around cones, as early and as smooth as is found.

        Each within its share of the work that is left; what isn't bettered by then stays.
        """
        if not self.scenario.keeps_out:
            return joins
        better = []
        share = CARE_SHARE * effort.remaining() / len(joins)
        for number, (step, join) in enumerate(zip(steps, joins, strict=True)):
            way = replace(step.way, rows=replace(step.way.rows, start=step.join_row))
            state = self.state(self.stand(steps[:number]).way, step.leave_row)
            found = replace(join, search_truncated=True)
            with at_most(share):
                try:
                    found = slew_onto(self.scenario, way, step.leave_row, state)
                except InfeasibleSlew:  # a search from other guesses may miss what was found
                    found = join
            search_truncated = found.search_truncated or self._is_search_truncated
            better.append(replace(found, stop_row=join.stop_row, search_truncated=search_truncated))
        return better

    def stand(self, steps: Steps) -> Stand:
        """Where the next slew begins."""
        return steps[-1] if steps else Stand(way=None, join_row=0)

    def cheapest(self, eighths: tuple[int, ...], count: int | None = None) -> Steps | None:
        """Dynamic programme over the ways of each session; None when no chain of ways fits."""
        chains: list[Steps] = [()]
        for ways in self.sessions[:count]:
            longer: list[Steps] = []
            for way in ways:
                options = [
                    (*before, step)
                    for before in chains
                    if (step := self._step(self.stand(before), way, eighths)) is not None
                ]
                if options:
                    longer.append(min(options, key=_cost))
            chains = longer
        return min(chains, key=_cost, default=None)

    def _step(self, stand: Stand, way: Way, eighths: tuple[int, ...]) -> ChainStep | None:
        """Worked out again only where solving has barred more since."""
        pair = (stand.way, way)
        known = (pair, stand.join_row, eighths, len(self._barred.get(pair, ())))
        if known not in self._steps:
            self._steps[known] = self._new_step(stand, way, eighths)
        return self._steps[known]

    def _new_step(self, stand: Stand, way: Way, eighths: tuple[int, ...]) -> ChainStep | None:
        whole = (stand.last_row, way.rows.start)
        rows = whole if self._fits_as_asked(stand, way) else self._share_loss(stand, way, eighths)
        if rows is None:
            return None
        leave_row, join_row = rows
        here, there = self.state(stand.way, leave_row), self.state(way, join_row)
        return ChainStep(
            way=way,
            leave_row=leave_row,
            join_row=join_row,
            lost_rows=stand.last_row - leave_row + join_row - way.rows.start,
            slew_s=least_slew_s(here, there, self.scenario.axis_limits),
        )

    def _fits(self, stand: Stand, way: Way, leave_row: int, join_row: int) -> bool:
        """Whether nothing known forbids the slew, and something is left of both sessions."""
        is_open = self._is_open(stand, way, leave_row, join_row)
        return is_open and self._may_slew(stand.way, way, leave_row, join_row)

    def _try_slew(self, left: Way | None, way: Way, leave_row: int, join_row: int) -> bool:
        there = self.state(way, join_row)
        state = self.state(left, leave_row)
        return may_slew_between(self.scenario, state, there, join_row - leave_row)

    def _is_open(self, stand: Stand, way: Way, leave_row: int, join_row: int) -> bool:
        """Whether solving has not barred it, and something is left of both sessions."""
        barred = self._barred.get((stand.way, way), set())
        if (leave_row, join_row) in barred or len(barred) >= TRIES_PER_PAIR:
            return False
        if join_row - leave_row < self._shut.get((stand.way, way), 0):
            return False
        in_order = stand.join_row <= leave_row < join_row
        return in_order and self._leaves_something(stand, way, leave_row, join_row)

    def _fits_as_asked(self, stand: Stand, way: Way) -> bool:
        """The same where nothing is given up; an earlier row may be within reach even then."""
        rows = (stand.last_row, way.rows.start)
        if not self._is_open(stand, way, *rows):
            return False
        if self._fits(stand, way, *rows):
            return True
        return self._first_row_in_reach(stand.way, way, stand.last_row) is not None

    def _seek_row_in_reach(self, left: Way | None, way: Way, leave_row: int) -> int | None:
        state = self.state(left, leave_row)
        return first_row_in_reach(self.scenario, way, leave_row, state, way.rows.start)

    def state(self, way: Way | None, row: int) -> States:
        """Of the axes on a row of a way's track; without a way, the initial one."""
        return self._initial if way is None else self._track_states(way, row)

    def _leaves_something(self, stand: Stand, way: Way, leave_row: int, join_row: int) -> bool:
        least_s = COMMAND_STEP_S - GRID_TOLERANCE_S
        if stand.way and self._left_s(stand.way, stand.join_row, leave_row) <= least_s:
            return False
        return self._left_s(way, join_row, way.rows.stop) > least_s

    def _left_s(self, way: Way, join_row: int, stop_row: int) -> float:
        """Of a session between the rows at which its track is joined and left."""
        start_s, stop_s = self._session_span_s(way)
        return min(stop_s, stop_row / ROWS_PER_S) - max(start_s, join_row / ROWS_PER_S)

    def _share_loss(
        self, stand: Stand, way: Way, eighths: tuple[int, ...]
    ) -> tuple[int, int] | None:
        """The rows of least loss, of which the stand's session bears one of the given eighths."""

        def fitting(loss: int) -> tuple[int, int] | None:
            for share in eighths:
                early = round(loss * share / SPLITS)
                rows = (stand.last_row - early, way.rows.start + loss - early)
                if self._fits(stand, way, *rows):
                    return rows
            return None

        overlap = max(stand.last_row - way.rows.start, 0)
        most = stand.last_row - stand.join_row + way.rows.stop - way.rows.start
        low, high, found = overlap, overlap + 1, fitting(overlap + 1)
        while found is None:
            low, high = high, overlap + 2 * (high - overlap)
            if low > most:
                return None
            found = fitting(high)
        while high - low > 1:
            middle = (low + high) // 2
            nearer = fitting(middle)
            if nearer is None:
                low = middle
            else:
                high, found = middle, nearer
        return found


def _cost(steps: Steps) -> tuple[int, float]:
    """Ways that differ in the axis that waits for the other cost the same: the first is taken."""
    return sum(step.lost_rows for step in steps), round(sum(step.slew_s for step in steps), 6)
