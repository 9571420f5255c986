"""How do chosen looks become one attitude for every instant?  Holds, turns, scans.

Orbital orientation until the first turn must begin and after the last one; between looks a
turn onto the next scan's profile, which is then ridden until the camera starts.
"""

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.commands import ROWS_PER_S
from planner.frames.time_scales import shifted_utc
from planner.spacecraft.imaging.candidates import Candidate, ImagingSession, on_ticks
from planner.spacecraft.imaging.ground_arc import GroundArc, fitted_profile
from planner.spacecraft.mrp import BodyMotion
from planner.spacecraft.table import TICK_S, ImagingWindow
from planner.spacecraft.turns.turn_choice import TurnComparison, TurnNeedsTime, compare, turn_onto
from planner.spacecraft.turns.turn_problem import EndState, Turn, TurnProblem
from planner.spacecraft.vehicle.definition import TurnObjective

LEAST_MORE_TICKS = 3
REST_AFTER_S = 150.0  # longer pauses are spent in orbital orientation


class Attitudes(Protocol):
    """What every stretch of the timeline answers: eci_from_body and rates at instants (m,)."""

    def at(self, t_s: Array) -> tuple[Rotation, BodyMotion]: ...


@dataclass(frozen=True, kw_only=True)
class ScanLook:
    """One stretch of imaging: rows first_row .. last_row scan the arc."""

    candidate: int
    request: int
    arc: GroundArc
    first_row: int
    last_row: int


@dataclass(frozen=True, kw_only=True)
class PlannedTurn:
    """A turn from row first_row to last_row; look: the number of the one it leads to, None for
    orbital orientation."""

    first_row: int
    last_row: int
    start_utc: datetime
    look: int | None
    comparison: TurnComparison


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """Attitudes of all rows: (n,) and (n, 3), with what they are made of."""

    attitude: Rotation
    motion: BodyMotion
    looks: tuple[ScanLook, ...]
    turns: tuple[PlannedTurn, ...]
    windows: tuple[ImagingWindow, ...]


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """A turn with too little time: between which candidates (None: the session's ends), and
    how many ticks apart they should be."""

    before: int | None
    after: int | None
    ticks: int
    why: TurnNeedsTime


class TurnsDoNotFit(Exception):
    """Every misfit of a timeline."""

    def __init__(self, misfits: Sequence[Misfit]) -> None:
        super().__init__("; ".join(one.why.detail for one in misfits))
        self.misfits = tuple(misfits)


Outcome = Turn | TurnNeedsTime


def looks_of(candidates: Sequence[Candidate], chosen: Sequence[int]) -> tuple[ScanLook, ...]:
    """The arcs of the chosen candidates in order of time."""
    looks = [
        ScanLook(
            candidate=k,
            request=candidates[k].request,
            arc=arc,
            first_row=round(arc.start_s / TICK_S),
            last_row=round(arc.start_s / TICK_S) + on_ticks(arc),
        )
        for k in chosen
        for arc in candidates[k].arcs
    ]
    return tuple(sorted(looks, key=lambda look: look.first_row))


class _Builder:
    """Collects stretches in order; `now` is the last row decided."""

    def __init__(
        self,
        session: ImagingSession,
        momentum_eci_n_m_s: Array,
        objective: TurnObjective,
        known: dict[Hashable, Outcome],
    ) -> None:
        self.known = known
        self.session = session
        self.momentum_eci_n_m_s = momentum_eci_n_m_s
        self.objective = objective
        self.stretches: list[tuple[int, Attitudes]] = []
        self.turns: list[PlannedTurn] = []
        self.misfits: list[Misfit] = []
        self.now = 0
        self.profile: Attitudes = self.orbital(0, self.last_row)

    @property
    def last_row(self) -> int:
        return round(self.session.duration_s / TICK_S)

    def orbital(self, first_row: int, last_row: int) -> Attitudes:
        return fitted_profile(
            None,
            self.session.ephemeris,
            self.session.epoch_utc,
            (first_row * TICK_S - 1.0, last_row * TICK_S + 1.0),
        )

    def scan(self, arc: GroundArc, first_row: int, last_row: int) -> Attitudes:
        return fitted_profile(
            arc,
            self.session.ephemeris,
            self.session.epoch_utc,
            (first_row * TICK_S - 1.0, last_row * TICK_S + 1.0),
        )

    def hold(self, until_row: int) -> None:
        self.stretches.append((until_row, self.profile))
        self.now = until_row

    def turn(
        self,
        goal: Attitudes,
        latest_row: int,
        look: int | None,
        between: tuple[ScanLook | None, ScanLook | None],
        *,
        late: bool,
    ) -> None:
        """Turn onto the goal, leaving now and arriving when done, or (late) arriving at
        latest_row and leaving as late as that allows.  Solved turns are kept for the next
        attempt at the timeline; one that doesn't fit is noted and taken for done."""
        available_s = (latest_row - self.now) * TICK_S

        def problem_at(duration_s: float) -> TurnProblem:
            rows = round(duration_s / TICK_S)
            start_row = latest_row - rows if late else self.now
            return self.problem(goal, start_row, start_row + rows)

        key = (between, look, self.now, latest_row)
        turn = self.known.get(key)
        if turn is None:
            turn = _outcome(problem_at, available_s, self.objective)
            self.known[key] = turn
        if isinstance(turn, TurnNeedsTime):
            self.misfits.append(self.misfit(between, turn))
            self.now, self.profile = latest_row, goal
            return
        rows = round(turn.duration_s / TICK_S)
        if late:
            self.hold(latest_row - rows)
        problem = problem_at(turn.duration_s)
        start_s = self.now * TICK_S
        self.turns.append(
            PlannedTurn(
                first_row=self.now,
                last_row=self.now + rows,
                start_utc=shifted_utc(self.session.epoch_utc, start_s),
                look=look,
                comparison=compare(problem, turn),
            )
        )
        self.stretches.append((self.now + rows, _Shifted(turn.at, start_s)))
        self.now += rows
        self.profile = goal

    def misfit(
        self, between: tuple[ScanLook | None, ScanLook | None], why: TurnNeedsTime
    ) -> Misfit:
        before, after = between
        start_row = 0 if before is None else before.last_row
        stop_row = self.last_row if after is None else after.first_row
        short = math.ceil(why.missing_s / TICK_S - 1e-6)
        return Misfit(
            before=None if before is None else before.candidate,
            after=None if after is None else after.candidate,
            ticks=stop_row - start_row + max(short, LEAST_MORE_TICKS),
            why=why,
        )

    def problem(self, goal: Attitudes, start_row: int, end_row: int) -> TurnProblem:
        spacecraft = self.session.spacecraft
        return TurnProblem(
            start=_state(self.profile, start_row),
            end=_state(goal, end_row),
            momentum_eci_n_m_s=self.momentum_eci_n_m_s,
            inertia_kg_m2=np.array(spacecraft.inertia_kg_m2),
            limits=spacecraft.slew,
        )


@dataclass(frozen=True, eq=False)
class InertialHold:
    """A fixed attitude, eci_from_body."""

    attitude: Rotation

    def at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        still = np.zeros((len(t_s), 3))
        return Rotation.concatenate([self.attitude] * len(t_s)), BodyMotion(still, still, still)


@dataclass(frozen=True, eq=False)
class _Shifted:
    """A turn on the session's clock."""

    of: Callable[[Array], tuple[Rotation, BodyMotion]]
    start_s: float

    def at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        return self.of(t_s - self.start_s)


def _outcome(
    problem_at: Callable[[float], TurnProblem], available_s: float, objective: TurnObjective
) -> Outcome:
    try:
        return turn_onto(problem_at, available_s, objective)
    except TurnNeedsTime as why:
        return why


def _state(profile: Attitudes, row: int) -> EndState:
    attitude, motion = profile.at(np.array([row * TICK_S]))
    return EndState(
        attitude=attitude[0],
        omega_body_rad_s=motion.omega_body_rad_s[0],
        alpha_body_rad_s2=motion.alpha_body_rad_s2[0],
    )


def build_timeline(
    session: ImagingSession,
    looks: tuple[ScanLook, ...],
    names: Sequence[str],
    gyro_momentum_n_m_s: Array,
    objective: TurnObjective,
    initial: InertialHold | None = None,
    known: dict[Hashable, Outcome] | None = None,
) -> Timeline:
    """Fly the looks in order.  Raises TurnsDoNotFit with every pair that needs more time.

    initial: leave this attitude for orbital orientation at once (None: begin in that).
    known: turns solved in earlier attempts at the same session, kept by the caller.
    """
    rest = fitted_profile(None, session.ephemeris, session.epoch_utc, (-1.0, 30.0))
    attitude, motion = (initial or rest).at(np.zeros(1))
    inertia = np.array(session.spacecraft.inertia_kg_m2)
    total = attitude[0].apply(inertia * motion.omega_body_rad_s[0] + gyro_momentum_n_m_s)
    builder = _Builder(session, total, objective, {} if known is None else known)
    if initial is not None:
        orbital = builder.profile
        builder.profile = initial
        until = looks[0].first_row // 2 if looks else builder.last_row
        between = (None, looks[0] if looks else None)
        builder.turn(orbital, until, None, between, late=False)
    before: ScanLook | None = None
    for number, look in enumerate(looks):
        _onto(builder, before, look, number)
        builder.hold(look.last_row + 1)
        before = look
    if before is not None:
        back = builder.orbital(builder.now, builder.last_row)
        builder.turn(back, builder.last_row, None, (before, None), late=False)
    builder.hold(builder.last_row)
    if builder.misfits:
        raise TurnsDoNotFit(builder.misfits)
    return _assembled(builder, looks, names)


def _onto(builder: _Builder, before: ScanLook | None, look: ScanLook, number: int) -> None:
    """Turn onto a look, by way of orbital orientation after a long pause."""
    settle_rows = math.ceil(builder.session.spacecraft.slew.settle_s / TICK_S - 1e-6)
    arrive_row = look.first_row - settle_rows
    pause_s = 0.0 if before is None else (look.first_row - before.last_row) * TICK_S
    if pause_s > REST_AFTER_S:
        rest = builder.orbital(builder.now, look.first_row)
        halfway = builder.now + (arrive_row - builder.now) // 2
        builder.turn(rest, halfway, None, (before, look), late=False)
    # A scan's profile is continued backwards only so far: beyond, it leaves the ground.
    begin = max(builder.now, look.first_row - round(REST_AFTER_S / TICK_S))
    goal = builder.scan(look.arc, begin, look.last_row + 1)
    resting = before is None or pause_s > REST_AFTER_S
    builder.turn(goal, arrive_row, number, (before, look), late=resting)


def _assembled(builder: _Builder, looks: tuple[ScanLook, ...], names: Sequence[str]) -> Timeline:
    attitudes, motions, row = [], [], 0
    for until, stretch in builder.stretches:
        rows = np.arange(row, until + (until == builder.last_row))
        if len(rows):
            attitude, motion = stretch.at(rows / ROWS_PER_S)
            attitudes.append(attitude)
            motions.append(motion)
            row = int(rows[-1]) + 1
    counted: dict[int, int] = {}
    windows = []
    for look in looks:
        number = counted.get(look.request, 0)
        counted[look.request] = number + 1
        windows.append(
            ImagingWindow(
                request=names[look.request],
                look=number,
                first_row=look.first_row,
                last_row=look.last_row,
            )
        )
    return Timeline(
        attitude=Rotation.concatenate(attitudes),
        motion=BodyMotion(*(np.concatenate(column) for column in zip(*motions, strict=True))),
        looks=looks,
        turns=tuple(builder.turns),
        windows=tuple(windows),
    )
