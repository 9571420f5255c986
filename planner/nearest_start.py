"""When is the nearest start at which a refused session can be flown?"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import islice
from typing import TypeVar

import numpy as np

from planner.commands import ROWS_PER_S
from planner.errors import Refusal
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.joining import Rows
from planner.orbits import Ephemeris
from planner.scenario import Scenario, Session
from planner.slew import AxisState
from planner.start_trials import Refused, Trials, Work, WorkSpent
from planner.targets import BenchMotionTarget

DAY_S = 86400.0
HORIZON_S = {"state": 6000.0, "opm": 6000.0}  # a numerical propagation of a day takes seconds
COARSE_ROWS = 10 * ROWS_PER_S  # first tries, then halved down to a row
ATTEMPTS = 60

# For a refusal in two seconds, cutting the session short and then moving it.
CUT_SHORT_WORK_US = 900_000.0
MOVED_WORK_US = 700_000.0  # and what the first leaves

ROWS_LATER = 3  # the solver needs a row or two more than closed forms say

R = TypeVar("R", bound=Refusal)


@dataclass(frozen=True, kw_only=True)
class _Span:
    """Where another start is sought.

    known: rows at which the orbit is known.  seen: runs of them in which the target can be
    seen, their ends good to the coarse step.
    """

    ephemeris: Ephemeris
    known: Rows
    seen: list[Rows]


@dataclass(frozen=True, kw_only=True)
class _Searched:
    """session: as it can be flown, None if not found.

    reach_rows: how far from the start asked for all starts were gone through; None: as far as
    there are any, negative: not one.
    """

    session: Session | None = None
    reach_rows: int | None = None


def refused_with_nearest_start(
    scenario: Scenario,
    number: int,
    from_row: int,
    state: tuple[AxisState, ...],
    refusal: R,
) -> R:
    """The same refusal with the field at fault and the nearest start that can be flown.

    First the session is cut short at its start, then moved as a whole, by at most a day.
    Every start named has been tried by planning the session there.  Whatever forbids another
    start, the reason given stays that of the start asked for.
    """
    refused = Refused(scenario=scenario, number=number, from_row=from_row, state=state)
    span = _span(refused)
    if isinstance(span, Refusal):
        moved, way_out = None, f"no other start was tried: {span.detail.partition(';')[0]}"
    else:
        moved, way_out = _sought(refused, span)
    return type(refusal)(
        f"{refusal.detail}; {way_out}",
        field=refusal.field or f"sessions.{number}.start",
        axis=refusal.axis,
        limit=refusal.limit,
        at_utc=refusal.at_utc,
        earliest_feasible_start_utc=moved.start if moved else None,
        feasible_stop_utc=moved.stop if moved else None,
    )


def _sought(refused: Refused, span: _Span) -> tuple[Session | None, str]:
    """The session as it can be flown, and the way out in words."""
    session, epoch_utc, wanted_row = refused.session, refused.epoch_utc, refused.wanted.start
    length_s = elapsed_s(session.stop, session.start)
    trials = Trials(
        refused=refused,
        ephemeris=span.ephemeris,
        seen=span.seen,
        stop_utc=lambda _: session.stop,
        work=Work(CUT_SHORT_WORK_US),
    )
    later = _search(trials, _rows_before_stop(refused, span), wanted_row)
    if later.session is not None:
        start = utc_text(later.session.start, 1)
        return later.session, f"earliest feasible start {start}, keeping the stop"
    trials = replace(
        trials,
        stop_utc=lambda row: shifted_utc(epoch_utc, row / ROWS_PER_S + length_s),
        work=Work(MOVED_WORK_US + trials.work.left_us),
    )
    moved = _search(trials, _rows_by_distance(refused, span), wanted_row)
    if moved.session is not None:
        start, stop = utc_text(moved.session.start, 1), utc_text(moved.session.stop, 1)
        return moved.session, f"earliest feasible start {start}, with the stop moved to {stop}"
    return None, _not_found(refused, span, later.reach_rows, moved.reach_rows)


def _not_found(
    refused: Refused, span: _Span, later_reach_rows: int | None, moved_reach_rows: int | None
) -> str:
    wanted = refused.wanted
    first_row = refused.from_row + 1
    last_row = span.known.stop - (wanted.stop - wanted.start)
    ways = (
        ("keeping the stop", max(wanted.start, first_row), wanted.stop - 1, later_reach_rows),
        ("moving it", max(span.known.start, first_row), last_row, moved_reach_rows),
    )
    said = [
        f"{_gone_through(refused, low, high, reach_rows)} {how}"
        for how, low, high, reach_rows in ways
        if low <= high
    ]
    if not said:
        return "no other start can be tried: the orbit is not known beyond the session"
    return f"no start that can be flown was found {' and '.join(said)}"


def _gone_through(refused: Refused, low: int, high: int, reach_rows: int | None) -> str:
    """From when to when starts were gone through, of all from row `low` to `high`."""
    wanted_row = refused.wanted.start
    ends = low, high
    if reach_rows is not None:
        if reach_rows < 0:
            return "(none was decided before the search ends, which is bounded)"
        ends = max(low, wanted_row - reach_rows), min(high, wanted_row + reach_rows)
    texts = [utc_text(shifted_utc(refused.epoch_utc, row / ROWS_PER_S), 1) for row in ends]
    farther = ", nor looked for farther off," if ends != (low, high) else ""
    return f"from {texts[0]} to {texts[1]}{farther}"


def _search(trials: Trials, rows: Iterable[int], wanted_row: int) -> _Searched:
    """The first row that may succeed, then the nearest to the wanted one that does."""
    reach_rows = -1
    candidates = list(islice(rows, ATTEMPTS))
    for row in candidates:
        try:
            may = trials.ends_may(row) and trials.may(row)
            session = _nearest_flown(trials, row, wanted_row) if may else None
        except WorkSpent:
            return _Searched(reach_rows=reach_rows)
        reach_rows = abs(row - wanted_row)
        if may:
            return _Searched(session=session, reach_rows=reach_rows)
    return _Searched(reach_rows=reach_rows if len(candidates) == ATTEMPTS else None)


def _nearest_flown(trials: Trials, row: int, wanted_row: int) -> Session | None:
    """From a row that may succeed back to its failed neighbour; then solved, row by row."""
    away = 1 if row >= wanted_row else -1

    def nearest(may: Callable[[int], bool]) -> int:
        good, bad = row, row - away * COARSE_ROWS
        while abs(good - bad) > 1:
            middle = (good + bad) // 2
            if (middle - wanted_row) * away >= 0 and may(middle):
                good = middle
            else:
                bad = middle
        return good

    first = nearest(trials.ends_may)
    found = trials.flown(first)
    if found is not None:
        return found
    surer = nearest(lambda middle: trials.ends_may(middle) and trials.may(middle))
    for nearby in range(surer, surer + away * ROWS_LATER, away):
        found = trials.flown(nearby) if nearby != first else None
        if found is not None:
            return found
    return None


def _rows_before_stop(refused: Refused, span: _Span) -> Iterable[int]:
    """Start rows of the session cut short, the nearest to the wanted row first."""
    wanted = refused.wanted
    first = max(wanted.start, refused.from_row + 1)
    step = min(COARSE_ROWS, max((wanted.stop - first) // 8, 1))
    runs = [run for run in span.seen if run.start <= wanted.stop <= run.stop]
    return (row for row in range(first, wanted.stop, step) if any(run.start <= row for run in runs))


def _rows_by_distance(refused: Refused, span: _Span) -> list[int]:
    """Start rows of sessions wholly inside a run, the nearest to the wanted row first."""
    wanted = refused.wanted
    length_rows = wanted.stop - wanted.start
    starts = [
        row
        for run in span.seen
        if run.stop - length_rows >= run.start
        for row in {*range(run.start, run.stop - length_rows, COARSE_ROWS), run.stop - length_rows}
        if row > refused.from_row
    ]
    return sorted(starts, key=lambda row: abs(row - wanted.start))


def _span(refused: Refused) -> _Span | Refusal:
    """The orbit as far around the session as it is known, up to the horizon, or why it is not."""
    scenario, wanted = refused.scenario, refused.wanted
    longest_s = HORIZON_S.get(scenario.orbit.source, DAY_S)
    for horizon_s in (longest_s, longest_s / 16.0, 0.0):
        # Cones to keep out of must be known along the whole slew.
        early_row = wanted.start - int(horizon_s) * ROWS_PER_S
        known = Rows(
            start=refused.from_row if scenario.slew.keep_out else max(refused.from_row, early_row),
            stop=wanted.stop + int(horizon_s) * ROWS_PER_S,
        )
        ends_utc = (
            shifted_utc(refused.epoch_utc, row / ROWS_PER_S) for row in (known.start, known.stop)
        )
        try:
            ephemeris = scenario.orbit.ephemeris(*ends_utc)
            return _Span(ephemeris=ephemeris, known=known, seen=_seen(refused, ephemeris, known))
        except Refusal as unknown:  # too far for the data, or damaged data on the way
            why = unknown
    return why


def _seen(refused: Refused, ephemeris: Ephemeris, known: Rows) -> list[Rows]:
    """Runs of rows in which the target can be seen, their ends good to the coarse step."""
    target = refused.session.target
    if isinstance(target, BenchMotionTarget):
        return [known]
    rows = np.arange(known.start, known.stop + 1, COARSE_ROWS)
    instants = Instants(refused.epoch_utc, rows / ROWS_PER_S)
    visible = target.apparent(instants, ephemeris.states(instants)).clearance_rad >= 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]])))
    return [
        Rows(
            start=max(known.start, int(rows[first]) - COARSE_ROWS),
            stop=min(known.stop, int(rows[last - 1]) + COARSE_ROWS),
        )
        for first, last in edges.reshape(-1, 2)
    ]
