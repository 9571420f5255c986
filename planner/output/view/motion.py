"""Motion by degree of freedom, as flown between rows."""

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.table_motion import accelerations_rad_s2
from planner.output.view.columns import AxisMotion


def motion_at_rows(table: CommandTable, row: Indices) -> dict[str, AxisMotion]:
    """By degree of freedom, at rows by their numbers (n,); at the last of the cell ending there."""
    cell = np.minimum(row, len(table.t_s) - 2)
    begin, end = np.moveaxis(accelerations_rad_s2(table, cell), 1, 0)
    rate = table.rate_rad_s[row]
    angle = np.full_like(rate, np.nan)
    if table.acceleration_rad_s2 is None:
        angle = table.position[row]
    acceleration = np.where((row > cell)[:, None], end, begin)
    jerk = (end - begin) / COMMAND_STEP_S
    return by_dof(table.dof_names, angle, rate, acceleration, jerk)


def by_dof(names: tuple[str, ...], *motion: Array) -> dict[str, AxisMotion]:
    """motion: angles, rates, accelerations and jerks, (n, m) each."""
    angle, rate, acceleration, jerk = motion
    return {
        name: AxisMotion(
            angle_rad=angle[:, axis],
            rate_rad_s=rate[:, axis],
            acceleration_rad_s2=acceleration[:, axis],
            jerk_rad_s3=jerk[:, axis],
        )
        for axis, name in enumerate(names)
    }
