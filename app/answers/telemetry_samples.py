"""Columns and rows of telemetry that were used or left out, as a comparison answers them."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from planner.base.answer_members import Count, NotNegative
from planner.inflight.telemetry.platforms.sensors import ToldKind
from planner.inflight.telemetry.samples import ColumnUnit, Dropped
from planner.world.frames.time_scales import shifted_utc, utc_text

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison


@dataclass(frozen=True, kw_only=True)
class StretchOut:
    """Of time, by the plan's clock.

    start: start of the stretch; UTC. E.g. `"2015-02-27T17:36:20.000Z"`.
    stop: end of the stretch; UTC. E.g. `"2015-02-27T17:36:24.000Z"`.
    """

    start: str
    stop: str


@dataclass(frozen=True, kw_only=True)
class TelemetryColumnOut:
    """The reading of one column.

    name: as it was sent.
    axis: the axis it belongs to; of an attitude, the part of the quaternion that it holds.
    kind: of its angle or its rate, or of a body's attitude.
    unit: in which it was read, as its name or `columns` says; of a rate, per second.
    """

    name: str
    axis: str
    kind: ToldKind
    unit: ColumnUnit


@dataclass(frozen=True, kw_only=True)
class SamplesOut:
    """The use of the rows: read, left out, compared.

    read: rows there were: those used and those dropped.
    used: rows that the comparison rests on.
    dropped: rows by reason: `no_time` and `no_value` hold no number there, `repeated` have a time
    tag again, `held` only values of the row before while the plan moves on, `outside_plan` lie
    before or after its table, `outlier` stand out from those around. E.g. `{"outlier": 3}`.
    reordered: rows used that came before an earlier one.
    wrapped: angles that were brought within half a turn of the plan.
    start: of the first row used; UTC.
    stop: of the last row used; UTC.
    step_s: usual time from row to row.
    gaps: stretches without rows, at most 200. E.g.
    `[{"start": "2015-02-27T17:35:00.000Z", "stop": "2015-02-27T17:35:10.000Z"}]`.
    columns: those read.
    ignored_columns: names of those that are none of the contract nor in `columns`, or are empty.
    E.g. `["temperature"]`.
    """

    read: Count
    used: Count
    dropped: dict[Dropped, Count]
    reordered: Count
    wrapped: Count
    start: str
    stop: str
    step_s: NotNegative
    gaps: list[StretchOut]
    columns: list[TelemetryColumnOut]
    ignored_columns: list[str]


def samples_of(comparison: "Comparison") -> SamplesOut:
    """Rows read, used and dropped, and the columns."""
    clean, alignment = comparison.samples, comparison.alignment
    first_s, last_s = alignment.t_s(clean.tag_s[[0, -1]]).tolist()
    return SamplesOut(
        read=clean.read,
        used=len(clean.tag_s),
        dropped=dict(clean.dropped),
        reordered=clean.reordered,
        wrapped=comparison.wrapped,
        step_s=round(comparison.step_s, 6),
        gaps=[StretchOut(**span(comparison, *gap_s)) for gap_s in comparison.gaps_s],
        columns=[TelemetryColumnOut(**column._asdict()) for column in comparison.columns],
        ignored_columns=list(comparison.ignored),
        **span(comparison, first_s, last_s),
    )


def span(comparison: "Comparison", start_s: float, stop_s: float) -> dict[str, str]:
    """Start and stop in UTC, of seconds after the table's epoch."""
    epoch_utc = comparison.plan.table.epoch_utc
    return {
        "start": utc_text(shifted_utc(epoch_utc, start_s)),
        "stop": utc_text(shifted_utc(epoch_utc, stop_s)),
    }
