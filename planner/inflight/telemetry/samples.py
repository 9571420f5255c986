"""Telemetry as it came, and what was left of it: rows, what was dropped and why."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from planner.base.arrays import Array
from planner.inflight.telemetry.columns import TelemetryColumn

SAMPLES_MIN = 8  # fewer tell nothing of a clock
Dropped = Literal[
    "no_time",
    "no_value",
    "repeated",
    "held",
    "clock_reset",
    "outside_plan",
    "outlier",
]


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Rows in the order in which they came.

    epoch_utc: from which t_s counts by the telemetry's clock.  t_s: (n,), NaN where there is no
    time tag.  columns: each (n,).  ignored: names of columns that were not read.  notes: what was
    found out or taken for granted in reading.
    """

    epoch_utc: datetime
    t_s: Array
    columns: tuple[TelemetryColumn, ...]
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class CleanSamples:
    """Rows that are used, in the order of their time tags, in radians.

    tag_s: (n,), the telemetry's clock less the table's epoch, strictly increasing.
    angle_rad, rate_rad_s: (n, 2), NaN where an axis has none.  read: rows there were.
    dropped: rows by reason.  reordered: rows that came before an earlier one.
    """

    tag_s: Array
    angle_rad: Array
    rate_rad_s: Array
    read: int
    dropped: Mapping[Dropped, int]
    reordered: int
