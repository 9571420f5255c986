"""The table of a comparison: of each axis and sample used, the plan, the flight and the error."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from planner.base.csv_cells import comment_lines, csv_lines
from planner.output.export.description import DECIMALS, notes

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison
    from planner.inflight.telemetry.findings import AxisComparison

_NAMES = ("axis", "t_s", "planned_deg", "flown_deg", "error_arcsec")


def write_comparison_csv(comparison: Comparison, created_utc: datetime) -> bytes:
    """A line per axis and sample, by the plan's clock."""
    rows = (row for axis in comparison.axes for row in _rows(axis))
    return (
        comment_lines(notes(comparison.plan, created_utc)) + csv_lines([_NAMES, *rows])
    ).encode()


def _rows(axis: AxisComparison) -> Iterator[tuple[object, ...]]:
    followed = axis.followed
    planned_deg = np.degrees(followed.motion.angle_rad(followed.t_s))
    error_deg = np.degrees(followed.error_rad)
    numbers = (followed.t_s, planned_deg, planned_deg + error_deg, error_deg * 3600.0)
    rounded = [np.round(column, DECIMALS) + 0.0 for column in numbers]  # no -0.0
    for row in np.transpose(rounded).tolist():
        yield axis.name, *row
