"""When is the nearest start at which a refused session can be flown?"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from datetime import datetime
from itertools import islice
from typing import NamedTuple, TypeVar

import numpy as np

from planner.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.errors import (
    InfeasibleSlew,
    NotVisible,
    OutsideCoverage,
    Refusal,
    TrackBreaksLimit,
    Unreachable,
)
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.joining import Rows, Way, joined, may_be_slewed, session_rows, ways_to_hold
from planner.orbits import Ephemeris
from planner.scenario import Scenario, Session
from planner.slew import AxisState
from planner.targets import BenchMotionTarget, Target, TimedTarget

DAY_S = 86400.0
HORIZON_S = {"state": 6000.0, "opm": 6000.0}  # a numerical propagation of a day takes seconds
COARSE_ROWS = 10 * ROWS_PER_S  # first tries, then halved down to a row
ATTEMPTS = 60  # each takes some 10 ms; a refusal may take a second, not a minute

ROWS_LATER = 3  # the solver needs a row or two more than closed forms say
SOLVED_MOST = 3  # each takes some 100 ms, near the stops a second

Attempt = Callable[[int], Session | None]
_Test = Callable[[Scenario, Way, int, tuple[AxisState, ...]], bool]
R = TypeVar("R", bound=Refusal)


class _Tries(NamedTuple):
    """The session from a start row on, if it may (closed forms) or can (solved) be flown."""

    may: Attempt
    can: Attempt


def refused_with_nearest_start(
    scenario: Scenario,
    number: int,
    from_row: int,
    state: tuple[AxisState, ...],
    refusal: R,
) -> R:
    """The same refusal with the field at fault and the nearest start that can be flown.

    First the session is cut short at its start, then moved as a whole, by at most a day.
    Every start named has been tried by planning the session there.
    """
    moved = _nearest(scenario, number, from_row, state)
    session = scenario.sessions[number]
    if moved is None:
        way_out = "no start that can be flown was found within a day or reach of the orbit data"
    else:
        kept = (
            "keeping the stop"
            if moved.stop == session.stop
            else f"with the stop moved to {utc_text(moved.stop, 1)}"
        )
        way_out = f"earliest feasible start {utc_text(moved.start, 1)}, {kept}"
    return type(refusal)(
        f"{refusal.detail}; {way_out}",
        field=refusal.field or f"sessions.{number}.start",
        axis=refusal.axis,
        limit=refusal.limit,
        at_utc=refusal.at_utc,
        earliest_feasible_start_utc=moved.start if moved else None,
        feasible_stop_utc=moved.stop if moved else None,
    )


def _nearest(
    scenario: Scenario, number: int, from_row: int, state: tuple[AxisState, ...]
) -> Session | None:
    session = scenario.sessions[number]
    epoch_utc = scenario.initial_state.epoch
    wanted = session_rows(session, epoch_utc)
    span = _span(scenario, wanted, from_row)
    if span is None:
        return None
    ephemeris, known = span
    seen = _seen(scenario, ephemeris, session, known)
    target = _unbound(session)

    def tries_with(stop_row: Callable[[int], int], stop: Callable[[int], datetime]) -> _Tries:
        def moved_to(start_row: int) -> Session | None:
            if not any(run.start <= start_row and stop_row(start_row) <= run.stop for run in seen):
                return None
            start_utc = shifted_utc(epoch_utc, start_row / ROWS_PER_S)
            if elapsed_s(stop(start_row), start_utc) < COMMAND_STEP_S:
                return None
            return replace(
                session,
                target=target,
                start=start_utc,
                stop=stop(start_row),
                keyhole="refuse",  # a start that needs no compromise, and no second of solving
            )

        def attempt(test: _Test) -> Attempt:
            def tried(start_row: int) -> Session | None:
                moved = moved_to(start_row)
                if moved is None or start_row <= from_row:
                    return None
                ways = _ways(scenario, ephemeris, number, moved, from_row, state)
                return moved if any(test(scenario, way, from_row, state) for way in ways) else None

            return tried

        return _Tries(may=attempt(may_be_slewed), can=attempt(_can_be_slewed))

    cut_short = tries_with(lambda _: wanted.stop, lambda _: session.stop)
    length_s = elapsed_s(session.stop, session.start)
    length_rows = wanted.stop - wanted.start
    shift = tries_with(
        lambda row: row + length_rows,
        lambda row: shifted_utc(epoch_utc, row / ROWS_PER_S + length_s),
    )
    first = max(wanted.start, from_row + 1)
    step = min(COARSE_ROWS, max((wanted.stop - first) // 8, 1))
    found = _search(cut_short, range(first, wanted.stop, step), wanted.start)
    if found is None:
        found = _search(shift, _by_distance(seen, length_rows, wanted.start), wanted.start)
    return found


def _unbound(session: Session) -> Target:
    """The target as it was asked for: what began with the session will begin with the moved one."""
    target = session.target
    if isinstance(target, TimedTarget) and target.start == session.start:
        return replace(target, start=None)
    return target


def _ways(
    scenario: Scenario,
    ephemeris: Ephemeris,
    number: int,
    session: Session,
    from_row: int,
    state: tuple[AxisState, ...],
) -> tuple[Way, ...]:
    """No way where the session can't be held."""
    angle_rad = np.array([axis.angle_rad for axis in state])
    try:
        return ways_to_hold(scenario, ephemeris, number, session, from_row, angle_rad)
    except (NotVisible, Unreachable, TrackBreaksLimit):
        return ()


def _can_be_slewed(
    scenario: Scenario, way: Way, from_row: int, state: tuple[AxisState, ...]
) -> bool:
    if not may_be_slewed(scenario, way, from_row, state):
        return False
    try:
        joined(scenario, way, from_row, state)
    except InfeasibleSlew:
        return False
    return True


def _search(tries: _Tries, rows: Iterable[int], wanted_row: int) -> Session | None:
    """The first row that may succeed, then the nearest to the wanted one that does."""
    solved = 0
    for row in islice(rows, ATTEMPTS):
        if tries.may(row) is None:
            continue
        away = 1 if row >= wanted_row else -1
        good, bad = row, row - away * COARSE_ROWS
        while abs(good - bad) > 1:
            middle = (good + bad) // 2
            if (middle - wanted_row) * away < 0 or tries.may(middle) is None:
                bad = middle
            else:
                good = middle
        for nearest in range(good, good + away * ROWS_LATER, away):
            found = tries.can(nearest)
            if found is not None:
                return found
            solved += 1
            if solved >= SOLVED_MOST:
                return None
    return None


def _by_distance(seen: list[Rows], length_rows: int, wanted_row: int) -> list[int]:
    """Start rows of sessions wholly inside a run, the nearest to the wanted row first."""
    starts = [
        row
        for run in seen
        if run.stop - length_rows >= run.start
        for row in {*range(run.start, run.stop - length_rows, COARSE_ROWS), run.stop - length_rows}
    ]
    return sorted(starts, key=lambda row: abs(row - wanted_row))


def _span(scenario: Scenario, wanted: Rows, from_row: int) -> tuple[Ephemeris, Rows] | None:
    """The orbit as far around the session as it is known, up to the horizon."""
    epoch_utc = scenario.initial_state.epoch
    longest_s = HORIZON_S.get(scenario.orbit.source, DAY_S)
    for horizon_s in (longest_s, longest_s / 16.0, 0.0):
        # Cones to keep out of must be known along the whole slew.
        early_row = wanted.start - int(horizon_s) * ROWS_PER_S
        rows = Rows(
            start=from_row if scenario.slew.keep_out else max(from_row, early_row),
            stop=wanted.stop + int(horizon_s) * ROWS_PER_S,
        )
        start_utc = shifted_utc(epoch_utc, rows.start / ROWS_PER_S)
        try:
            ephemeris = scenario.orbit.ephemeris(
                start_utc, shifted_utc(epoch_utc, rows.stop / ROWS_PER_S)
            )
        except OutsideCoverage:
            continue
        return ephemeris, rows
    return None


def _seen(scenario: Scenario, ephemeris: Ephemeris, session: Session, known: Rows) -> list[Rows]:
    """Runs of rows in which the target can be seen, their ends good to the coarse step."""
    if isinstance(session.target, BenchMotionTarget):
        return [known]
    rows = np.arange(known.start, known.stop + 1, COARSE_ROWS)
    instants = Instants(scenario.initial_state.epoch, rows / ROWS_PER_S)
    visible = session.target.apparent(instants, ephemeris.states(instants)).clearance_rad >= 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]])))
    return [
        Rows(
            start=max(known.start, int(rows[first]) - COARSE_ROWS),
            stop=min(known.stop, int(rows[last - 1]) + COARSE_ROWS),
        )
        for first, last in edges.reshape(-1, 2)
    ]
