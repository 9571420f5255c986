"""The independent judge of a command table: it reads the table and the scenario."""

from collections.abc import Callable
from functools import cache

from planner.commands import ROWS_PER_S, CommandTable
from planner.frames.time_scales import shifted_utc
from planner.orbits import Ephemeris
from planner.scenario import Scenario
from planner.targets import (
    BenchMotionTarget,
    BodyTarget,
    EarthFixedTarget,
    GroundTarget,
    SkyTarget,
    StarTarget,
)
from planner.verification.bench_motion import bench_session
from planner.verification.carrier import DERIVED_LAWS
from planner.verification.keep_out import keep_out_findings, keep_out_margins
from planner.verification.limits import limit_findings, limit_margins
from planner.verification.pointing import ground_session, sky_session
from planner.verification.report import Finding, Given, SessionReport, VerificationReport
from planner.verification.structure import covers, session_rows, structure_findings, unflyable

DERIVED_TARGETS = (GroundTarget, StarTarget, BodyTarget)  # the judge finds them by itself


def verify(table: CommandTable, scenario: Scenario) -> VerificationReport:
    """Judge a table without the planner's geometry or solver.

    Never refuses: what is wrong becomes a finding.  OutsideCoverage passes through when the
    orbit isn't known over the sessions.  What the judge doesn't derive again is named in
    `taken_as_given`.
    """
    given = _assumptions(scenario)
    broken = unflyable(table, scenario)
    if broken is not None:
        return VerificationReport(
            passed=False, findings=(broken,), sessions=(), limits=(), taken_as_given=given
        )
    margins = limit_margins(table, scenario)
    keep_out = keep_out_margins(table, scenario)
    findings: list[Finding] = [
        *structure_findings(table, scenario),
        *limit_findings(margins, scenario),
        *keep_out_findings(keep_out),
    ]
    reports: list[SessionReport] = []
    covered = {
        number: rows
        for number, session in enumerate(scenario.sessions)
        if covers(table, rows := session_rows(session, table.epoch_utc))
    }
    ephemeris = cache(lambda: _ephemeris(table, scenario, covered))  # a propagation is dear
    for number, session in enumerate(scenario.sessions):
        report, session_findings = _judge_session(
            table, scenario, ephemeris, number, session.target, covered.get(number)
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
        return None, (_unverifiable(number),)
    if rows is None:
        return None, ()
    if isinstance(target, BenchMotionTarget):
        return bench_session(table, scenario, number, target, rows)
    if isinstance(target, SkyTarget):
        return sky_session(table, scenario, ephemeris(), number, target, rows)
    return ground_session(table, scenario, ephemeris(), number, target, rows)


def _ephemeris(table: CommandTable, scenario: Scenario, covered: dict[int, range]) -> Ephemeris:
    """The orbit from the first to the last of the sessions that look somewhere."""
    looking = [
        rows
        for number, rows in covered.items()
        if not isinstance(scenario.sessions[number].target, BenchMotionTarget)
    ]
    return scenario.orbit.ephemeris(
        shifted_utc(table.epoch_utc, min(rows[0] for rows in looking) / ROWS_PER_S),
        shifted_utc(table.epoch_utc, max(rows[-1] for rows in looking) / ROWS_PER_S),
    )


def _unverifiable(number: int) -> Finding:
    return Finding(
        severity="error",
        limit="pointing",
        axis=None,
        t_s=None,
        at_utc=None,
        detail=f"sessions.{number}: the judge can't derive where this target appears",
    )


def _assumptions(scenario: Scenario) -> tuple[Given, ...]:
    targets = [session.target for session in scenario.sessions]
    moved = [isinstance(target, BenchMotionTarget) for target in targets]
    found = [isinstance(target, (*DERIVED_TARGETS, BenchMotionTarget)) for target in targets]
    given: dict[Given, bool] = {
        "orbit": not all(moved),
        "attitude": not all(moved) and not isinstance(scenario.attitude, DERIVED_LAWS),
        "target": not all(found),
        "motion": any(moved),
    }
    return tuple(name for name, taken in given.items() if taken)
