"""Rows of a table that a view shows."""

import math

import numpy as np

from planner.base.arrays import Indices
from planner.base.commands import ROWS_PER_S
from planner.base.errors import InvalidInput

USUAL_ROWS = 1000  # enough for a screen
ROWS_MAX = 20_000
CELLS_MAX = 400_000  # rows times what is seen beside the carrier: sessions and cones
STEP_MAX_S = 86400.0
_ON_GRID_ROWS = 1e-9  # rounding


def view_rows(table_rows: int, beside: int, step_s: float | None) -> tuple[Indices, float]:
    """Numbers of every `step_s`th row and the last, (n,); and the step, chosen if not given.

    table_rows: how many the table has.  beside: what is seen beside the carrier.
    The chosen step is the least whole number of rows that shows at most `USUAL_ROWS`.
    Raises InvalidInput for a step that isn't a multiple of the table's or shows too many rows.
    """
    last_row = table_rows - 1
    most = min(ROWS_MAX, CELLS_MAX // max(1, beside))
    if step_s is None:
        every = max(1, math.ceil(last_row / (min(USUAL_ROWS, most) - 1)))
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
    every = round(step_s * ROWS_PER_S) if 0.0 < step_s <= STEP_MAX_S else 0
    if every < 1 or abs(step_s * ROWS_PER_S - every) > _ON_GRID_ROWS:
        raise InvalidInput(
            f"step_s must be a multiple of the table's step, 0.2 s, up to {STEP_MAX_S:g}, not "
            f"{step_s:g}; use 0.2, 1 or 10",
            field="step_s",
        )
    return every
