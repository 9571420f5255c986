"""The command table: plain data, made by one part and judged by another."""

from dataclasses import dataclass
from datetime import datetime

import numpy as np

from planner.base.arrays import Array

ROWS_PER_S = 5  # Sumarokov 2016: the platform is fed every 0.2 s
COMMAND_STEP_S = 1.0 / ROWS_PER_S


@dataclass(frozen=True, kw_only=True)
class CommandTable:
    """Angle and rate of each axis every `COMMAND_STEP_S`, counted from `epoch_utc`.

    epoch_utc: a whole multiple of 0.2 s after its UTC second.
    axis_names: (m,).  angle_rad, rate_rad_s: shape (n, m), row k at epoch_utc + 0.2 k s
    (SI seconds).  Between rows the platform flies the cubic Hermite of the two rows.
    """

    epoch_utc: datetime
    axis_names: tuple[str, ...]
    angle_rad: Array
    rate_rad_s: Array

    @property
    def t_s(self) -> Array:
        """Seconds since the epoch of each row; k/5 is the closest double to 0.2 k, 0.2*k is not."""
        return np.arange(len(self.angle_rad)) / ROWS_PER_S
