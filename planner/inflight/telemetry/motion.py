"""The planned motion at any time: the platform's cubic Hermite between rows."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.hermite import AxisHermite

EDGE_S = 1e-4  # by which a clock set right may put the table's first and last row outside


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """Angle, rate and acceleration of one axis of a table, at t_s seconds after its epoch.

    Before the first row and after the last the axis is taken to rest where the table has it.
    """

    table: CommandTable
    axis: int

    @cached_property
    def _curve(self) -> AxisHermite:
        return AxisHermite(self.table.angle_rad[:, self.axis], self.table.rate_rad_s[:, self.axis])

    @property
    def stop_s(self) -> float:
        return float(len(self.table.angle_rad) - 1) / ROWS_PER_S

    def is_within(self, t_s: Array) -> Mask:
        """Whether the table covers each time, (n,)."""
        return np.asarray((t_s >= -EDGE_S) & (t_s <= self.stop_s + EDGE_S))

    def angle_rad(self, t_s: Array) -> Array:
        """(n,)."""
        cell, u_s = self._place(t_s)
        return self._curve.angle_at(cell, u_s)

    def rate_rad_s(self, t_s: Array) -> Array:
        """(n,); zero outside."""
        cell, u_s = self._place(t_s)
        return np.where(self.is_within(t_s), self._curve.rate_at(cell, u_s), 0.0)

    def acceleration_rad_s2(self, t_s: Array) -> Array:
        """(n,); zero outside."""
        cell, u_s = self._place(t_s)
        half, jerk = self._curve.half_acceleration_rad_s2, self._curve.sixth_jerk_rad_s3
        inside = 2.0 * half[cell] + 6.0 * jerk[cell] * u_s
        return np.where(self.is_within(t_s), inside, 0.0)

    def _place(self, t_s: Array) -> tuple[Indices, Array]:
        inside_s = np.clip(t_s, 0.0, self.stop_s)
        cells = len(self.table.angle_rad) - 1
        cell = np.minimum((inside_s * ROWS_PER_S).astype(np.intp), cells - 1)
        return cell, inside_s - cell * COMMAND_STEP_S
