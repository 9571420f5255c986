"""The command table as CSV."""

from datetime import datetime

import numpy as np

from planner.commands import CommandTable
from planner.export.description import DECIMALS, columns, notes, one_line
from planner.export.exporter import FlightPlan
from planner.frames.time_scales import Instants


def write_csv(plan: FlightPlan, created_utc: datetime) -> bytes:
    """`table_csv` under lines that begin with `#` and say what the columns don't."""
    head = [f"# {note}\n" for note in notes(plan, created_utc)]
    return ("".join(head) + table_csv(plan.table)).encode()


def table_csv(table: CommandTable) -> str:
    """One row per 0.2 s: `utc`, `t_s`, then `NAME_deg` and `NAME_rate_deg_s` of each axis.

    Degrees to 1e-9 (4 microarcsec), as in the JSON answer.
    """
    table_columns = columns(table)
    utc = Instants(table.epoch_utc, table.t_s).utc_text(1)
    t_s = table.t_s.tolist()
    rows = np.column_stack([column.value_by_row for column in table_columns]).tolist()
    lines = [",".join(["utc", "t_s", *(_quote(column.name) for column in table_columns)])]
    for moment, t, row in zip(utc, t_s, rows, strict=True):
        lines.append(f"{moment},{t:.1f}," + ",".join(f"{value:.{DECIMALS}f}" for value in row))
    return "\n".join(lines) + "\n"


def _quote(name: str) -> str:
    """As RFC 4180 has it where a name holds what would part columns or lines."""
    return name if name.isidentifier() else '"' + one_line(name).replace('"', '""') + '"'
