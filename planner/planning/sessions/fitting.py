"""Starts of sessions that begin as soon as the slew to them lets them."""

import math
import re
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

from planner.base.commands import ROWS_PER_S
from planner.base.errors import InfeasibleSlew, Refusal
from planner.planning.sessions.platforms.mover import Mover, RowSpan, State, TrackBranch
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.track_branches import ephemeris_over, session_rows
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.scenario import Scenario, Session


@dataclass(frozen=True, kw_only=True)
class FittingOptions:
    """How a start is sought."""

    tries: int = 12  # of later starts that closed forms allow, then of slews
    longer: float = 1.15  # times as long where the solver finds none: slews take up to 1.6 times
    # the least time that closed forms tell
    row_tolerance: float = 1e-5  # of a row: 2 us


OPTIONS = FittingOptions()


def with_starts_that_fit(scenario: Scenario) -> Scenario:
    """The scenario whose sessions with `fits_by` begin when the slew to them allows.

    Each by the least slew that closed forms allow and the solver finds, one after another, so that
    a start is the soonest only to `FittingOptions.longer` of its slew.  Raises InfeasibleSlew where
    a session can't be over in time, and what the mover's `ways` does.
    """
    if all(session.fits_by is None for session in scenario.sessions):
        return scenario
    epoch_utc, mover = scenario.initial_state.epoch, mover_of(scenario)
    last_row = math.ceil(elapsed_s(scenario.last_utc, epoch_utc) * ROWS_PER_S)
    first = session_rows(scenario.sessions[0], epoch_utc)
    ephemeris = ephemeris_over(scenario, [RowSpan(start=first.start, stop=last_row)])
    state, from_row = mover.initial(ephemeris), 0
    soonest_row, gap_s = 0, scenario.conditions.min_gap_s
    sessions: list[Session] = []
    for number, session in enumerate(scenario.sessions):
        fitted = session
        try:
            if session.fits_by is not None:
                start_row = max(from_row + mover.settle_rows, soonest_row)
                fitted = _fitted(scenario, mover, ephemeris, number, from_row, start_row, state)
            sessions.append(fitted)
            soonest_s = elapsed_s(fitted.stop, epoch_utc) + gap_s
            soonest_row = math.ceil(soonest_s * ROWS_PER_S - OPTIONS.row_tolerance)
            if any(later.fits_by for later in scenario.sessions[number + 1 :]):
                branch = mover.ways(ephemeris, number, fitted, from_row, state)[0]
                from_row = branch.rows.stop
                state = mover.state_at(branch, from_row)
        except Refusal as refusal:
            refusal.field = refusal.field or f"sessions.{number}.start"
            raise
    return replace(scenario, sessions=tuple(sessions))


def _fitted(
    scenario: Scenario,
    mover: Mover,
    ephemeris: Ephemeris,
    number: int,
    from_row: int,
    start_row: int,
    state: State,
) -> Session:
    """The session at a start to which a slew was found, from start_row on."""
    session = scenario.sessions[number]
    assert session.fits_by is not None
    epoch_utc = scenario.initial_state.epoch
    row = max(session_rows(session, epoch_utc).start, start_row)
    for _ in range(OPTIONS.tries):
        moved = _moved(scenario, number, row)
        branches = mover.ways(ephemeris, number, moved, from_row, state)
        needed_s = [_needed_s(mover, state, branch) for branch in branches]
        least_s = min(needed_s)
        if math.isinf(least_s):
            break
        branch = branches[needed_s.index(least_s)]
        short_rows = math.ceil(least_s * ROWS_PER_S - 1e-6) - (branch.rows.start - from_row)
        if short_rows <= 0:
            try:
                mover.slew_onto(branch, from_row, state, thorough=False, early=False)
            except InfeasibleSlew:
                short_rows = math.ceil((OPTIONS.longer - 1.0) * (branch.rows.start - from_row))
            else:
                return moved
        row += max(short_rows, 1)
    raise InfeasibleSlew(
        f"session {number + 1}: no start was found from {utc_text(session.start)} on, to which a "
        f"slew leads from what is before it; leave it out, or plan it by itself",
        field=f"sessions.{number}.start",
        limit="duration",
    )


def _needed_s(mover: Mover, state: State, branch: TrackBranch) -> float:
    return mover.least_s(state, mover.state_at(branch, branch.rows.start))


def _moved(scenario: Scenario, number: int, row: int) -> Session:
    """The session begun at a row; raises InfeasibleSlew where it is then over too late."""
    session = scenario.sessions[number]
    start_utc = shifted_utc(scenario.initial_state.epoch, row / ROWS_PER_S)
    if elapsed_s(start_utc, session.start) < 0.0:
        start_utc = session.start
    stop_utc = shifted_utc(start_utc, elapsed_s(session.stop, session.start))
    limits = [("stop", session.fits_by)]
    if number + 1 < len(scenario.sessions) and scenario.sessions[number + 1].fits_by is None:
        limits.append(("the next session's start", scenario.sessions[number + 1].start))
    for name, limit_utc in limits:
        if limit_utc is not None and elapsed_s(stop_utc, limit_utc) > 0.0:
            raise InfeasibleSlew(
                f"session {number + 1} can't be over by {name} ({utc_text(limit_utc)}): with the "
                f"slews before it, it ends at {utc_text(stop_utc, 1)} at the soonest that was "
                "found; give more time, more speed_m_s, or ask for less",
                field=f"sessions.{number}.stop",
                limit="duration",
                at_utc=stop_utc,
            )
    return replace(
        session,
        start=start_utc,
        stop=stop_utc,
        target=session.target.starting(start_utc),
        fits_by=None,
    )


def tell_by_asked(refusal: Refusal, sessions: tuple[Session, ...]) -> None:
    """Count sessions in a refusal as the request does, an imaging mode's as one.

    A start at which one of them could be flown is no start of the mode's: it stays in the words.
    """
    if all(session.of is None for session in sessions):
        return
    asked = list(
        accumulate(
            int(later.of is None or later.of != before.of) for before, later in pairwise(sessions)
        )
    )
    asked = [0, *asked]
    named = re.fullmatch(r"sessions\.(\d+)(.*)", refusal.field or "")
    if named:
        number = int(named[1])
        refusal.field = f"sessions.{asked[number]}{named[2]}"
        if sessions[number].of is not None:
            told = sessions[number].id or sessions[number].label
            refusal.detail += f"; session {number + 1} of those planned is {told!r}"
            refusal.args = (refusal.detail,)
            refusal.earliest_feasible_start_utc = refusal.feasible_stop_utc = None
    refusal.costs_sessions = tuple(sorted({asked[cost] for cost in refusal.costs_sessions}))
    if isinstance(refusal, InfeasibleSlew):
        refusal.relaxations = tuple(
            replace(one, session=asked[one.session]) for one in refusal.relaxations
        )
