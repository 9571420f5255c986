"""Estimates of a slew's duration, good enough to choose by.

Least time about the hardest axis for the angle, from rest to rest; what ends that move with
the slew save and ends that move against it cost; an allowance for ends that move aside, the
guard tick after imaging and the settling time before it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.spacecraft.slews.eigenaxis import eigenaxis_slew
from planner.spacecraft.slews.slew_problem import AttitudeSlewProblem, EndState
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import AgileSpacecraft


@dataclass(frozen=True, kw_only=True)
class SlewTimeOptions:
    """What an estimate adds to the eigenaxis slew from rest to rest."""

    smooth: float = 1.03  # what a spline without corners in its torque rate takes
    allowance_s: float = 0.8  # for rates of 0.4 deg/s aside at 1 deg/s^2, both ends
    least_rad_s: float = 1e-4  # of a slew whose gyros are full: an hour for 20 deg


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
    def of(cls, end: EndState) -> "MovingEnds":
        """One, n = 1."""
        rate_eci_rad_s = end.q_body_from_eci.inv().apply(end.omega_body_rad_s)
        return cls(
            q_body_from_eci_xyzw=end.q_body_from_eci.as_quat()[None],
            rate_eci_rad_s=rate_eci_rad_s[None],
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
    included.  rate, acceleration, inertia: about that axis.  momentum_eci_n_m_s: of body and gyros,
    (3,), which keeps the gyros within their sphere at a lower rate only.
    """

    angles_rad: Array
    seconds: Array
    rate_rad_s: float
    acceleration_rad_s2: float
    inertia_kg_m2: float
    momentum_eci_n_m_s: Array
    sphere_n_m_s: float

    def plus(self, more_s: float) -> "SlewTime":
        """Add so much time to every slew."""
        return replace(self, seconds=self.seconds + more_s)

    @property
    def widest_ticks(self) -> int:
        """The most any slew takes: half a revolution with both ends against it at full rate."""
        half_rad, worst_eci = np.array([np.pi]), -self.momentum_eci_n_m_s[None]
        worst_eci /= max(float(np.linalg.norm(worst_eci)), 1e-12)
        peak_rad_s = self._peak_rad_s(worst_eci, half_rad)
        longest_s = float(self.seconds[-1]) + self._slower_s(peak_rad_s, half_rad)
        against_s = 2.0 * self._gained_s(np.array([-np.inf]), peak_rad_s)
        return math.ceil(float((longest_s + against_s)[0]) / TICK_S)

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
        peak_rad_s = self._peak_rad_s(axis_eci, angle_rad)
        seconds = np.interp(angle_rad, self.angles_rad, self.seconds)
        seconds += self._slower_s(peak_rad_s, angle_rad)
        for moving in (begin, end):
            along_rad_s = np.sum(axis_eci * moving.rate_eci_rad_s, axis=-1)
            seconds += self._gained_s(along_rad_s, peak_rad_s)
        return np.asarray(np.ceil(seconds / TICK_S - 1e-6), dtype=np.int64)

    def _free_peak_rad_s(self, angle_rad: Array) -> Array:
        """The time of a trapezoid from rest to rest, whatever the gyros hold."""
        root = np.sqrt(self.acceleration_rad_s2 * np.maximum(angle_rad, 1e-6))
        return np.asarray(np.minimum(self.rate_rad_s, root))

    def _peak_rad_s(self, axis_eci: Array, angle_rad: Array) -> Array:
        """The same with |H - J w axis| in the sphere, as if J were the same about every axis."""
        h_n_m_s = axis_eci @ self.momentum_eci_n_m_s
        room = self.sphere_n_m_s**2 - np.sum(self.momentum_eci_n_m_s**2)
        most_rad_s = (h_n_m_s + np.sqrt(np.maximum(h_n_m_s**2 + room, 0.0))) / self.inertia_kg_m2
        return np.minimum(
            self._free_peak_rad_s(angle_rad), np.maximum(most_rad_s, OPTIONS.least_rad_s)
        )

    def _slower_s(self, peak_rad_s: Array, angle_rad: Array) -> Array:
        """What a lower peak adds to a trapezoid of angle/peak + peak/a seconds."""
        free = self._free_peak_rad_s(angle_rad)
        longer_s = angle_rad / peak_rad_s - angle_rad / free
        return np.asarray(longer_s + (peak_rad_s - free) / self.acceleration_rad_s2)

    def _gained_s(self, along_rad_s: Array, peak_rad_s: Array) -> Array:
        """What an end's rate along the slew adds to a trapezoid: -w/a + w^2/(2 a peak)."""
        w = np.clip(along_rad_s, -peak_rad_s, peak_rad_s)
        return np.asarray((w * w / (2.0 * peak_rad_s) - w) / self.acceleration_rad_s2)


def slew_time(spacecraft: AgileSpacecraft, momentum_eci_n_m_s: Array) -> SlewTime:
    """The table for a spacecraft's limits, and what body and gyros hold, (3,)."""
    angles_rad = np.deg2rad(ANGLES_DEG)
    axis_body = np.eye(3)[int(np.argmax(spacecraft.inertia_kg_m2))]
    problems = [
        AttitudeSlewProblem(
            start=EndState.at_rest(Rotation.identity()),
            end=EndState.at_rest(Rotation.from_rotvec(-angle_rad * axis_body)),
            momentum_eci_n_m_s=np.zeros(3),
            inertia_kg_m2=np.array(spacecraft.inertia_kg_m2),
            limits=spacecraft.slew,
        )
        for angle_rad in angles_rad
    ]
    durations_s = np.array([eigenaxis_slew(problem).duration_s for problem in problems])
    extra_s = OPTIONS.allowance_s + TICK_S + spacecraft.slew.settle_s
    return SlewTime(
        angles_rad=angles_rad,
        seconds=OPTIONS.smooth * durations_s + extra_s,
        rate_rad_s=min(spacecraft.slew.rate_axis_rad_s, spacecraft.slew.rate_rad_s),
        acceleration_rad_s2=spacecraft.slew.torque_n_m / max(spacecraft.inertia_kg_m2),
        inertia_kg_m2=max(spacecraft.inertia_kg_m2),
        momentum_eci_n_m_s=momentum_eci_n_m_s,
        sphere_n_m_s=spacecraft.slew.momentum_sphere_n_m_s,
    )
