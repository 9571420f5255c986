"""What comes out of planning?"""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from planner.commands import CommandTable
from planner.scenario import Scenario
from planner.slew import SlewComparison
from planner.verification import VerificationReport


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A stretch of the table, on its grid: the way to a session's target, or the target held.

    session: index into the scenario's sessions.
    """

    kind: Literal["slew", "track"]
    session: int
    start_utc: datetime
    stop_utc: datetime


@dataclass(frozen=True, kw_only=True)
class SlewRun:
    """How one slew was solved.  comparison: None where the method asked for was the baseline."""

    session: int
    backend: str
    status: str
    iterations: int
    wall_s: float
    duration_s: float
    minimum_s: float
    comparison: SlewComparison | None


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A command table with everything needed to trust it.

    verification: the independent judge's report; a plan is only made when it passed, except
    for the baseline spline, whose broken limits the report and the warnings carry.
    stage_wall_s: seconds spent per stage of the pipeline, by name.
    """

    scenario: Scenario
    segments: tuple[Segment, ...]
    table: CommandTable
    verification: VerificationReport
    slews: tuple[SlewRun, ...]
    warnings: tuple[str, ...]
    stage_wall_s: dict[str, float]
