"""How is a command table written as CSV?"""

import numpy as np

from planner.commands import CommandTable
from planner.frames.time_scales import Instants


def table_csv(table: CommandTable) -> str:
    """One row per 0.2 s: `utc`, `t_s`, then `NAME_deg` and `NAME_rate_deg_s` of each axis.

    Degrees to 1e-9 (4 microarcsec), as in the JSON answer.
    """
    columns, values = ["utc", "t_s"], []
    for column, axis in enumerate(table.axis_names):
        columns.append(f"{axis}_deg")
        values.append(np.degrees(table.angle_rad[:, column]))
    for column, axis in enumerate(table.axis_names):
        columns.append(f"{axis}_rate_deg_s")
        values.append(np.degrees(table.rate_rad_s[:, column]))
    utc = Instants(table.epoch_utc, table.t_s).utc_text(1)
    t_s = table.t_s.tolist()
    rounded = np.round(np.column_stack(values), 9) + 0.0  # no -0.000000000
    lines = [",".join(columns)]
    for moment, t, row in zip(utc, t_s, rounded.tolist(), strict=True):
        lines.append(f"{moment},{t:.1f}," + ",".join(f"{value:.9f}" for value in row))
    return "\n".join(lines) + "\n"
