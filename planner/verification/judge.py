"""The independent judge of a command table: it reads the table and the scenario."""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np

from planner.base.commands import ROWS_PER_S, CommandTable
from planner.verification.field_masks import mask_findings
from planner.verification.limits import (
    exclusion_findings,
    gyro_findings,
    keep_out_findings,
    limit_findings,
)
from planner.verification.platforms.judge import Judge, JudgedSession
from planner.verification.platforms.registry import judge_of
from planner.verification.pointing import pointing_session
from planner.verification.report import (
    Finding,
    Given,
    SessionReport,
    SlowStretch,
    VerificationReport,
)
from planner.verification.resources import (
    Waits,
    resource_findings,
    resource_margins,
    wait_findings,
)
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
    StationTarget,
)

# The judge finds them by itself.
DERIVED_TARGETS = (GroundTarget, PlaceTarget, StationTarget, StarTarget, BodyTarget)


def verify(table: CommandTable, scenario: Scenario, waits: Waits = ()) -> VerificationReport:
    """Judge a table without the planner's geometry or solver.

    waits: when the platform is said to idle, for resources; the judge looks whether it does.

    Never refuses: what is wrong becomes a finding.  OutsideCoverage passes through when the
    orbit isn't known over the sessions.  What the judge doesn't derive again is named in
    `taken_as_given`.
    """
    judge = judge_of(table, scenario)
    given = _assumptions(scenario, judge)
    fault = unflyable(table, judge)
    if fault is not None:
        return VerificationReport(
            passed=False, findings=(fault,), sessions=(), limits=(), taken_as_given=given
        )
    margins = judge.margins()
    keep_out, masks, exclusions = judge.keep_out(), judge.masks(), judge.exclusions()
    gyros = judge.gyros()
    resources = resource_margins(table, scenario, judge, waits)
    findings: list[Finding] = [
        *structure_findings(table, scenario, judge),
        *limit_findings(margins),
        *keep_out_findings(keep_out),
        *mask_findings(masks),
        *exclusion_findings(exclusions),
        *gyro_findings(gyros),
        *resource_findings(resources, scenario),
        *(wait_findings(table, scenario, judge, waits) if resources else ()),
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
            table, scenario, judge, ephemeris, number, session.target, rows_by_session.get(number)
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
        exclusions=exclusions,
        resources=resources,
        gyros=gyros,
        slow_stretches=tuple(_slow_outside_sessions(table, scenario, judge)),
    )


def _judge_session(
    table: CommandTable,
    scenario: Scenario,
    judge: Judge,
    ephemeris: Callable[[], Ephemeris],
    number: int,
    target: object,
    rows: range | None,
) -> JudgedSession:
    """rows: None where the table is too short for the session, which is a finding already."""
    if not isinstance(target, EarthFixedTarget | SkyTarget | BenchMotionTarget):
        detail = f"session {number + 1}: the judge can't derive where this target appears"
        return None, (Finding(limit="pointing", detail=detail),)
    if rows is None:
        return None, ()
    if isinstance(target, BenchMotionTarget):
        return judge.prescribed(number, rows, target)
    flight = table_session(table, scenario, judge, number, rows)
    return pointing_session(flight, ephemeris(), target)


def _slow_outside_sessions(
    table: CommandTable, scenario: Scenario, judge: Judge
) -> Iterator[SlowStretch]:
    """Wherever no session is held; an axis that stands still is not slow."""
    held = np.zeros(len(table.t_s) - 1, dtype=bool)
    for session in scenario.sessions:
        rows = session_rows(session, table.epoch_utc)
        held[max(rows[0], 0) : max(rows[-1], 0)] = True
    return judge.slow_stretches(~held, standing=False)


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


def _assumptions(scenario: Scenario, judge: Judge) -> tuple[Given, ...]:
    targets = [session.target for session in scenario.sessions]
    is_motion = [isinstance(target, BenchMotionTarget) for target in targets]
    is_derived = [isinstance(target, (*DERIVED_TARGETS, BenchMotionTarget)) for target in targets]
    given: dict[Given, bool] = {
        "orbit": not all(is_motion),
        "attitude": not all(is_motion) and not judge.derives_attitude,
        "target": not all(is_derived),
        "motion": any(is_motion),
    }
    return tuple(name for name, taken in given.items() if taken)
