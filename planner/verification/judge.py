"""The independent judge of a command table: it reads the table and the scenario."""

from collections.abc import Callable
from functools import cache

from planner.base.commands import ROWS_PER_S, CommandTable
from planner.verification.bench_motion import bench_session
from planner.verification.carrier import DERIVED_LAWS
from planner.verification.field_masks import mask_findings, mask_margins
from planner.verification.keep_out import keep_out_findings, keep_out_margins
from planner.verification.limits import limit_findings, limit_margins, slow_outside_sessions
from planner.verification.pointing import pointing_session
from planner.verification.report import Finding, Given, SessionReport, VerificationReport
from planner.verification.session import table_session
from planner.verification.structure import covers, session_rows, structure_findings, unflyable
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.scenario import Scenario
from planner.world.targets import (
    BenchMotionTarget,
    BodyTarget,
    EarthFixedTarget,
    GroundTarget,
    PlaceTarget,
    SkyTarget,
    StarTarget,
)

# The judge finds them by itself.
DERIVED_TARGETS = (GroundTarget, PlaceTarget, StarTarget, BodyTarget)


def verify(table: CommandTable, scenario: Scenario) -> VerificationReport:
    """Judge a table without the planner's geometry or solver.

    Never refuses: what is wrong becomes a finding.  OutsideCoverage passes through when the
    orbit isn't known over the sessions.  What the judge doesn't derive again is named in
    `taken_as_given`.
    """
    given = _assumptions(scenario)
    fault = unflyable(table, scenario)
    if fault is not None:
        return VerificationReport(
            passed=False, findings=(fault,), sessions=(), limits=(), taken_as_given=given
        )
    margins = limit_margins(table, scenario)
    keep_out = keep_out_margins(table, scenario)
    masks = mask_margins(table, scenario)
    findings: list[Finding] = [
        *structure_findings(table, scenario),
        *limit_findings(margins, scenario),
        *keep_out_findings(keep_out),
        *mask_findings(masks),
    ]
    reports: list[SessionReport] = []
    rows_by_session = {
        number: rows
        for number, session in enumerate(scenario.sessions)
        if covers(table, rows := session_rows(session, table.epoch_utc))
    }
    ephemeris = cache(lambda: _ephemeris(table, scenario, rows_by_session))  # a propagation is dear
    for number, session in enumerate(scenario.sessions):
        report, session_findings = _judge_session(
            table, scenario, ephemeris, number, session.target, rows_by_session.get(number)
        )
        findings.extend(session_findings)
        if report is not None:
            reports.append(report)
    return VerificationReport(
        passed=not any(finding.severity == "error" for finding in findings),
        findings=tuple(findings),
        sessions=tuple(reports),
        limits=margins,
        taken_as_given=given,
        keep_out=keep_out,
        masks=masks,
        slow_stretches=tuple(slow_outside_sessions(table, scenario)),
    )


def _judge_session(
    table: CommandTable,
    scenario: Scenario,
    ephemeris: Callable[[], Ephemeris],
    number: int,
    target: object,
    rows: range | None,
) -> tuple[SessionReport | None, tuple[Finding, ...]]:
    """rows: None where the table is too short for the session, which is a finding already."""
    if not isinstance(target, EarthFixedTarget | SkyTarget | BenchMotionTarget):
        detail = f"session {number + 1}: the judge can't derive where this target appears"
        return None, (Finding(limit="pointing", detail=detail),)
    if rows is None:
        return None, ()
    if isinstance(target, BenchMotionTarget):
        return bench_session(table_session(table, scenario, number, rows), target)
    return pointing_session(table_session(table, scenario, number, rows), ephemeris(), target)


def _ephemeris(
    table: CommandTable, scenario: Scenario, rows_by_session: dict[int, range]
) -> Ephemeris:
    """The orbit from the first to the last of the sessions that look somewhere."""
    looking = [
        rows
        for number, rows in rows_by_session.items()
        if not isinstance(scenario.sessions[number].target, BenchMotionTarget)
    ]
    return scenario.orbit.ephemeris(
        shifted_utc(table.epoch_utc, min(rows[0] for rows in looking) / ROWS_PER_S),
        shifted_utc(table.epoch_utc, max(rows[-1] for rows in looking) / ROWS_PER_S),
    )


def _assumptions(scenario: Scenario) -> tuple[Given, ...]:
    targets = [session.target for session in scenario.sessions]
    is_motion = [isinstance(target, BenchMotionTarget) for target in targets]
    is_derived = [isinstance(target, (*DERIVED_TARGETS, BenchMotionTarget)) for target in targets]
    attitude = scenario.attitude
    # How far measurements turn it from its law is taken as given.
    is_law = isinstance(attitude, DERIVED_LAWS) and not attitude.corrections
    given: dict[Given, bool] = {
        "orbit": not all(is_motion),
        "attitude": not all(is_motion) and not is_law,
        "target": not all(is_derived),
        "motion": any(is_motion),
    }
    return tuple(name for name, taken in given.items() if taken)
