"""A plan: the scenario flown, its segments, and the command table."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, get_args

from planner.base.answer_members import Count, answer
from planner.base.commands import ROWS_PER_S, CommandTable
from planner.base.rotation import Rotation
from planner.base.table_motion import motion_at
from planner.world.frames.time_scales import Instants, RowUtc, elapsed_s
from planner.world.orbits import OrbitStates
from planner.world.scenario import Scenario

SegmentKind = Literal["wait", "slew", "track", "brake"]
KINDS: tuple[SegmentKind, ...] = get_args(SegmentKind)


@answer
class Segment:
    """A stretch of the table.

    kind: at rest, brought to rest in order to wait, on the way to a session's target, or tracking
    it.
    session: number of the session it belongs to, from 0; null on the way to the final state.
    start_utc: its first row; UTC.
    stop_utc: its last row; UTC.
    """

    kind: SegmentKind
    session: Count | None
    start_utc: RowUtc
    stop_utc: RowUtc


def segment_rows(table: CommandTable, segment: Segment) -> tuple[int, int]:
    """Its first and last row."""
    first_s = elapsed_s(segment.start_utc, table.epoch_utc)
    last_s = elapsed_s(segment.stop_utc, table.epoch_utc)
    return round(first_s * ROWS_PER_S), round(last_s * ROWS_PER_S)


@dataclass(frozen=True, kw_only=True)
class FlightPlan:
    """scenario: with its sessions shortened where a conflict asked for it."""

    scenario: Scenario
    segments: tuple[Segment, ...]
    table: CommandTable

    @property
    def waits(self) -> tuple[tuple[datetime, datetime], ...]:
        """When the platform idles; UTC."""
        return tuple((one.start_utc, one.stop_utc) for one in self.segments if one.kind == "wait")

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """n attitudes of the carrier by its law, or of a body as it flies its table."""
        flown = motion_at(self.table, instants.since_s(self.table.epoch_utc))
        return self.scenario.q_body_from_eci(instants, states, flown.position)
