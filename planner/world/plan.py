"""A plan: the scenario flown, its segments, and the command table."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, get_args

from planner.base.commands import CommandTable
from planner.world.scenario import Scenario

SegmentKind = Literal["wait", "slew", "track", "brake"]
KINDS: tuple[SegmentKind, ...] = get_args(SegmentKind)


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A stretch of the table, on its grid: at rest, on the way to the target, or holding it.

    A "brake" brings moving axes to rest, so that they can wait.

    session: index into the scenario's sessions; None: to the final state.
    """

    kind: SegmentKind
    session: int | None
    start_utc: datetime
    stop_utc: datetime


@dataclass(frozen=True, kw_only=True)
class FlightPlan:
    """scenario: with its sessions shortened where a conflict asked for it."""

    scenario: Scenario
    segments: tuple[Segment, ...]
    table: CommandTable
