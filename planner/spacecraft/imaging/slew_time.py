"""Estimates of a slew's duration, good enough to choose by.

Least time about the hardest axis for the angle, from rest to rest; what ends that move with
the slew save and ends that move against it cost; an allowance for ends that move aside and the
settling time before imaging.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.motion.attitude.eigenaxis import quickest_angle
from planner.motion.attitude.track import agility_limits
from planner.spacecraft.table import TICK_S
from planner.world.platforms import BodyPlatform


@dataclass(frozen=True, kw_only=True)
class SlewTimeOptions:
    """What an estimate adds to the eigenaxis slew from rest to rest."""

    smooth: float = 1.03  # what a slew whose jerk switches on rows takes
    allowance_s: float = 0.8  # for rates of 0.4 deg/s aside at 1 deg/s^2, both ends


OPTIONS = SlewTimeOptions()
ANGLES_DEG = np.array(
    [0.05, 1.0, 2.0, 4.0, 7.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0, 130.0, 180.0]
)


@dataclass(frozen=True, eq=False, kw_only=True)
class MovingEnds:
    """Attitudes with how they turn: q_body_from_eci_xyzw (n, 4), rate_eci_rad_s (n, 3)."""

    q_body_from_eci_xyzw: Array
    rate_eci_rad_s: Array

    @classmethod
    def between(cls, now: Rotation, later: Rotation) -> "MovingEnds":
        """n attitudes and the same a tick later, by differences: 1e-6 rad/s."""
        return cls(
            q_body_from_eci_xyzw=now.as_quat(),
            rate_eci_rad_s=(later.inv() * now).as_rotvec() / TICK_S,
        )

    @classmethod
    def concatenate(cls, parts: "Sequence[MovingEnds]") -> "MovingEnds":
        """All of them in one."""
        return cls(
            q_body_from_eci_xyzw=np.concatenate([part.q_body_from_eci_xyzw for part in parts]),
            rate_eci_rad_s=np.concatenate([part.rate_eci_rad_s for part in parts]),
        )

    def __getitem__(self, k: NDArray[np.int64] | slice) -> "MovingEnds":
        return MovingEnds(
            q_body_from_eci_xyzw=self.q_body_from_eci_xyzw[k], rate_eci_rad_s=self.rate_eci_rad_s[k]
        )


@dataclass(frozen=True, eq=False)
class SlewTime:
    """Seconds between two imaging intervals.

    seconds: from rest to rest about one axis through angles_rad, (m,) each, everything else
    included.  rate, acceleration: about that axis.
    """

    angles_rad: Array
    seconds: Array
    rate_rad_s: float
    acceleration_rad_s2: float

    def plus(self, more_s: float) -> "SlewTime":
        """Add so much time to every slew."""
        return replace(self, seconds=self.seconds + more_s)

    @property
    def widest_ticks(self) -> int:
        """The most any slew takes: half a revolution with both ends against it at full rate."""
        peak_rad_s = self._peak_rad_s(np.array([np.pi]))
        against_s = 2.0 * self._gained_s(np.array([-np.inf]), peak_rad_s)
        return math.ceil(float(self.seconds[-1] + against_s[0]) / TICK_S)

    def ticks(self, begin: MovingEnds, end: MovingEnds) -> NDArray[np.int64]:
        """Whole 0.2 s ticks from each of n ends to its counterpart (or all from one)."""
        x, y = begin.q_body_from_eci_xyzw.T, end.q_body_from_eci_xyzw.T
        cosine = np.sum(x * y, axis=0)
        sine = np.stack(
            [
                y[3] * x[0] - x[3] * y[0] - y[1] * x[2] + y[2] * x[1],
                y[3] * x[1] - x[3] * y[1] - y[2] * x[0] + y[0] * x[2],
                y[3] * x[2] - x[3] * y[2] - y[0] * x[1] + y[1] * x[0],
            ],
            axis=-1,
        )
        size = np.linalg.norm(sine, axis=-1)
        axis_eci = sine * (np.where(cosine < 0.0, -1.0, 1.0) / np.maximum(size, 1e-12))[:, None]
        angle_rad = 2.0 * np.arctan2(size, np.abs(cosine))
        peak_rad_s = self._peak_rad_s(angle_rad)
        seconds = np.interp(angle_rad, self.angles_rad, self.seconds)
        for moving in (begin, end):
            along_rad_s = np.sum(axis_eci * moving.rate_eci_rad_s, axis=-1)
            seconds += self._gained_s(along_rad_s, peak_rad_s)
        return np.asarray(np.ceil(seconds / TICK_S - 1e-6), dtype=np.int64)

    def _peak_rad_s(self, angle_rad: Array) -> Array:
        """Of a trapezoid from rest to rest."""
        root = np.sqrt(self.acceleration_rad_s2 * np.maximum(angle_rad, 1e-6))
        return np.asarray(np.minimum(self.rate_rad_s, root))

    def _gained_s(self, along_rad_s: Array, peak_rad_s: Array) -> Array:
        """What an end's rate along the slew adds to a trapezoid: -w/a + w^2/(2 a peak)."""
        w = np.clip(along_rad_s, -peak_rad_s, peak_rad_s)
        return np.asarray((w * w / (2.0 * peak_rad_s) - w) / self.acceleration_rad_s2)


def slew_time(platform: BodyPlatform) -> SlewTime:
    """The table for a body's limits."""
    angles_rad = np.deg2rad(ANGLES_DEG)
    rate, acceleration, jerk = agility_limits(platform).by_order.min(axis=0).tolist()
    durations_s = np.array(
        [quickest_angle(angle, rate, acceleration, jerk).x[-1] for angle in angles_rad.tolist()]
    )
    extra_s = OPTIONS.allowance_s + platform.envelope.settle_s
    return SlewTime(
        angles_rad=angles_rad,
        seconds=OPTIONS.smooth * durations_s + extra_s,
        rate_rad_s=rate,
        acceleration_rad_s2=acceleration,
    )
