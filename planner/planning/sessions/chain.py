"""The cheapest chain of slews through all sessions, step by step from branch to branch."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise, product

from planner.base import effort
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew
from planner.planning.sessions.platforms.mover import Join, Mover, State, TrackBranch
from planner.planning.sessions.track_branches import OPTIONS as TRACK_BRANCH_OPTIONS
from planner.world.frames.time_scales import elapsed_s
from planner.world.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class ChainOptions:
    """How much is tried for a sequence of sessions."""

    splits: int = 8  # how finely a loss is shared between two sessions
    # of the work that is left, for what isn't found at once; then for bettering it
    care_share: float = 0.4
    care_most: int = 120_000  # for one slew: another one may do as well
    # which a slew that cones block must at least have more: a try takes a second
    blocked_rows: int = 10
    # rows at which one slew is tried; the solver needs a row or two more at most
    tries_per_pair: int = 6


OPTIONS = ChainOptions()

# Which eighths of what is lost the earlier of two sessions may bear; none: nothing is given up.
CONFLICTS: dict[str, tuple[int, ...]] = {
    "refuse": (),
    "shorten_later": (0,),
    "shorten_earlier": (OPTIONS.splits,),
    "least_loss": tuple(range(OPTIONS.splits + 1)),
}


@dataclass(frozen=True, kw_only=True)
class SlewStart:
    """The start of a slew: on a session's branch, joined at `join_row`, or initially, in row 0."""

    branch: TrackBranch | None
    join_row: int

    @property
    def last_row(self) -> int:
        return self.branch.rows.stop if self.branch else self.join_row


@dataclass(frozen=True, kw_only=True)
class SequenceStep(SlewStart):
    """A slew onto a branch: the row at which the branch before is left, and what that costs."""

    branch: TrackBranch
    leave_row: int
    lost_rows: int
    slew_s: float


Steps = tuple[SequenceStep, ...]
Pair = tuple[TrackBranch | None, TrackBranch]  # left and joined


class Chain:
    """The branches of each session, and the slews between them that solving found impossible.

    Results are kept, by branches and by rows: each search goes over it again.
    """

    def __init__(
        self,
        scenario: Scenario,
        mover: Mover,
        initial: State,
        sessions: list[tuple[TrackBranch, ...]],
    ) -> None:
        self.scenario, self.mover, self.sessions = scenario, mover, sessions
        self._infeasible_rows: dict[Pair, set[tuple[int, int]]] = {}
        self._joins: dict[tuple[Pair, int, int], Join] = {}
        self._steps: dict[tuple[Pair, int, tuple[int, ...], int], SequenceStep | None] = {}
        self._blocked_rows: dict[Pair, int] = {}
        self._may_slew = cache(self._try_slew)
        self._first_row_in_reach = cache(self._seek_row_in_reach)
        self._initial = initial
        epoch_utc = scenario.initial_state.epoch
        self._session_span_s = cache(
            lambda branch: [
                elapsed_s(at, epoch_utc) for at in (branch.session.start, branch.session.stop)
            ]
        )
        self._track_state = cache(mover.state_at)
        self._care_left = OPTIONS.care_share * effort.remaining()
        self._is_search_truncated = False

    def solve(self, mode: str, count: int | None = None) -> tuple[Steps, list[Join]] | None:
        """The cheapest steps of the first `count` sessions, all, whose slews are all found."""
        while (steps := self.cheapest_steps(CONFLICTS[mode], count)) is not None:
            joins: list[Join] = []
            for number, step in enumerate(steps):
                join = self._join(self.slew_start(steps[:number]), step)
                if join is None:
                    break
                if joins:
                    joins[-1] = replace(joins[-1], stop_row=step.leave_row)
                joins.append(join)
            else:
                return steps, joins
        return None

    def _join(self, slew_start: SlewStart, step: SequenceStep) -> Join | None:
        """Solved once, whichever mode asks; None: undecided by closed form, then impossible."""
        pair, rows = (slew_start.branch, step.branch), (step.leave_row, step.join_row)
        if (pair, *rows) not in self._joins:
            branch = replace(step.branch, rows=replace(step.branch.rows, start=step.join_row))
            state = self.state_at(slew_start.branch, step.leave_row)
            try:
                self._joins[pair, *rows] = self._solve_join(branch, step.leave_row, state)
            except InfeasibleSlew as refusal:
                self._infeasible_rows.setdefault(pair, set()).add(rows)
                if refusal.limit in ("keep_out", "exclusion"):
                    self._blocked_rows[pair] = step.join_row - step.leave_row + OPTIONS.blocked_rows
                elif refusal.needs_s is not None:
                    self._blocked_rows[pair] = math.ceil(refusal.needs_s * ROWS_PER_S)
                return None
        return self._joins[pair, *rows]

    def _solve_join(self, branch: TrackBranch, from_row: int, state: State) -> Join:
        """Around cones what is found at once, else with care; without, with care as it lasts."""
        keeps_out = self.scenario.keeps_out
        if self.scenario.slew.objective == "minimum_time" and not keeps_out:
            join = self._with_care(branch, from_row, state)
            if join is None:
                join = self.mover.slew_onto(branch, from_row, state, thorough=False, early=False)
                join = replace(join, search_truncated=True)
            return join
        try:
            return self.mover.slew_onto(branch, from_row, state, thorough=False, early=False)
        except InfeasibleSlew as refusal:
            blocked = refusal
        careful = self._with_care(branch, from_row, state, early=False) if keeps_out else None
        if careful is None:
            raise blocked
        return careful

    def _with_care(
        self, branch: TrackBranch, from_row: int, state: State, *, early: bool = True
    ) -> Join | None:
        """None where the work that may be done with care ends before anything is found."""
        join = None
        with at_most(min(OPTIONS.care_most, self._care_left)) as care:
            try:
                join = self.mover.slew_onto(branch, from_row, state, early=early)
            finally:
                self._care_left -= care.done_rows
        self._is_search_truncated |= join is None
        return join

    def accept_first(self) -> None:
        """Accept from now on whatever is found at once."""
        self._care_left = 0.0
        self._is_search_truncated = True

    def improve_joins(self, steps: Steps, joins: list[Join]) -> list[Join]:
        """Lead the chain around cones, as early and as smooth as is found.

        Each within its share of the work that is left; what isn't bettered by then stays.
        """
        if not self.scenario.keeps_out:
            return joins
        better = []
        share = OPTIONS.care_share * effort.remaining() / len(joins)
        for number, (step, join) in enumerate(zip(steps, joins, strict=True)):
            branch = replace(step.branch, rows=replace(step.branch.rows, start=step.join_row))
            state = self.state_at(self.slew_start(steps[:number]).branch, step.leave_row)
            found = replace(join, search_truncated=True)
            with at_most(share):
                try:
                    found = self.mover.slew_onto(branch, step.leave_row, state)
                except InfeasibleSlew:  # a search from other guesses may miss what was found
                    found = join
            search_truncated = found.search_truncated or self._is_search_truncated
            better.append(replace(found, stop_row=join.stop_row, search_truncated=search_truncated))
        return better

    def slew_start(self, steps: Steps) -> SlewStart:
        """Where the next slew begins."""
        return steps[-1] if steps else SlewStart(branch=None, join_row=0)

    def cheapest_steps(self, eighths: tuple[int, ...], count: int | None = None) -> Steps | None:
        """Dynamic programme over the branches of each session; None when no chain of branches
        fits."""
        chains: list[Steps] = [()]
        for branches in self.sessions[:count]:
            longer: list[Steps] = []
            for branch in branches:
                options = [
                    (*before, step)
                    for before in chains
                    if (step := self._step(self.slew_start(before), branch, eighths)) is not None
                ]
                if options:
                    longer.append(min(options, key=_step_cost))
            chains = longer
        return min(chains, key=_step_cost, default=None)

    def _step(
        self, slew_start: SlewStart, branch: TrackBranch, eighths: tuple[int, ...]
    ) -> SequenceStep | None:
        """Worked out again only where solving has found more rows infeasible since."""
        pair = (slew_start.branch, branch)
        known = (pair, slew_start.join_row, eighths, len(self._infeasible_rows.get(pair, ())))
        if known not in self._steps:
            self._steps[known] = self._new_step(slew_start, branch, eighths)
        return self._steps[known]

    def _new_step(
        self, slew_start: SlewStart, branch: TrackBranch, eighths: tuple[int, ...]
    ) -> SequenceStep | None:
        whole = (slew_start.last_row, branch.rows.start)
        rows = (
            whole
            if self._fits_as_asked(slew_start, branch)
            else self._share_loss(slew_start, branch, eighths)
        )
        if rows is None:
            return None
        leave_row, join_row = rows
        here, there = self.state_at(slew_start.branch, leave_row), self.state_at(branch, join_row)
        return SequenceStep(
            branch=branch,
            leave_row=leave_row,
            join_row=join_row,
            lost_rows=slew_start.last_row - leave_row + join_row - branch.rows.start,
            slew_s=self.mover.least_s(here, there),
        )

    def _may_fit(
        self, slew_start: SlewStart, branch: TrackBranch, leave_row: int, join_row: int
    ) -> bool:
        """Whether nothing known forbids the slew, and something is left of both sessions."""
        is_open = self._is_open(slew_start, branch, leave_row, join_row)
        return is_open and self._may_slew(slew_start.branch, branch, leave_row, join_row)

    def _try_slew(
        self, left: TrackBranch | None, branch: TrackBranch, leave_row: int, join_row: int
    ) -> bool:
        there = self.state_at(branch, join_row)
        state = self.state_at(left, leave_row)
        return self.mover.may_slew(state, there, join_row - leave_row)

    def _is_open(
        self, slew_start: SlewStart, branch: TrackBranch, leave_row: int, join_row: int
    ) -> bool:
        """Whether solving has not found it infeasible, and something is left of both sessions."""
        infeasible = self._infeasible_rows.get((slew_start.branch, branch), set())
        if (leave_row, join_row) in infeasible or len(infeasible) >= OPTIONS.tries_per_pair:
            return False
        if join_row - leave_row < self._blocked_rows.get((slew_start.branch, branch), 0):
            return False
        in_order = slew_start.join_row <= leave_row < join_row
        return in_order and self._leaves_something(slew_start, branch, leave_row, join_row)

    def _fits_as_asked(self, slew_start: SlewStart, branch: TrackBranch) -> bool:
        """Whether it fits with nothing given up; an earlier row may be within reach even then."""
        rows = (slew_start.last_row, branch.rows.start)
        if not self._is_open(slew_start, branch, *rows):
            return False
        if self._may_fit(slew_start, branch, *rows):
            return True
        return self._first_row_in_reach(slew_start.branch, branch, slew_start.last_row) is not None

    def _seek_row_in_reach(
        self, left: TrackBranch | None, branch: TrackBranch, leave_row: int
    ) -> int | None:
        state = self.state_at(left, leave_row)
        return self.mover.first_row_in_reach(branch, leave_row, state, branch.rows.start)

    def state_at(self, branch: TrackBranch | None, row: int) -> State:
        """How it moves on a row of a branch's track; without a branch, the initial one."""
        return self._initial if branch is None else self._track_state(branch, row)

    def hopeless_sessions(self) -> tuple[int, ...]:
        """Sessions no branch of which any slew reaches in time from the one before, both as asked.

        Closed forms show it: a lower bound of the slew's time is more than the gap between them.
        """
        return tuple(
            number
            for number, (left, joined) in enumerate(pairwise(self.sessions), start=1)
            if not any(
                self._fits_as_asked(SlewStart(branch=before, join_row=before.rows.start), branch)
                for before, branch in product(left, joined)
            )
        )

    def _leaves_something(
        self, slew_start: SlewStart, branch: TrackBranch, leave_row: int, join_row: int
    ) -> bool:
        least_s = COMMAND_STEP_S - TRACK_BRANCH_OPTIONS.grid_tolerance_s
        if (
            slew_start.branch
            and self._left_s(slew_start.branch, slew_start.join_row, leave_row) <= least_s
        ):
            return False
        return self._left_s(branch, join_row, branch.rows.stop) > least_s

    def _left_s(self, branch: TrackBranch, join_row: int, stop_row: int) -> float:
        """Seconds of a session between the rows at which its track is joined and left."""
        start_s, stop_s = self._session_span_s(branch)
        settled_s = (join_row + branch.settle_rows) / ROWS_PER_S
        return min(stop_s, stop_row / ROWS_PER_S) - max(start_s, settled_s)

    def _share_loss(
        self, slew_start: SlewStart, branch: TrackBranch, eighths: tuple[int, ...]
    ) -> tuple[int, int] | None:
        """The rows of least loss, of which the session left bears one of the given eighths."""

        def ends_at(loss: int) -> Iterator[tuple[int, int]]:
            for share in eighths:
                early = round(loss * share / OPTIONS.splits)
                yield slew_start.last_row - early, branch.rows.start + loss - early

        def fitting_rows(loss: int) -> tuple[int, int] | None:
            fitting = (rows for rows in ends_at(loss) if self._may_fit(slew_start, branch, *rows))
            return next(fitting, None)

        overlap = max(slew_start.last_row - branch.rows.start, 0)
        most, nothing_left = overlap, slew_start.last_row - slew_start.join_row
        nothing_left += branch.rows.stop - branch.rows.start + overlap + 1
        while nothing_left - most > 1:
            middle = (most + nothing_left) // 2
            if any(self._leaves_something(slew_start, branch, *rows) for rows in ends_at(middle)):
                most = middle
            else:
                nothing_left = middle
        low, high, found = overlap, overlap + 1, fitting_rows(overlap + 1)
        while found is None:
            if high >= most:
                return None
            low, high = high, min(overlap + 2 * (high - overlap), most)
            found = fitting_rows(high)
        while high - low > 1:
            middle = (low + high) // 2
            nearer = fitting_rows(middle)
            if nearer is None:
                low = middle
            else:
                high, found = middle, nearer
        return found


def _step_cost(steps: Steps) -> tuple[int, float]:
    """Ways that differ in the axis that waits for the other cost the same: the first is taken."""
    return sum(step.lost_rows for step in steps), round(sum(step.slew_s for step in steps), 6)
