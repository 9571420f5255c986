"""A plan as every format is written from it: what was asked, and the table that does it."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, get_args

from planner.commands import CommandTable
from planner.scenario import Scenario

SegmentKind = Literal["wait", "slew", "track"]
KINDS: tuple[SegmentKind, ...] = get_args(SegmentKind)


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
class FlightPlan:
    """scenario: with its sessions shortened where a conflict asked for it."""

    scenario: Scenario
    segments: tuple[Segment, ...]
    table: CommandTable
