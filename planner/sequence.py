"""Which way is every session held, and when is each joined and left?"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from planner.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.errors import (
    GiveUp,
    InfeasibleSlew,
    NotVisible,
    SolverFailed,
    TrackBreaksLimit,
    Unreachable,
)
from planner.frames.time_scales import elapsed_s
from planner.gimbal.keep_out import keep_out_view
from planner.joining import (
    GRID_TOLERANCE_S,
    Join,
    Way,
    flown_span,
    joined,
    may_be_slewed,
    ways_to_hold,
)
from planner.nearest_start import refused_with_nearest_start
from planner.orbits import Ephemeris
from planner.scenario import Scenario
from planner.slew import (
    BACKENDS,
    AxisState,
    next_duration_s,
    require_brakable,
    track_states,
)
from planner.targets import BenchMotionTarget

SPLITS = 8  # how finely a loss is shared between two sessions
TRIES_PER_PAIR = 6  # rows at which one slew is tried; the solver needs a row or two more at most
States = tuple[AxisState, ...]


@dataclass(frozen=True, kw_only=True)
class _Stand:
    """Where a slew begins: on a session's way, joined at `join_row`, or at rest in row 0."""

    way: Way | None
    join_row: int
    initial: States

    @property
    def last_row(self) -> int:
        return self.way.rows.stop if self.way else self.join_row

    def state(self, row: int) -> States:
        return track_states(self.way.track, row / ROWS_PER_S) if self.way else self.initial


@dataclass(frozen=True, kw_only=True)
class _Step:
    """From a stand to a way: the rows it is left and joined at, and what that costs."""

    way: Way
    leave_row: int
    join_row: int
    lost_rows: int
    slew_s: float


Steps = tuple[_Step, ...]
Pair = tuple[int, int]  # identities of the ways left and joined
Resolve = Callable[["_Sequence", _Stand, Way], tuple[int, int] | None]


def initial_state(scenario: Scenario) -> States:
    """The platform at row 0, axis by axis."""
    motions = (scenario.initial_motion(axis) for axis in scenario.platform.axis_names)
    return tuple(
        AxisState(angle_rad=float(q), rate_rad_s=float(v), acceleration_rad_s2=float(a))
        for q, v, a in motions
    )


def sequenced(scenario: Scenario, ephemeris: Ephemeris) -> list[Join]:
    """A slew and a track for every session, in order.

    Of all choices of branch and whole turns the one with the least time slewing is taken,
    after the least time lost to sessions where `on_conflict` allows some to be lost.
    Raises NotVisible, Unreachable, TrackBreaksLimit and InfeasibleSlew, each with the
    nearest start that can be flown; the last with what each session would have to give up.
    """
    state = initial_state(scenario)
    if BACKENDS[scenario.slew.method].keeps_limits:
        require_brakable(scenario.platform.axis_names, state, scenario.axis_limits)
    _require_start_outside_cones(scenario, ephemeris)
    sequence = _Sequence(scenario, _ways_by_session(scenario, ephemeris))
    flown = sequence.flown(scenario.on_conflict)
    if flown is None:
        raise _conflict(sequence)
    return flown[1]


def _require_start_outside_cones(scenario: Scenario, ephemeris: Ephemeris) -> None:
    view = keep_out_view(scenario, ephemeris, 0.0, COMMAND_STEP_S)
    if view is None:
        return
    angle_rad = np.array([[axis.angle_rad for axis in initial_state(scenario)]])
    depth_rad = view.depths_rad(np.zeros(1), angle_rad)[:, 0]
    worst = int(np.argmax(depth_rad))
    if depth_rad[worst] > 0.0:
        raise InfeasibleSlew(
            f"the platform begins {math.degrees(depth_rad[worst]):.2f} deg inside the cone about "
            f"{view.cones[worst].about}; begin with other angles, or leave the cone out",
            field="initial_state.angles_deg",
            limit="keep_out",
            at_utc=scenario.initial_state.epoch,
        )


def _ways_by_session(scenario: Scenario, ephemeris: Ephemeris) -> list[tuple[Way, ...]]:
    state, from_row = initial_state(scenario), 0
    sessions: list[tuple[Way, ...]] = []
    for number, session in enumerate(scenario.sessions):
        angle_rad = np.array([axis.angle_rad for axis in state])
        try:
            ways = ways_to_hold(scenario, ephemeris, number, session, from_row, angle_rad)
        except (NotVisible, Unreachable, TrackBreaksLimit) as refusal:
            if isinstance(session.target, BenchMotionTarget):
                raise  # the same at any other time
            raise refused_with_nearest_start(scenario, number, from_row, state, refusal) from None
        sessions.append(ways)
        from_row = ways[0].rows.stop
        state = track_states(ways[0].track, from_row / ROWS_PER_S)
    return sessions


class _Sequence:
    """The ways of each session, and the slews between them that solving found impossible."""

    def __init__(self, scenario: Scenario, sessions: list[tuple[Way, ...]]) -> None:
        self.scenario = scenario
        self.sessions = sessions
        self._barred: dict[Pair, set[tuple[int, int]]] = {}
        self._joins: dict[tuple[Pair, int, int], Join] = {}
        self._steps: dict[tuple[Pair, int, Resolve, int], _Step | None] = {}

    def flown(self, mode: str, count: int | None = None) -> tuple[Steps, list[Join]] | None:
        """The cheapest steps of the first `count` sessions, all, whose slews are all found."""
        while (steps := self.cheapest(CONFLICTS[mode], count)) is not None:
            joins: list[Join] = []
            for number, step in enumerate(steps):
                join = self._joined(self.stand(steps[:number]), step)
                if join is None:
                    break
                if joins:
                    joins[-1] = replace(joins[-1], stop_row=step.leave_row)
                joins.append(join)
            else:
                return steps, joins
        return None

    def _joined(self, stand: _Stand, step: _Step) -> Join | None:
        """Solved once, whichever mode asks; None: undecided by closed form, then impossible."""
        pair, rows = (id(stand.way), id(step.way)), (step.leave_row, step.join_row)
        if (pair, *rows) not in self._joins:
            way = replace(step.way, rows=replace(step.way.rows, start=step.join_row))
            state = stand.state(step.leave_row)
            try:
                self._joins[pair, *rows] = joined(self.scenario, way, step.leave_row, state)
            except InfeasibleSlew:
                self._barred.setdefault(pair, set()).add(rows)
                return None
        return self._joins[pair, *rows]

    def stand(self, steps: Steps) -> _Stand:
        """Where the next slew begins."""
        initial = initial_state(self.scenario)
        if not steps:
            return _Stand(way=None, join_row=0, initial=initial)
        return _Stand(way=steps[-1].way, join_row=steps[-1].join_row, initial=initial)

    def cheapest(self, resolve: Resolve, count: int | None = None) -> Steps | None:
        """Dynamic programme over the ways of each session; None when no chain of ways fits."""
        chains: list[Steps] = [()]
        for ways in self.sessions[:count]:
            longer: list[Steps] = []
            for way in ways:
                options = [
                    (*chain, step)
                    for chain in chains
                    if (step := self._step(self.stand(chain), way, resolve)) is not None
                ]
                if options:
                    longer.append(min(options, key=_cost))
            chains = longer
        return min(chains, key=_cost, default=None)

    def _step(self, stand: _Stand, way: Way, resolve: Resolve) -> _Step | None:
        """Worked out again only where solving has barred more since."""
        pair = (id(stand.way), id(way))
        known = (pair, stand.join_row, resolve, len(self._barred.get(pair, ())))
        if known not in self._steps:
            self._steps[known] = self._new_step(stand, way, resolve)
        return self._steps[known]

    def _new_step(self, stand: _Stand, way: Way, resolve: Resolve) -> _Step | None:
        asked = (stand.last_row, way.rows.start)
        rows = asked if self.fits(stand, way, *asked) else resolve(self, stand, way)
        if rows is None:
            return None
        leave_row, join_row = rows
        there = track_states(way.track, join_row / ROWS_PER_S)
        least_s = [
            next_duration_s(*ends, 0.0)
            for ends in zip(stand.state(leave_row), there, self.scenario.axis_limits, strict=True)
        ]
        return _Step(
            way=way,
            leave_row=leave_row,
            join_row=join_row,
            lost_rows=stand.last_row - leave_row + join_row - way.rows.start,
            slew_s=max(0.0 if least is None else least for least in least_s),
        )

    def fits(self, stand: _Stand, way: Way, leave_row: int, join_row: int) -> bool:
        """Whether nothing known forbids the slew, and something is left of both sessions."""
        barred = self._barred.get((id(stand.way), id(way)), set())
        if (leave_row, join_row) in barred or len(barred) >= TRIES_PER_PAIR:
            return False
        if not stand.join_row <= leave_row < join_row or not self._leaves_something(
            stand, way, leave_row, join_row
        ):
            return False
        later = replace(way, rows=replace(way.rows, start=join_row))
        return may_be_slewed(self.scenario, later, leave_row, stand.state(leave_row))

    def _leaves_something(self, stand: _Stand, way: Way, leave_row: int, join_row: int) -> bool:
        epoch_utc = self.scenario.initial_state.epoch
        spans = [flown_span(way.session, epoch_utc, join_row, way.rows.stop)]
        if stand.way is not None:
            spans.append(flown_span(stand.way.session, epoch_utc, stand.join_row, leave_row))
        return all(
            elapsed_s(stop_utc, start_utc) > COMMAND_STEP_S - GRID_TOLERANCE_S
            for start_utc, stop_utc in spans
        )


def _cost(steps: Steps) -> tuple[int, float]:
    return sum(step.lost_rows for step in steps), sum(step.slew_s for step in steps)


def _refuse(sequence: _Sequence, stand: _Stand, way: Way) -> None:
    """Nothing is given up."""


def _shorten_later(sequence: _Sequence, stand: _Stand, way: Way) -> tuple[int, int] | None:
    """The later session begins late."""
    return _shared(sequence, stand, way, (0,))


def _shorten_earlier(sequence: _Sequence, stand: _Stand, way: Way) -> tuple[int, int] | None:
    """The earlier session ends early."""
    return _shared(sequence, stand, way, (SPLITS,))


def _least_loss(sequence: _Sequence, stand: _Stand, way: Way) -> tuple[int, int] | None:
    """Both give something, so that the sum is least."""
    return _shared(sequence, stand, way, tuple(range(SPLITS + 1)))


CONFLICTS: dict[str, Resolve] = {
    "refuse": _refuse,
    "shorten_later": _shorten_later,
    "shorten_earlier": _shorten_earlier,
    "least_loss": _least_loss,
}


def _shared(
    sequence: _Sequence, stand: _Stand, way: Way, eighths: tuple[int, ...]
) -> tuple[int, int] | None:
    """The rows of least loss, of which the earlier session bears one of the given eighths."""

    def fitting(loss: int) -> tuple[int, int] | None:
        for share in eighths:
            early = round(loss * share / SPLITS)
            rows = (stand.last_row - early, way.rows.start + loss - early)
            if sequence.fits(stand, way, *rows):
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


def _conflict(sequence: _Sequence) -> InfeasibleSlew:
    """The refusal of the first session that can't be joined in time, and what would help."""
    scenario = sequence.scenario
    steps: Steps = ()
    for number in range(len(sequence.sessions)):
        longer = sequence.flown(scenario.on_conflict, number + 1)
        if longer is None:
            break
        steps = longer[0]
    stand = sequence.stand(steps)
    state = stand.state(stand.last_row)
    refusal = _refused(sequence, number, stand)
    found = refused_with_nearest_start(scenario, number, stand.last_row, state, refusal)
    found.give_up = tuple(
        offer
        for mode in CONFLICTS
        if (instead := sequence.flown(mode, number + 1)) is not None
        for offer in _given_up(mode, instead[0])
    )
    return found


def _refused(sequence: _Sequence, number: int, stand: _Stand) -> InfeasibleSlew:
    for way in sequence.sessions[number]:
        try:
            joined(sequence.scenario, way, stand.last_row, stand.state(stand.last_row))
        except InfeasibleSlew as refusal:
            return _with_mode(refusal, sequence.scenario.on_conflict) if stand.way else refusal
    raise SolverFailed(
        f"the slew to session {number} was found impossible and then possible",
        field=f"sessions.{number}.start",
    )


def _with_mode(refusal: InfeasibleSlew, mode: str) -> InfeasibleSlew:
    """The same, saying that giving something up as asked doesn't help."""
    if mode == "refuse":
        return refusal
    return InfeasibleSlew(
        f'{refusal.detail}; "on_conflict": "{mode}" finds no slew that leaves '
        f"{COMMAND_STEP_S} s of each session",
        axis=refusal.axis,
        limit=refusal.limit,
    )


def _given_up(mode: str, steps: Steps) -> list[GiveUp]:
    """What each session loses; a session's start is its own step's, its stop the next one's."""
    later_s = [(step.join_row - step.way.rows.start) / ROWS_PER_S for step in steps]
    earlier_s = [
        (before.way.rows.stop - step.leave_row) / ROWS_PER_S for before, step in pairwise(steps)
    ] + [0.0]
    return [
        GiveUp(on_conflict=mode, session=session, start_later_s=later, stop_earlier_s=earlier)
        for session, (later, earlier) in enumerate(zip(later_s, earlier_s, strict=False))
        if later or earlier
    ]
