"""Corrections of an attitude law from measured small rotations, then and at other times.

The error is taken as a lasting turn, a swing at the orbital rate and a rest, each about every
body axis and of the size the law itself states: the measurements condition these.  A Gaussian
process: the swing's amplitude and phase follow from it, and are forgotten over days as the orbital
period is not known better; the rest is within minutes.
Source: Rasmussen and Williams 2006, eq. 2.23-2.24.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import Field

from planner.base.arrays import Array
from planner.base.correction import CorrectionOut
from planner.base.errors import InvalidInput
from planner.base.spec import Within, spec
from planner.world.attitude.errors import AttitudeErrors, alike
from planner.world.frames.time_scales import Instants, elapsed_s, tai_us, utc_text


@dataclass(frozen=True, kw_only=True)
class CorrectionOptions:
    """How measured corrections of an attitude are carried to other times."""

    corrections_max: int = 100  # in one request
    period_sigma: float = 0.003  # of the orbital period: the ISS's is 5,545 to 5,577 s
    # from the law and the corrections before: farther off it is refused
    contradicts_sigma: float = 5.0
    modes: int = 6  # of what stays uncertain, the largest; the others' size is laid on them
    at_a_time: int = 4096  # instants, for the memory they take
    variance_max_deg2: float = 1e5  # of a direction that wasn't measured
    rounding: float = 1e-14  # of all variances together: what sums of so many are good to


OPTIONS = CorrectionOptions()

_TINY = np.finfo(float).tiny

_TurnDeg = Annotated[float, Within(-20.0, 20.0)]
_VarianceDeg2 = Annotated[float, Within(-OPTIONS.variance_max_deg2, OPTIONS.variance_max_deg2)]
_Row = tuple[_VarianceDeg2, _VarianceDeg2, _VarianceDeg2]


@spec
class AttitudeCorrection:
    """A measured difference of the body's attitude from the law's, the law without corrections.

    q_body_from_eci is Rotation.from_rotvec(turn) * the law's.

    epoch: time of the measurement; UTC. E.g. `"2015-02-27T17:28:20Z"`.
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

    @property
    def told(self) -> CorrectionOut:
        return CorrectionOut(
            epoch=utc_text(self.epoch, 6),
            turn_body_deg=list(self.turn_body_deg),
            covariance_deg2=[list(row) for row in self.covariance_deg2],
        )


Corrections = Annotated[tuple[AttitudeCorrection, ...], Field(max_length=OPTIONS.corrections_max)]


@dataclass(frozen=True, eq=False)
class Correction:
    """The law's error as measured: its mean and what is left open of it.

    stated: the law's own errors at any instants.  period_s: of the swing.
    """

    measured: tuple[AttitudeCorrection, ...]
    stated: Callable[[Instants], AttitudeErrors]
    period_s: float

    @cached_property
    def _known(self) -> "_Measurements":
        return _Measurements(self)

    def turn_rad(self, instants: Instants) -> Array:
        """Expected rotation vectors from the law's body to the true one, (n, 3)."""
        return np.concatenate([self._known.expected_rad(part) for part in _parts(instants)])

    def errors(self, instants: Instants) -> AttitudeErrors:
        """What the law's errors are then, given the measurements; for a session's few instants."""
        known, then = self._known, _Stated(self.stated(instants), instants)
        count = len(instants)
        across = known.covariance_with(then)
        left = _join_axes(then.covariance_with(then, self.period_s))
        left -= across @ np.linalg.solve(known.covariance_rad2, across.T)
        size, mode = np.linalg.eigh(left)
        kept = slice(-OPTIONS.modes, None)
        lost = np.trace(left) / max(float(np.sum(size[kept])), _TINY)
        modes_rad = (mode[:, kept] * np.sqrt(np.maximum(size[kept], 0.0) * lost)).T
        return self._as_errors(then.errors, modes_rad.reshape(-1, count, 3))

    def errors_each(self, instants: Instants) -> AttitudeErrors:
        """Errors of each instant by itself, however many: three modes, an instant's own."""
        left = np.concatenate([self._known.left_each(part) for part in _parts(instants)])
        size, mode = np.linalg.eigh(left)
        modes_rad = mode * np.sqrt(np.maximum(size, 0.0))[:, None, :]
        return self._as_errors(self.stated(instants), modes_rad.transpose(2, 0, 1))

    def _as_errors(self, stated: AttitudeErrors, modes_body_rad: Array) -> AttitudeErrors:
        last = utc_text(max((one.epoch for one in self.measured), key=tai_us))
        return AttitudeErrors(
            np.zeros(3),
            np.zeros(3),
            f"{stated.basis}; corrected by {_count_text(self.measured)}, the last of {last}",
            "a correction nearer to the session",
            np.zeros(3),
            modes_body_rad=modes_body_rad,
        )

    def warning(self, instants: Instants) -> str:
        """The note by how much the attitude is corrected."""
        turn_deg = np.rad2deg(np.linalg.norm(self.turn_rad(instants), axis=1).max())
        return (
            f"the attitude follows {_count_text(self.measured)}: it is turned by up to "
            f"{turn_deg:.3f} deg from its law"
        )


class _Stated:
    """A law's own errors at n instants, before anything was measured."""

    def __init__(self, errors: AttitudeErrors, instants: Instants) -> None:
        self.errors, self.instants = errors, instants
        shape = len(instants), 3
        self._sigma_rad = np.broadcast_to(errors.sigma_body_rad, shape)
        self._forgotten_rad = np.broadcast_to(errors.forgotten_body_rad, shape)
        lasting_rad2 = self._sigma_rad**2 - self._forgotten_rad**2
        self._lasting_rad = np.sqrt(np.maximum(lasting_rad2, 0.0))

    @property
    def variance_rad2(self) -> Array:
        """About each axis, (n, 3)."""
        return np.asarray(self._sigma_rad**2 + self.errors.swing_rms_body_rad**2)

    def covariance_with(self, other: "_Stated", period_s: float) -> Array:
        """Covariance with the error at k other instants, about each axis: (3, n, k)."""
        t_s = self.instants.since_s(other.instants.epoch_utc)
        apart_s = t_s[:, None] - other.instants.t_s
        phase_rad = 2.0 * np.pi / period_s * apart_s
        swing = np.cos(phase_rad) * np.exp(-0.5 * (OPTIONS.period_sigma * phase_rad) ** 2)
        swing_rad2 = np.multiply.outer(self.errors.swing_rms_body_rad**2, swing)
        forgotten_rad2 = np.einsum("na,ka->ank", self._forgotten_rad, other._forgotten_rad)
        forgotten_rad2 *= alike(apart_s, self.errors.memory_s)
        lasting_rad2 = np.einsum("pna,pka->ank", self._lasting_parts_rad, other._lasting_parts_rad)
        return np.asarray(swing_rad2 + forgotten_rad2 + lasting_rad2)

    @cached_property
    def _lasting_parts_rad(self) -> Array:
        """What lasts, each part times a number of its own, (p, n, 3)."""
        if not len(self.errors.parts_body_rad):
            return self._lasting_rad[None]
        share = self._lasting_rad / np.maximum(self._sigma_rad, _TINY)
        return np.asarray(self.errors.parts_body_rad * share)


class _Measurements:
    """The measurements against the law's own errors; raises InvalidInput where they contradict.

    Members of 3 k rows hold the three axes of each of k measurements, in their order.
    """

    def __init__(self, correction: Correction) -> None:
        order = sorted(correction.measured, key=lambda one: tai_us(one.epoch))
        epoch_utc = order[0].epoch
        instants = Instants(epoch_utc, np.array([elapsed_s(one.epoch, epoch_utc) for one in order]))
        _refuse_repeated(order)
        self._stated_at, self._period_s = correction.stated, correction.period_s
        self._stated = _Stated(self._stated_at(instants), instants)
        self.covariance_rad2 = self.covariance_with(self._stated)
        for k, one in enumerate(order):
            mine = slice(3 * k, 3 * k + 3)
            self.covariance_rad2[mine, mine] += np.deg2rad(np.deg2rad(one.covariance_deg2))
        rounded_rad2 = OPTIONS.rounding * float(np.sum(self._stated.variance_rad2))
        self.covariance_rad2 += rounded_rad2 * np.eye(len(self.covariance_rad2))
        turn_rad = np.deg2rad([one.turn_body_deg for one in order]).ravel()
        self._refuse_contradiction(order, turn_rad)
        self._weights = np.linalg.solve(self.covariance_rad2, turn_rad)

    def covariance_with(self, stated: _Stated) -> Array:
        """Covariance of the error then with that at the measurements, (3 n, 3 k)."""
        return _join_axes(stated.covariance_with(self._stated, self._period_s))

    def expected_rad(self, instants: Instants) -> Array:
        """The error expected at n instants, (n, 3)."""
        across = self._errors_then(instants).covariance_with(self._stated, self._period_s)
        return np.asarray(np.einsum("ank,ka->na", across, self._weights.reshape(-1, 3)))

    def left_each(self, instants: Instants) -> Array:
        """Covariance (rad2) of the error at n instants given the measurements, (n, 3, 3)."""
        stated = self._errors_then(instants)
        across = self.covariance_with(stated)
        known = np.linalg.solve(self.covariance_rad2, across.T).T
        said = np.einsum(
            "nak,nbk->nab", *(m.reshape(len(instants), 3, -1) for m in (across, known))
        )
        return np.asarray(stated.variance_rad2[:, :, None] * np.eye(3) - said)

    def _errors_then(self, instants: Instants) -> _Stated:
        return _Stated(self._stated_at(instants), instants)

    def _refuse_contradiction(self, order: list[AttitudeCorrection], turn_rad: Array) -> None:
        """Each against the law and all that came before it."""
        root = np.linalg.cholesky(self.covariance_rad2)
        # Three by three they are what each adds, divided by its spread given those before it.
        news = np.linalg.solve(root, turn_rad)
        for k, one in enumerate(order):
            mine = slice(3 * k, 3 * k + 3)
            sigmas = float(np.linalg.norm(news[mine]))
            if sigmas > OPTIONS.contradicts_sigma:
                apart_deg = np.rad2deg(np.linalg.norm(root[mine, mine] @ news[mine]))
                against = "the law" if k == 0 else "the law as corrected before"
                raise InvalidInput(
                    f"the attitude measured at {utc_text(one.epoch)} lies {apart_deg:.3f} deg or "
                    f"{sigmas:.1f} sigma from {against}; a correction is believed up to "
                    f"{OPTIONS.contradicts_sigma:g} sigma: state the mean attitude as it is, or "
                    "how far the carrier may be off it (attitude.uncertainty), or leave the "
                    "correction out",
                    field="attitude.corrections",
                    at_utc=one.epoch,
                )


def _refuse_repeated(order: list[AttitudeCorrection]) -> None:
    """One measurement sent twice would count as two."""
    for number, one in enumerate(order):
        if one in order[:number]:
            raise InvalidInput(
                f"the correction of {utc_text(one.epoch)} is given twice; send each measurement "
                "once (two that agree to the last digit are one)",
                field="attitude.corrections",
                at_utc=one.epoch,
            )


def _join_axes(covariance_rad2: Array) -> Array:
    """The axes of each instant together: (3, n, k) as (3 n, 3 k)."""
    axes, count, others = covariance_rad2.shape
    joint = np.zeros((axes * count, axes * others))
    for axis, own in enumerate(covariance_rad2):
        joint[axis::axes, axis::axes] = own
    return joint


def _parts(instants: Instants) -> Iterator[Instants]:
    """Slices of at most _AT_A_TIME instants each."""
    for first in range(0, len(instants), OPTIONS.at_a_time):
        yield Instants(instants.epoch_utc, instants.t_s[first : first + OPTIONS.at_a_time])


def _count_text(measured: tuple[AttitudeCorrection, ...]) -> str:
    return f"{len(measured)} correction{'' if len(measured) == 1 else 's'}"
