"""The command table as CSV."""

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import CommandTable
from planner.base.csv_cells import comment_lines, csv_lines
from planner.output.export.description import DECIMALS, columns, notes, one_line
from planner.world.frames.time_scales import Instants
from planner.world.plan import FlightPlan


def write_csv(plan: FlightPlan, created_utc: datetime) -> bytes:
    """`table_csv` under lines that begin with `#` and say what the columns don't."""
    return (comment_lines(notes(plan, created_utc)) + table_csv(plan.table)).encode()


def table_csv(table: CommandTable) -> str:
    """As `rows_csv`: `NAME_deg` and `NAME_rate_deg_s` of each axis.

    Degrees to 1e-9 (4 microarcsec), as in the JSON answer.
    """
    table_columns = columns(table)
    names = [column.name for column in table_columns]
    value_by_row = np.column_stack([column.value_by_row for column in table_columns])
    return rows_csv(table.epoch_utc, table.t_s, names, value_by_row, [DECIMALS] * len(names))


def rows_csv(
    epoch_utc: datetime,
    t_s: Array,
    names: Sequence[str],
    value_by_row: Array,
    decimals: Sequence[int],
) -> str:
    """One row per 0.2 s: `utc`, `t_s`, then columns, (n, k), by their names and decimals."""
    layout = ",".join(f"%.{count}f" for count in decimals)
    lines = [csv_lines([["utc", "t_s", *map(one_line, names)]])]
    utc = Instants(epoch_utc, t_s).utc_text(1)
    for moment, t, row in zip(utc, t_s.tolist(), value_by_row.tolist(), strict=True):
        lines.append(f"{moment},{t:.1f},{layout % tuple(row)}\n")
    return "".join(lines)
