"""The boresight's path in the platform's frame."""

import numpy as np

from planner.base.arrays import Array, Indices
from planner.verification.platforms.two_axis.carrier import boresight_platform
from planner.verification.platforms.two_axis.hermite import AxisHermite
from planner.world.platforms import TwoAxisPlatform


class AxisPath:
    """What the axes turn; `count` cells, of which `moving` holds those worth looking at."""

    def __init__(self, platform: TwoAxisPlatform, axes: tuple[AxisHermite, ...]) -> None:
        self._platform, self._axes = platform, axes
        self.count = len(axes[0].angle_rad) - 1
        # Of a wait, in which the boresight stands, one cell says as much as all.
        stands = np.logical_and.reduce([axis.is_resting for axis in axes])
        self.moving = np.flatnonzero(~(stands & np.append(False, stands[:-1])))
        # In a cell the acceleration changes evenly: it is greatest at an end.
        at_ends = [
            np.abs([axis.acceleration_after_row_rad_s2, axis.acceleration_before_row_rad_s2])
            for axis in axes
        ]
        self._acceleration_rad_s2 = np.max(at_ends, axis=1).sum(axis=0)

    def boresight(self, cell: Indices, u_s: Array) -> Array:
        """Unit vectors in the platform's frame, (n, 3), u_s after the rows of n cells."""
        angle_rad = np.stack([axis.angle_at(cell, u_s) for axis in self._axes], 1)
        return boresight_platform(self._platform, angle_rad)

    def reach_rad(self, cell: Indices, middle_s: Array, half_s: float) -> Array:
        """How far the boresight can be from the middle within half_s of it: each axis turns it by
        no more than it turns itself."""
        rate_rad_s = sum(np.abs(axis.rate_at(cell, middle_s)) for axis in self._axes)
        return np.asarray(half_s * (rate_rad_s + half_s * self._acceleration_rad_s2[cell] / 2.0))
