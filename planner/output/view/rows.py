"""Rows of a table that a view shows."""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Indices
from planner.base.commands import ROWS_PER_S
from planner.base.errors import InvalidInput


@dataclass(frozen=True, kw_only=True)
class ViewBounds:
    """How many rows of a plan are shown."""

    usual_rows: int = 1000  # enough for a screen
    rows_max: int = 20_000  # asked for at once
    cells_max: int = 400_000  # rows times what is seen beside the carrier: sessions and cones
    step_max_s: float = 86400.0  # a day, the longest plan
    on_grid_rows: float = 1e-9  # rounding


BOUNDS = ViewBounds()


def view_rows(table_rows: int, beside: int, step_s: float | None) -> tuple[Indices, float]:
    """Numbers of every `step_s`th row and the last, (n,); and the step, chosen if not given.

    table_rows: how many the table has.  beside: what is seen beside the carrier.
    The chosen step is the least whole number of rows that shows at most `BOUNDS.usual_rows`.
    Raises InvalidInput for a step that isn't a multiple of the table's or shows too many rows.
    """
    last_row = table_rows - 1
    most = min(BOUNDS.rows_max, BOUNDS.cells_max // max(1, beside))
    if step_s is None:
        every = max(1, math.ceil(last_row / (min(BOUNDS.usual_rows, most) - 1)))
    else:
        every = rows_in_step(step_s)
    count = math.ceil(last_row / every) + 1
    if count > most:
        least_s = math.ceil(last_row / (most - 1)) / ROWS_PER_S
        raise InvalidInput(
            f"step_s {step_s:g} makes {count} rows of this table, and a view has at most {most} "
            f"of it; use {least_s:g} or more",
            field="step_s",
        )
    row = np.unique([*range(0, last_row, every), last_row])
    return row, every / ROWS_PER_S


def rows_in_step(step_s: float) -> int:
    """How many rows of a table it is; raises InvalidInput unless a whole number."""
    every = round(step_s * ROWS_PER_S) if 0.0 < step_s <= BOUNDS.step_max_s else 0
    if every < 1 or abs(step_s * ROWS_PER_S - every) > BOUNDS.on_grid_rows:
        raise InvalidInput(
            f"step_s must be a multiple of the table's step, 0.2 s, up to {BOUNDS.step_max_s:g}, "
            f"not {step_s:g}; use 0.2, 1 or 10",
            field="step_s",
        )
    return every
