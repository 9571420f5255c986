"""The nearest start at which a refused session can be flown."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import islice

import numpy as np

from planner.base import effort
from planner.base.commands import ROWS_PER_S
from planner.base.effort import Effort, WorkLimitReached, at_most
from planner.base.errors import InfeasibleSlew, Refusal
from planner.base.reporting import Reporter, tell_nobody
from planner.planning.resources import resource_curves
from planner.planning.sessions.assembly import assemble, table_work
from planner.planning.sessions.platforms.mover import Join, Mover, RowSpan
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.sequence import (
    RefusedSession,
    SessionRefused,
    sequence_sessions,
    sequence_whole,
)
from planner.planning.sessions.start_trials import Slewed, Trials, longest_hold
from planner.planning.sessions.track_branches import may_look, session_rows
from planner.verification import verify
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.scenario import Scenario, Session
from planner.world.targets import BenchMotionTarget, EarthFixedTarget

# The cost of moving one session to the others of its request.

SHARE = 0.8  # of the work that is left, for planning the whole request once more


# By start and stop of a session: those without which it is planned, None where it isn't.
Costs = dict[tuple[datetime, datetime], tuple[int, ...] | None]


class Others:
    """The other sessions of a refused one's request, asked about it moved.

    dearer: the first start tried that costs other sessions, and which.  undecided: in words, a
    start of which it wasn't found out.
    """

    def __init__(self, refused: RefusedSession, known: Costs) -> None:
        """known: what other searches for it found out, and this one will."""
        self._refused, self._known = refused, known
        self.dearer: tuple[Session, tuple[int, ...]] | None = None
        self._unheld: set[int] = set()
        self.undecided = ""

    def stay_as_asked(self, moved: Session) -> bool:
        """Whether the whole request, with that session moved, was planned and judged good."""
        times = moved.start, moved.stop
        costs = self._known.get(times)
        with at_most(SHARE * effort.remaining()) as search:
            if times not in self._known:
                costs = self._known[times] = self._costs_at(moved)
        if search.is_exhausted:
            self.undecided = (
                f"at {utc_text(moved.start, 1)} this session by itself can be, but whether the "
                "others then can was not found out before the search ended"
            )
        if costs and (self.dearer is None or len(costs) < len(self.dearer[1])):
            self.dearer = moved, costs
        return costs == ()

    def always_cost(self, moved: Session) -> bool:
        """Whether some other session is lost wherever that one begins, if it ends when it does."""
        costs = self._known.get((moved.start, moved.stop))
        return bool(self._hopeless_beside(moved) or (costs and self._unheld.issuperset(costs)))

    def _hopeless_beside(self, moved: Session) -> tuple[int, ...]:
        """Later sessions that are asked too soon after the one before them."""
        refused = self._refused
        first = refused.number + 1 + (moved.stop != refused.session.stop)
        return tuple(other for other in refused.hopeless if other >= first)

    def _costs_at(self, moved: Session) -> tuple[int, ...] | None:
        """Sessions without which the others are planned; None: the moved one isn't."""
        scenario, number = self._refused.scenario, self._refused.number
        kept = [
            other
            for other, session in enumerate(scenario.sessions)
            if other <= number or elapsed_s(session.start, moved.stop) >= 0.0
        ]
        for other in self._hopeless_beside(moved):
            if other in kept and other - 1 in kept:
                kept.remove(other)
        while True:
            sessions = [moved if one == number else scenario.sessions[one] for one in kept]
            try:
                planned = _is_planned(
                    replace(scenario, sessions=tuple(sessions)), self._refused.mover
                )
            except SessionRefused as failed:
                lost = kept[failed.session.number]
                if lost == number:
                    return None
                if not isinstance(failed.refusal, InfeasibleSlew):
                    self._unheld.add(lost)  # its own target is at fault
                kept.remove(lost)
                continue
            except Refusal:
                return None
            count = len(scenario.sessions)
            return tuple(sorted({*range(count)} - {*kept})) if planned else None


def _is_planned(scenario: Scenario, mover: Mover) -> bool:
    """Whether the pipeline plans it; raises SessionRefused and refusals of the whole."""
    is_quick = mover.start_search.is_quick
    if is_quick:
        scenario = replace(scenario, slew=replace(scenario.slew, objective="smooth"))
    mover = mover.trying(scenario)
    whole = sequence_whole(scenario, mover)
    platform, resources = scenario.platform, scenario.resources
    is_free = is_quick and not platform.always_excluded and resources is None
    if not scenario.slew.keeps_limits or is_free:
        return True
    effort.charge(table_work(scenario, whole[-1].stop_row))
    if is_quick:
        effort.charge(0.0)  # a table of a day would take more than is left
    plan, _ = assemble(scenario, mover, whole)
    if is_quick:
        return all(curve.first_beyond_s is None for curve in resource_curves(plan))
    return verify(plan.table, plan.scenario, plan.waits).passed


@dataclass(frozen=True, kw_only=True)
class NearestStartOptions:
    """How another start is sought for a refused session."""

    coarse_rows: int = 10 * ROWS_PER_S  # first tries, then halved down to a row
    attempts: int = 60  # rows gone through either way of moving a session
    search: int = 500_000  # of `effort`: five seconds for either direction of moving a session
    search_share: float = 0.6  # and of what work is left
    slews_share: float = 0.75  # of that, for slews to a session moved; then the whole is planned
    refusals: int = 4  # starts that would cost other sessions, before such a one is named
    # a carrier lower than that is three times as far off, or more
    useful_elevation_deg: float = 10.0


OPTIONS = NearestStartOptions()


@dataclass(frozen=True)
class Advice:
    """words: the way out.  session: as it can be flown, when those in `costs` are left out."""

    words: str
    session: Session | None = None
    costs: tuple[int, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _Span:
    """Where another start is sought.

    known: rows at which the orbit is known.  seen: runs of them in which the target can be
    seen, their ends good to the coarse step.  kept_work_rows: of `effort`, that is to be left.
    """

    ephemeris: Ephemeris
    known: RowSpan
    seen: list[RowSpan]
    kept_work_rows: float = 0.0


def plan_sessions(
    scenario: Scenario, ephemeris: Ephemeris, tell: Reporter = tell_nobody
) -> list[Join]:
    """A slew and a track for every session, in order, as `sequence_sessions` has them.

    Raises CadenceBroken, NotVisible, Unreachable, TrackBreaksLimit and InfeasibleSlew, each with
    the nearest start that can be flown; the last with what each session would have to give up.
    """
    try:
        return sequence_sessions(scenario, ephemeris, mover_of(scenario))
    except SessionRefused as failed:
        raise _advise_start(failed, tell) from None


def _advise_start(failed: SessionRefused, tell: Reporter) -> Refusal:
    """The refusal with the field at fault and the nearest start that can be flown.

    First the session is cut short, at its start and where it can't be held to its stop there too,
    then moved as a whole, by at most a day; where no least elevation was asked for, first to where
    the carrier stands at a useful one.
    Every start named has been tried by planning the whole request with it.  Whatever forbids
    another start, the reason given stays that of the start asked for.
    """
    refusal, refused = failed.refusal, failed.session
    alike = isinstance(refused.session.target, BenchMotionTarget)
    if alike and not isinstance(refusal, InfeasibleSlew):
        return refusal  # it breaks its limits at any other time, too
    try:
        tell("alternatives", 0, 3)
        offers = failed.offers()
        tell("alternatives", 1, 3)
        advice = _start_advice(refused, tell)
    except WorkLimitReached:  # of the whole request: why it is refused is known all the same
        offers = ()
        advice = Advice(
            "no other start was found before the search, which is bounded, ended; ask for a "
            "shorter session"
        )
    advised = type(refusal)(
        f"{refusal.detail}; {advice.words}",
        field=refusal.field or f"sessions.{refused.number}.start",
        axis=refusal.axis,
        limit=refusal.limit,
        at_utc=refusal.at_utc,
        earliest_feasible_start_utc=advice.session.start if advice.session else None,
        feasible_stop_utc=advice.session.stop if advice.session else None,
        costs_sessions=advice.costs,
    )
    if isinstance(advised, InfeasibleSlew):
        advised.relaxations = offers
    return advised


def _start_advice(refused: RefusedSession, tell: Reporter) -> Advice:
    refused = replace(refused, mover=refused.mover.trying(refused.scenario))
    span = _known_span(refused)
    if isinstance(span, Refusal):
        return Advice(f"no other start was tried: {span.detail.partition(';')[0]}")
    most = refused.mover.start_search.work_rows
    span = replace(span, kept_work_rows=max(effort.remaining() - most, 0.0))
    useful = _at_useful_elevation(refused)
    known: Costs = {}
    slewed: Slewed = {}
    if useful is not None:
        seen = _visible_rows(useful, span.ephemeris, span.known)
        advice = _seek_start(useful, replace(span, seen=seen), known, slewed)
        if advice.session is not None:
            return advice
        tell("alternatives", 2, 3)
    return _seek_start(refused, span, known, slewed)


def _at_useful_elevation(refused: RefusedSession) -> RefusedSession | None:
    """Higher in the target's sky than where it rises, which nobody asked for by leaving it out."""
    target = refused.session.target
    if not isinstance(target, EarthFixedTarget) or target.min_elevation_deg != 0.0:
        return None
    sessions = list(refused.scenario.sessions)
    sessions[refused.number] = replace(
        refused.session, target=replace(target, min_elevation_deg=OPTIONS.useful_elevation_deg)
    )
    return replace(refused, scenario=replace(refused.scenario, sessions=tuple(sessions)))


def _seek_start(refused: RefusedSession, span: _Span, known: Costs, slewed: Slewed) -> Advice:
    """The session as it can be flown, and the way out in words."""
    session, wanted_row = refused.session, refused.wanted.start
    length_s = elapsed_s(session.stop, session.start)
    others = Others(refused, known)
    shortened = Trials(
        refused=refused,
        ephemeris=span.ephemeris,
        seen=span.seen,
        stop_utc=lambda _: session.stop,
        slewed=slewed,
        kept_work_rows=span.kept_work_rows,
    )
    moved = replace(shortened, stop_utc=lambda row: shifted_utc(refused.utc(row), length_s))
    held = _longest_hold(refused, span)
    left = held or RowSpan(start=max(wanted_row, refused.from_row + 1), stop=refused.wanted.stop)
    shortened = replace(shortened, held=held)
    if left.stop != refused.wanted.stop:
        shortened = replace(shortened, stop_utc=lambda _: refused.utc(left.stop))
    reaches: list[int | None] = []
    searches: tuple[tuple[Trials, Iterable[int]], ...] = (
        (shortened, _rows_before_stop(span, left)),
        (moved, _rows_by_distance(refused, span)),
    )
    for trials, rows in searches:
        found, reach_rows = _search_rows(trials, others, rows, wanted_row)
        if found is not None:
            return Advice(_way_out(found, session), found)
        reaches.append(reach_rows)
    if others.dearer is not None:
        instead, costs = others.dearer
        return Advice(f"{_way_out(instead, session)}, {_cost_text(costs)}", instead, costs)
    alone = f"; {others.undecided}" if others.undecided else ""
    return Advice(_not_found(refused, span, *reaches) + alone)


def _way_out(found: Session, wanted: Session) -> str:
    start, stop = utc_text(found.start, 1), utc_text(found.stop, 1)
    if found.start == wanted.start:
        return f"from the start asked for it can be flown until {stop}"
    kept = found.stop == wanted.stop
    how = "keeping the stop" if kept else f"with the stop moved to {stop}"
    return f"earliest feasible start {start}, {how}"


def _cost_text(costs: tuple[int, ...]) -> str:
    if len(costs) == 1:
        return (
            f"but session {costs[0] + 1} can't be flown then as asked: leave it out, or move it too"
        )
    numbers = ", ".join(str(number + 1) for number in costs)
    return f"but sessions {numbers} can't be flown then as asked: leave them out, or move them too"


def _not_found(
    refused: RefusedSession, span: _Span, later_reach_rows: int | None, moved_reach_rows: int | None
) -> str:
    wanted = refused.wanted
    first_row = refused.from_row + 1
    last_row = span.known.stop - (wanted.stop - wanted.start)
    branches = (
        ("keeping the stop", max(wanted.start, first_row), wanted.stop - 1, later_reach_rows),
        ("moving it", max(span.known.start, first_row), last_row, moved_reach_rows),
    )
    searches = [
        f"{_span_searched(refused, low, high, reach_rows)} {how}"
        for how, low, high, reach_rows in branches
        if low <= high
    ]
    if not searches:
        return "no other start can be tried: the orbit is not known beyond the session"
    return f"no start that can be flown was found {' and '.join(searches)}"


def _span_searched(refused: RefusedSession, low: int, high: int, reach_rows: int | None) -> str:
    """When starts were tried, from and to, of all from row `low` to `high`."""
    wanted_row = refused.wanted.start
    ends = low, high
    if reach_rows is not None:
        if reach_rows < 0:
            return "(none was decided before the search ends, which is bounded)"
        ends = max(low, wanted_row - reach_rows), min(high, wanted_row + reach_rows)
    texts = [utc_text(refused.utc(row), 1) for row in ends]
    farther = ", nor looked for farther off," if ends != (low, high) else ""
    return f"from {texts[0]} to {texts[1]}{farther}"


def _search_rows(
    trials: Trials, others: Others, rows: Iterable[int], wanted_row: int
) -> tuple[Session | None, int | None]:
    """The first row that may succeed, then the nearest to the wanted one that does.

    Where that would cost other sessions, the next ones are tried, too.  Returns the session as it
    can be flown, None if not found, and how far from the wanted row all were gone through; None:
    as far as there are any, negative: not one.
    """
    reach_rows, refusals, failures = -1, 0, 0
    tried: set[int] = {wanted_row}
    candidates = list(islice(rows, OPTIONS.attempts))
    with _search_of(trials):
        for row in candidates:
            may = trials.ends_may(row) and trials.may_succeed(row)
            session = _nearest_feasible(trials, row, wanted_row, tried) if may else None
            tried |= {row} if may else set()
            reach_rows = abs(row - wanted_row)
            if session is not None and others.stay_as_asked(session):
                return session, reach_rows
            refusals += may
            failures += may and session is None
            most = 1 if session and others.always_cost(session) else OPTIONS.refusals
            if may and (failures >= trials.mover.start_search.failures or refusals >= most):
                return None, reach_rows
        return None, reach_rows if len(candidates) == OPTIONS.attempts else None
    return None, reach_rows


def _nearest_feasible(trials: Trials, row: int, wanted_row: int, tried: set[int]) -> Session | None:
    """Step from a row that may succeed back to its failed neighbour; then solved, row by row.

    tried: the wanted row, and those from which this was done.
    """
    away = 1 if row >= wanted_row else -1

    def nearest_row(may: Callable[[int], bool]) -> int:
        good, bad = row, row - away * OPTIONS.coarse_rows
        while abs(good - bad) > 1:
            middle = (good + bad) // 2
            if (middle - wanted_row) * away >= 0 and may(middle):
                good = middle
            else:
                bad = middle
        return good

    # A roll nearest to the attitude before hangs on the whole of a session, not on its ends alone.
    is_quick = trials.mover.start_search.is_quick
    first, found = nearest_row(trials.may_succeed if is_quick else trials.ends_may), None
    with at_most(OPTIONS.slews_share * effort.remaining()):
        found = trials.feasible_session(first)
        if found is None:
            surer = nearest_row(lambda at: trials.ends_may(at) and trials.may_succeed(at))
            for nearer in _ever_nearer(trials, surer, away, first):
                found = nearer
        for nearer in _row_by_row(trials, found, away, tried):
            found = nearer
    return found


def _ever_nearer(trials: Trials, row: int, away: int, failed: int) -> Iterator[Session]:
    """A session that is slewed to, from a row on that closed forms leave open, and nearer ones."""
    search, good, bad, step = trials.mover.start_search, row, row - away, 1
    needed: dict[int, int] = {}
    for _ in range(search.slews):
        found = trials.feasible_session(good) if good != failed else None
        if found is not None:
            break
        if away < 0 and trials.needed_row > good:
            return  # with less time there is none either
        needed[good] = trials.needed_row
        bad, good = good, good + away * step
        if away > 0 and trials.needed_row > good:
            good = trials.needed_row
        else:
            step *= search.growth
    else:
        return
    yield found
    while abs(good - bad) > 1:
        middle = _row_to_try(needed, good, bad) if search.is_quick else (good + bad) // 2
        nearer = trials.feasible_session(middle)
        if nearer is not None:
            good = middle
            yield nearer
            continue
        needed[middle] = trials.needed_row
        bad = middle
        if away > 0 and not search.is_quick:
            bad = min(max(middle, trials.needed_row - 1), good - 1)


def _row_by_row(
    trials: Trials, found: Session | None, away: int, tried: set[int]
) -> Iterator[Session]:
    """Sessions that are nearer than the one found, where closed forms can't tell of a slew: what
    they, or least times that were found, leave out may be possible.  Steps are doubled as long as
    all succeed, and halved since one failed, down to a row."""
    if found is None or not trials.mover.start_search.is_quick:
        return
    row = session_rows(found, trials.refused.epoch_utc).start
    step, grows = 1, row not in tried
    while step:
        is_new = not tried.intersection(row - away * near for near in range(1, step + 1))
        nearer = trials.feasible_session(row - away * step) if is_new else None
        if nearer is not None:
            row -= away * step
            yield nearer
        grows &= nearer is not None
        step = 2 * step if grows else step // 2


def _row_to_try(needed: dict[int, int], good: int, bad: int) -> int:
    """Between a row that fails and one that does: where the last that failed says, or halfway.

    needed: by row, the row at which it would be in time, -1 where that isn't known.
    """
    told = [needs for needs in needed.values() if needs >= 0]
    if not told or good < bad:
        return (good + bad) // 2
    return min(max(told[-1], bad + 1), good - 1)


def _search_of(trials: Trials) -> Effort:
    """The bound of one direction of moving a session."""
    left = effort.remaining()
    return at_most(min(OPTIONS.search, OPTIONS.search_share * left, left - trials.kept_work_rows))


def _longest_hold(refused: RefusedSession, span: _Span) -> RowSpan | None:
    """What of the session can be held; None where that isn't known."""
    with at_most(min(OPTIONS.search, OPTIONS.search_share * effort.remaining())):
        return longest_hold(refused, span.ephemeris)
    return None


def _rows_before_stop(span: _Span, left: RowSpan) -> Iterable[int]:
    """Start rows of the session cut short to what is left of it, the first ones first."""
    step = min(OPTIONS.coarse_rows, max((left.stop - left.start) // 8, 1))
    runs = [run for run in span.seen if run.start <= left.stop <= run.stop]
    rows = range(left.start, left.stop, step)
    return (row for row in rows if any(run.start <= row for run in runs))


def _rows_by_distance(refused: RefusedSession, span: _Span) -> list[int]:
    """Start rows of sessions wholly inside a run, the nearest to the wanted row first."""
    wanted, cadence = refused.wanted, refused.cadence
    length_rows = wanted.stop - wanted.start
    long_s = elapsed_s(refused.session.stop, refused.session.start)
    starts = [
        row
        for run in span.seen
        if run.stop - length_rows >= run.start
        for row in {
            *range(run.start, run.stop - length_rows, OPTIONS.coarse_rows),
            run.stop - length_rows,
        }
        if row > refused.from_row
        and cadence.keeps(refused.number, row / ROWS_PER_S, row / ROWS_PER_S + long_s)
    ]
    return sorted(starts, key=lambda row: abs(row - wanted.start))


def _known_span(refused: RefusedSession) -> _Span | Refusal:
    """The orbit as far around the session as it is known, up to the horizon, or why it is not."""
    scenario, wanted = refused.scenario, refused.wanted
    longest_s = scenario.orbit.search_horizon_s
    for horizon_s in (longest_s, longest_s / 16.0, 0.0):
        # Cones to keep out of must be known along the whole slew.
        early_row = wanted.start - int(horizon_s) * ROWS_PER_S
        known = RowSpan(
            start=refused.from_row
            if scenario.needs_orbit_throughout
            else max(refused.from_row, early_row),
            stop=wanted.stop + int(horizon_s) * ROWS_PER_S,
        )
        try:
            ephemeris = scenario.orbit.ephemeris(refused.utc(known.start), refused.utc(known.stop))
            return _Span(
                ephemeris=ephemeris, known=known, seen=_visible_rows(refused, ephemeris, known)
            )
        except Refusal as unknown:  # too far for the data, or damaged data on the way
            why = unknown
    return why


def _visible_rows(refused: RefusedSession, ephemeris: Ephemeris, known: RowSpan) -> list[RowSpan]:
    """Runs of rows in which the target can be seen, their ends good to the coarse step."""
    target = refused.session.target
    if isinstance(target, BenchMotionTarget):
        return [known]
    rows = np.arange(known.start, known.stop + 1, OPTIONS.coarse_rows)
    instants = Instants(refused.epoch_utc, rows / ROWS_PER_S)
    visible = may_look(refused.scenario, target, instants, ephemeris.states(instants))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]])))
    return [
        RowSpan(
            start=max(known.start, int(rows[first]) - OPTIONS.coarse_rows),
            stop=min(known.stop, int(rows[last - 1]) + OPTIONS.coarse_rows),
        )
        for first, last in edges.reshape(-1, 2)
    ]
