"""From a scenario to a verified plan: the whole story on one screen."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from planner.base import effort
from planner.base.effort import at_most
from planner.base.errors import Refusal, SearchEnded, VerificationFailed
from planner.base.reporting import Reporter, tell_nobody
from planner.planning.sessions.assembly import assemble, pair_joins, table_work
from planner.planning.sessions.fitting import tell_by_asked, with_starts_that_fit
from planner.planning.sessions.nearest_start import plan_sessions
from planner.planning.sessions.plan import Plan
from planner.planning.sessions.platforms.mover import Join
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.running_out import require_resources
from planner.planning.sessions.track_branches import ephemeris_over, session_rows
from planner.verification import VerificationReport, verify
from planner.world.frames.earth_orientation import earth_orientation_warnings
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.scenario import Scenario


def make_plan(scenario: Scenario, tell: Reporter = tell_nobody) -> Plan:
    """Plan every session in order of time and have the table judged.

    tell: called with each stage's name when it begins, and with the share of "alternatives".
    Raises a `Refusal` when a session can't be flown; it says which limit, when, and, where
    there is one, the nearest session start that can.
    """
    try:
        return _make_plan(scenario, tell)
    except Refusal as refusal:
        tell_by_asked(refusal, scenario.sessions)
        raise


@dataclass(frozen=True, kw_only=True)
class StageClock:
    """Tells when a stage begins, and keeps how long each took."""

    tell: Reporter
    wall_s: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def time(self, name: str) -> Iterator[None]:
        """Of what is in the `with`."""
        self.tell(name, 0, 1)
        began_s = time.perf_counter()
        yield
        self.wall_s[name] = time.perf_counter() - began_s


def _make_plan(scenario: Scenario, tell: Reporter) -> Plan:
    clock = StageClock(tell=tell)
    scenario, work = _fitted(scenario)
    with clock.time("orbit"):
        epoch_utc = scenario.initial_state.epoch
        ephemeris = ephemeris_over(
            scenario, [session_rows(session, epoch_utc) for session in scenario.sessions]
        )
    with clock.time("slews and tracks"):
        joins = _find_joins(scenario, ephemeris, effort.PLAN - work, tell)
    return complete_plan(scenario, ephemeris, joins, clock)


def complete_plan(
    scenario: Scenario, ephemeris: Ephemeris, joins: list[Join], clock: StageClock
) -> Plan:
    """The table of slews and tracks, judged, and the figures of all.

    Raises ResourceRunsOut, InfeasibleSlew where idling breaks an exclusion, VerificationFailed.
    """
    mover = mover_of(scenario)
    onto_tracks = joins[: len(scenario.sessions)]
    with clock.time("comparison"):
        slews = tuple(mover.run(number, join) for number, join in pair_joins(scenario, joins))
    flight, losses = assemble(scenario, mover, joins)
    final, table = flight.scenario, flight.table
    with clock.time("resources"):
        require_resources(flight, mover)
    with clock.time("pointing budget"):
        budgets = tuple(
            mover_of(final).budget(ephemeris, table, number, join.track.los)
            for number, join in enumerate(onto_tracks)
        )
    misses = [
        budget.warning()
        for session, budget in zip(final.sessions, budgets, strict=True)
        if budget and session.target.images
    ]
    with clock.time("verification"):
        report = verify(table, final, flight.waits)
    if scenario.slew.keeps_limits and not report.passed:
        raise _rejection_of(report)
    return Plan(
        scenario=final,
        segments=flight.segments,
        table=table,
        verification=report,
        slews=slews,
        budgets=budgets,
        warnings=(
            *losses,
            *_cut_short(joins),
            *ephemeris.warnings,
            *mover.warnings_along(table),
            *filter(None, misses),
            *earth_orientation_warnings(Instants(table.epoch_utc, table.t_s)),
            *(finding.detail for finding in report.findings),
        ),
        stage_wall_s=clock.wall_s,
    )


def _fitted(scenario: Scenario) -> tuple[Scenario, int]:
    """With the starts of sessions that begin as soon as they can, and the work that took."""
    with at_most(effort.PLAN // 2) as search:
        fitted = with_starts_that_fit(scenario)
        return fitted, round(search.done_rows)
    raise SearchEnded(
        "the starts of sessions that begin as soon as they can take more work to find than one "
        "request may make; ask for fewer at a time, or give them starts of their own",
        field="sessions",
    )


def _find_joins(scenario: Scenario, ephemeris: Ephemeris, most: int, tell: Reporter) -> list[Join]:
    """Found by no more work than that, what its table takes set aside."""
    last_row = session_rows(scenario.sessions[-1], scenario.initial_state.epoch).stop
    with at_most(most - table_work(scenario, last_row)):
        joins = mover_of(scenario).with_final_slew(
            ephemeris, plan_sessions(scenario, ephemeris, tell)
        )
        effort.count(table_work(scenario, joins[-1].stop_row))
        return joins
    raise SearchEnded(
        "the sessions take more work than one request may make before "
        "any plan is found; ask for fewer or shorter ones at a time, nearer to the epoch, or for "
        "fewer cones and masks",
        field="sessions",
    )


def _cut_short(joins: list[Join]) -> tuple[str, ...]:
    numbers = [str(number) for number, join in enumerate(joins, start=1) if join.search_truncated]
    if not numbers:
        return ()
    sessions = f"session {numbers[0]}" if len(numbers) == 1 else f"sessions {', '.join(numbers)}"
    return (
        f"the slew to {sessions} is the best that was found by the work one request may make, "
        "perhaps not the quickest or the smoothest that there is",
    )


def _rejection_of(report: VerificationReport) -> VerificationFailed:
    worst = next(finding for finding in report.findings if finding.severity == "error")
    return VerificationFailed(
        f"the independent judge rejects the table: {worst.detail}",
        axis=worst.axis,
        limit=worst.limit,
        at_utc=worst.at_utc,
    )
