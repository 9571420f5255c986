"""An export format, and the plan that every format is written from."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, Literal, TypeVar, get_args

from planner.commands import CommandTable
from planner.scenario import Scenario

P = TypeVar("P")
SegmentKind = Literal["wait", "slew", "track", "brake"]
KINDS: tuple[SegmentKind, ...] = get_args(SegmentKind)


@dataclass(frozen=True)
class Exporter(Generic[P]):
    """One format of one kind of plan.

    title: what the file holds.  write(plan, created_utc): the file's bytes; created_utc is
    the date the file states.  Raises OutsideCoverage when orbit or attitude is unknown while
    a target is tracked.  shows: whether it draws the plan on a map, a globe or a plot, so that it
    is also offered where a plan is looked at.
    """

    title: str
    media_type: str
    suffix: str
    write: Callable[[P, datetime], bytes]
    shows: bool = False


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
