"""The command table: attitude and gimbal rows every 0.2 s, and when the camera runs.

Plain data: made by the planner, judged and simulated by parts that never saw it.
"""

from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from planner.base.answer_members import Count
from planner.base.arrays import Array
from planner.base.commands import (
    BODY_CHANNELS,
    COMMAND_STEP_S,
    GIMBAL_CHANNELS,
    ROWS_PER_S,
    CommandTable,
)
from planner.base.mrp import BodyMotion
from planner.base.rotation import Rotation
from planner.base.table_motion import body_motion_at

TICK_S = COMMAND_STEP_S  # Platonov, Sumarokov 2019: the control cycle


@dataclass(frozen=True, kw_only=True)
class ImagingWindow:
    """One stretch of imaging: rows first_row .. last_row, both with the camera on.

    request, look: which request, and which strip, look or leg of it (from 0).
    """

    request: str
    look: Count
    first_row: Count
    last_row: Count


@dataclass(frozen=True, kw_only=True)
class AttitudeTable:
    """Rows k at epoch_utc + 0.2 k s (SI seconds).

    eci_from_body_xyzw: (n, 4), scalar last, turns body vectors into ECI: `q_body_from_eci`
    inverted.  omega_body_rad_s: body relative to ECI in body axes, (n, 3), and its
    derivative alpha_body_rad_s2.  gimbal_rad, gimbal_rate_rad_s: (n, 4), rate held until the
    next row.  Between rows the attitude is the quintic Hermite of the two rows in Rodrigues
    parameters (attitude, rate and acceleration all meet).
    """

    epoch_utc: datetime
    eci_from_body_xyzw: Array
    omega_body_rad_s: Array
    alpha_body_rad_s2: Array
    gimbal_rad: Array
    gimbal_rate_rad_s: Array
    windows: tuple[ImagingWindow, ...]

    @classmethod
    def of_body(cls, flown: CommandTable, windows: tuple[ImagingWindow, ...]) -> "AttitudeTable":
        """The table of a body with gyros, and when its camera runs."""
        assert flown.acceleration_rad_s2 is not None  # a body's table has it,
        assert flown.extra_rad is not None  # and of gyros their gimbals
        gimbal_rad, gimbal_rate_rad_s = np.hsplit(flown.extra_rad, 2)
        return cls(
            epoch_utc=flown.epoch_utc,
            eci_from_body_xyzw=flown.position,
            omega_body_rad_s=flown.rate_rad_s,
            alpha_body_rad_s2=flown.acceleration_rad_s2,
            gimbal_rad=gimbal_rad,
            gimbal_rate_rad_s=gimbal_rate_rad_s,
            windows=windows,
        )

    @property
    def t_s(self) -> Array:
        """Seconds since the epoch of each row, (n,)."""
        return np.arange(len(self.omega_body_rad_s)) / ROWS_PER_S

    @property
    def q_body_from_eci(self) -> Rotation:
        """Attitudes of the n rows."""
        return Rotation.from_quat(self.eci_from_body_xyzw).inv()

    def attitude_at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        """q_body_from_eci and body rates at any instants (m,) from the first to the last row."""
        q_eci_from_body, motion = body_motion_at(
            self.eci_from_body_xyzw, self.omega_body_rad_s, self.alpha_body_rad_s2, t_s
        )
        return q_eci_from_body.inv(), motion

    @property
    def commands(self) -> CommandTable:
        """The same as the table of a body with gyros."""
        return CommandTable(
            epoch_utc=self.epoch_utc,
            channels=(*BODY_CHANNELS, *GIMBAL_CHANNELS),
            position=self.eci_from_body_xyzw,
            rate_rad_s=self.omega_body_rad_s,
            acceleration_rad_s2=self.alpha_body_rad_s2,
            extra_rad=np.hstack([self.gimbal_rad, self.gimbal_rate_rad_s]),
        )

    def imaging(self) -> NDArray[np.bool_]:
        """Whether the camera runs from row k to k + 1, shape (n - 1,)."""
        return camera_on(self.windows, len(self.omega_body_rad_s))


def camera_on(windows: tuple[ImagingWindow, ...], rows: int) -> NDArray[np.bool_]:
    """Whether the camera runs from row k to k + 1, shape (rows - 1,)."""
    on = np.zeros(rows - 1, dtype=bool)
    for window in windows:
        on[window.first_row : window.last_row] = True
    return on
