"""What comes out of planning?"""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from planner.commands import CommandTable
from planner.scenario import Scenario
from planner.sessions.uncertainty import PointingBudget
from planner.slew import SlewComparison
from planner.verification import VerificationReport

SegmentKind = Literal["wait", "slew", "track"]


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A stretch of the table, on its grid: at rest, on the way to the target, or holding it.

    session: index into the scenario's sessions.
    """

    kind: SegmentKind
    session: int
    start_utc: datetime
    stop_utc: datetime


@dataclass(frozen=True, kw_only=True)
class SlewRun:
    """How one slew was solved.

    minimum_s: the least time the limits allow, stops aside.  comparison: None where the
    baseline itself was asked for.
    """

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
    budgets: 1-sigma pointing error per session, None for a test motion.
    stage_wall_s: seconds spent per stage of the pipeline, by name.
    """

    scenario: Scenario
    segments: tuple[Segment, ...]
    table: CommandTable
    verification: VerificationReport
    slews: tuple[SlewRun, ...]
    budgets: tuple[PointingBudget | None, ...]
    warnings: tuple[str, ...]
    stage_wall_s: dict[str, float]
