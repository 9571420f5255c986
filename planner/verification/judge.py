"""Is this command table good?  The independent judge: it reads the table and the scenario."""

from planner.commands import CommandTable
from planner.scenario import Scenario
from planner.targets import GroundTarget
from planner.verification.carrier import DERIVED_LAWS
from planner.verification.earth_fixed import is_earth_fixed
from planner.verification.limits import limit_findings, limit_margins
from planner.verification.pointing import session_report
from planner.verification.report import Finding, SessionReport, VerificationReport
from planner.verification.structure import covers, session_rows, structure_findings, unflyable


def verify(table: CommandTable, scenario: Scenario) -> VerificationReport:
    """Judge a table without the planner's geometry or solver.

    Never refuses: what is wrong becomes a finding.  OutsideCoverage passes through when the
    orbit isn't known over a session.  The orbit's states are an input, as are an attitude
    law's rotations where the judge has no derivation of its own (`taken_as_given`).
    """
    given = _taken_as_given(scenario)
    broken = unflyable(table, scenario)
    if broken is not None:
        return VerificationReport(
            passed=False, findings=(broken,), sessions=(), limits=(), taken_as_given=given
        )
    margins = limit_margins(table, scenario)
    findings: list[Finding] = [
        *structure_findings(table, scenario),
        *limit_findings(margins, scenario),
    ]
    reports: list[SessionReport] = []
    for number, session in enumerate(scenario.sessions):
        rows = session_rows(session, table.epoch_utc)
        target = session.target
        if not is_earth_fixed(target):
            findings.append(_unverifiable(number))
        elif covers(table, rows):
            report, session_findings = session_report(table, scenario, number, target, rows)
            reports.append(report)
            findings.extend(session_findings)
    return VerificationReport(
        passed=not any(finding.severity == "error" for finding in findings),
        findings=tuple(findings),
        sessions=tuple(reports),
        limits=margins,
        taken_as_given=given,
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


def _taken_as_given(scenario: Scenario) -> tuple[str, ...]:
    derives_targets = all(isinstance(session.target, GroundTarget) for session in scenario.sessions)
    return (
        "orbit",
        *(() if isinstance(scenario.attitude, DERIVED_LAWS) else ("attitude",)),
        *(() if derives_targets else ("target",)),
    )
