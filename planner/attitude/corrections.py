"""What measured small rotations say of an attitude law's error, then and at other times.

The error is taken as a constant turn and a swing at the orbital rate, both about each body axis,
of the sizes the law itself tells: the measurements condition these.  A Gaussian process: the
swing's amplitude and phase follow from it, and are forgotten over several orbits.
Source: Rasmussen and Williams 2006, eq. 2.23-2.24.
"""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import Field

from planner.arrays import Array
from planner.attitude.errors import AttitudeErrors
from planner.errors import InvalidInput
from planner.frames.time_scales import Instants, elapsed_s, tai_us, utc_text
from planner.spec import Within, spec

CORRECTIONS_MAX = 100
# What is left of the ISS's motion beside mean and swing, about each axis (bench/truth.py).
REST_RAD = np.deg2rad(0.01)
# After an orbit a swing foretold on ISS telemetry is off by a tenth of itself (bench/attitude.py).
FORGOTTEN_S = 40_000.0
CONTRADICTS_SIGMA = 5.0
_MODES = 6
_AT_A_TIME = 4096  # instants, for the memory they take
_VARIANCE_MAX_DEG2 = 1e5  # of a direction that wasn't measured

_TurnDeg = Annotated[float, Within(-20.0, 20.0)]
_VarianceDeg2 = Annotated[float, Within(-_VARIANCE_MAX_DEG2, _VARIANCE_MAX_DEG2)]
_Row = tuple[_VarianceDeg2, _VarianceDeg2, _VarianceDeg2]


@spec
class AttitudeCorrection:
    """A measured difference of the body's attitude from the law's, the law without corrections.

    q_body_from_eci is Rotation.from_rotvec(turn) * the law's.

    epoch: when it was measured; UTC. E.g. `"2015-02-27T17:28:20Z"`.
    turn_body_deg: rotation vector in body axes that carries the law's body onto the true one. E.g.
    `[0.25, 0.05, 0.0]`.
    covariance_deg2: of its components, symmetric; 32,400 along a direction that was not measured,
    as the vertical of a horizon. E.g. `[[4e-4, 0.0, 0.0], [0.0, 4e-4, 0.0], [0.0, 0.0, 32400.0]]`.
    """

    epoch: datetime
    turn_body_deg: tuple[_TurnDeg, _TurnDeg, _TurnDeg]
    covariance_deg2: tuple[_Row, _Row, _Row]

    def __post_init__(self) -> None:
        covariance = np.array(self.covariance_deg2)
        if not np.allclose(covariance, covariance.T, rtol=1e-6, atol=1e-12):
            raise ValueError("covariance_deg2 must be symmetric")
        least = float(np.linalg.eigvalsh(covariance)[0])
        if not least > 0.0:
            raise ValueError(
                "covariance_deg2 must be positive definite: its least eigenvalue is "
                f"{least:.3g} deg2; no measurement is exact"
            )


Corrections = Annotated[tuple[AttitudeCorrection, ...], Field(max_length=CORRECTIONS_MAX)]


@dataclass(frozen=True, eq=False)
class Correction:
    """The law's error as measured: its mean and what is left open of it.

    told: the law's own errors at any instants.  period_s: of the swing.
    """

    measured: tuple[AttitudeCorrection, ...]
    told: Callable[[Instants], AttitudeErrors]
    period_s: float

    @cached_property
    def _known(self) -> "_Measurements":
        return _Measurements(self)

    def turn_rad(self, instants: Instants) -> Array:
        """Expected rotation vectors from the law's body to the true one, (n, 3)."""
        t_s = instants.since_s(self._known.instants.epoch_utc)
        parts = np.array_split(t_s, len(t_s) // _AT_A_TIME + 1)
        return np.concatenate([self._known.expected_rad(part_s) for part_s in parts])

    def errors(self, instants: Instants) -> AttitudeErrors:
        """What the law's errors are then, given the measurements; for a session's few instants."""
        known, told = self._known, self.told(instants)
        count = len(instants)
        across = known.to(instants)
        left = known.prior(instants) - across @ np.linalg.solve(known.covariance_rad2, across.T)
        grown_rad = known.grown_rad(told, count)
        for axis in range(3):
            left[axis::3, axis::3] += np.outer(grown_rad[:, axis], grown_rad[:, axis])
        size, mode = np.linalg.eigh(left)
        kept = slice(-_MODES, None)
        lost = np.trace(left) / max(float(np.sum(size[kept])), np.finfo(float).tiny)
        modes_rad = (mode[:, kept] * np.sqrt(np.maximum(size[kept], 0.0) * lost)).T
        return self._as_errors(told, modes_rad.reshape(-1, count, 3))

    def errors_each(self, instants: Instants) -> AttitudeErrors:
        """The same of each instant by itself, however many: three modes, an instant's own."""
        known, told = self._known, self.told(instants)
        t_s = instants.since_s(known.instants.epoch_utc)
        grown_rad = known.grown_rad(told, len(t_s))
        parts = np.array_split(np.arange(len(t_s)), len(t_s) // _AT_A_TIME + 1)
        left = np.concatenate([known.left_each(t_s[part]) for part in parts])
        left += grown_rad[:, :, None] ** 2 * np.eye(3)
        size, mode = np.linalg.eigh(left)
        modes_rad = mode * np.sqrt(np.maximum(size, 0.0))[:, None, :]
        return self._as_errors(told, modes_rad.transpose(2, 0, 1))

    def _as_errors(self, told: AttitudeErrors, modes_body_rad: Array) -> AttitudeErrors:
        last = utc_text(max((one.epoch for one in self.measured), key=tai_us))
        return AttitudeErrors(
            np.zeros(3),
            np.zeros(3),
            f"{told.basis}; corrected by {_number(self.measured)}, the last of {last}",
            "a correction nearer to the session",
            modes_body_rad,
        )

    def warning(self, instants: Instants) -> str:
        """By how much the attitude is corrected."""
        turn_deg = np.rad2deg(np.linalg.norm(self.turn_rad(instants), axis=1).max())
        return (
            f"the attitude follows {_number(self.measured)}: it is turned by up to "
            f"{turn_deg:.3f} deg from its law"
        )


class _Measurements:
    """The measurements against the law's own errors; raises InvalidInput where they contradict.

    Members of 3 k rows hold the three axes of each of k measurements, in their order.
    """

    def __init__(self, correction: Correction) -> None:
        measured = correction.measured
        epoch_utc = min((one.epoch for one in measured), key=tai_us)
        order = sorted(measured, key=lambda one: tai_us(one.epoch))
        t_s = np.array([elapsed_s(one.epoch, epoch_utc) for one in order])
        self.instants = Instants(epoch_utc, t_s)
        told = correction.told(self.instants)
        sigma_rad = np.broadcast_to(told.sigma_body_rad, (len(order), 3))
        self.bias_rad = sigma_rad.min(axis=0)
        self._swing_rad = told.swing_rms_body_rad
        self._rate_rad_s = 2.0 * np.pi / correction.period_s
        own = np.diag((sigma_rad**2 - self.bias_rad**2 + REST_RAD**2).ravel())
        for k, one in enumerate(order):
            own[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += np.deg2rad(np.deg2rad(one.covariance_deg2))
        self.covariance_rad2 = self.prior(self.instants) + own
        turn_rad = np.deg2rad([one.turn_body_deg for one in order]).ravel()
        self._refuse_contradiction(order, turn_rad)
        self.weights = np.linalg.solve(self.covariance_rad2, turn_rad)

    def expected_rad(self, t_s: Array) -> Array:
        """The error expected at n times of their clock, (n, 3)."""
        swing = self._swing_memory(t_s, self.instants.t_s)
        weights = self.weights.reshape(-1, 3)
        constant_rad = self.bias_rad**2 * weights.sum(axis=0)
        return np.asarray(constant_rad + self._swing_rad**2 * (swing @ weights))

    def to(self, instants: Instants) -> Array:
        """Covariance (rad2) of the error then with that at the measurements, (3 n, 3 k)."""
        return self._between(instants.since_s(self.instants.epoch_utc), self.instants.t_s)

    def prior(self, instants: Instants) -> Array:
        """Covariance (rad2) of constant turn and swing before anything was measured, (3 n, 3 n)."""
        return self._between(instants.t_s, instants.t_s)

    def left_each(self, t_s: Array) -> Array:
        """Covariance (rad2) of constant turn and swing at n times of their clock, (n, 3, 3)."""
        across = self._between(t_s, self.instants.t_s)
        known = np.linalg.solve(self.covariance_rad2, across.T).T
        said = np.einsum("nak,nbk->nab", *(m.reshape(len(t_s), 3, -1) for m in (across, known)))
        return np.asarray(np.diag(self.bias_rad**2 + self._swing_rad**2) - said)

    def grown_rad(self, told: AttitudeErrors, count: int) -> Array:
        """Beyond the constant turn at the measurements, and what is neither turn nor swing."""
        sigma_rad = np.broadcast_to(told.sigma_body_rad, (count, 3))
        return np.asarray(np.sqrt(np.maximum(sigma_rad**2 - self.bias_rad**2, 0.0) + REST_RAD**2))

    def _between(self, t_s: Array, other_s: Array) -> Array:
        swing = self._swing_memory(t_s, other_s)
        covariance_rad2 = np.zeros((3 * len(t_s), 3 * len(other_s)))
        for axis in range(3):
            bias, swing_rad = self.bias_rad[axis], self._swing_rad[axis]
            covariance_rad2[axis::3, axis::3] = bias**2 + swing_rad**2 * swing
        return covariance_rad2

    def _swing_memory(self, t_s: Array, other_s: Array) -> Array:
        apart_s = t_s[:, None] - other_s
        forgotten = np.exp(-0.5 * (apart_s / FORGOTTEN_S) ** 2)
        return np.asarray(np.cos(self._rate_rad_s * apart_s) * forgotten)

    def _refuse_contradiction(self, order: list[AttitudeCorrection], turn_rad: Array) -> None:
        """Each against the law and all that came before it."""
        root = np.linalg.cholesky(self.covariance_rad2)
        # Three by three they are what each adds, divided by its spread given those before it.
        news = np.linalg.solve(root, turn_rad)
        for k, one in enumerate(order):
            mine = slice(3 * k, 3 * k + 3)
            sigmas = float(np.linalg.norm(news[mine]))
            if sigmas > CONTRADICTS_SIGMA:
                apart_deg = np.rad2deg(np.linalg.norm(root[mine, mine] @ news[mine]))
                against = "the law" if k == 0 else "the law as corrected before"
                raise InvalidInput(
                    f"the attitude measured at {utc_text(one.epoch)} lies {apart_deg:.3f} deg or "
                    f"{sigmas:.1f} sigma from {against}; a correction is believed up to "
                    f"{CONTRADICTS_SIGMA:g} sigma: state the mean attitude as it is, or how far "
                    "the carrier may be off it (attitude.uncertainty), or leave the correction out",
                    field="attitude.corrections",
                    at_utc=one.epoch,
                )


def _number(measured: tuple[AttitudeCorrection, ...]) -> str:
    return f"{len(measured)} correction{'' if len(measured) == 1 else 's'}"
