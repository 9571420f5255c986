"""The command table as CSV."""

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import CommandTable
from planner.base.csv_cells import comment_lines, csv_lines
from planner.base.header_text import one_line
from planner.output.export.description import notes
from planner.world.frames.time_scales import Instants
from planner.world.plan import FlightPlan


def write_csv(plan: FlightPlan, created_utc: datetime) -> bytes:
    """`table_csv` under lines that begin with `#` and say what the columns don't."""
    return (comment_lines(notes(plan, created_utc)) + table_csv(plan.table)).encode()


def table_csv(table: CommandTable) -> str:
    """As `rows_csv`, a column for each of the table's channels, as in the JSON answer."""
    names, decimals = zip(*((one.name, one.decimals) for one in table.channels), strict=True)
    value_by_row = np.column_stack([value for _, value in table.columns])
    return rows_csv(table.epoch_utc, table.t_s, names, value_by_row, decimals)


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
