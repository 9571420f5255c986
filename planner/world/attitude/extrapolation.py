"""The ways in which an attitude to the local vertical may go on after the end of its history.

A vehicle in torque equilibrium swings about its mean attitude with the orbit and its
harmonics; one that has just manoeuvred holds its attitude or its rate for a while.
"""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.world.attitude.manoeuvre import OPTIONS as MANOEUVRE_OPTIONS

TAIL_S = 60.0  # the present attitude and rate are those of this much of the history
OFFSET_TAIL_S = 120.0
RATE_TAIL_S = (
    MANOEUVRE_OPTIONS.step_s
)  # and how the rate changes; 180 to 600 s do alike in a manoeuvre
_LEAST_ROWS = 3


@dataclass(frozen=True)
class Description:
    """What is fitted: `terms` orbital harmonics over the last `orbits`, or none of them.

    Without harmonics: a constant attitude, or a rate relative to LVLH (`has_rate`) that is constant
    or, about an axis where it slows down now, comes to rest.
    """

    terms: int = 0
    orbits: float = 0.0
    has_rate: bool = False

    def __str__(self) -> str:
        if self.terms:
            plural = "" if self.orbits == 1.0 else "s"
            return f"harmonics to order {self.terms} fitted over {self.orbits:g} orbit{plural}"
        return "present rate relative to LVLH" if self.has_rate else "constant LVLH attitude"

    @property
    def growth(self) -> float:
        """The power of the lead with which its error is taken to grow beyond what could be tried.

        A rate that changes steadily errs by the square; an attitude held stays within the swing.
        """
        return 2.0 if self.has_rate else 1.5


DESCRIPTIONS = (
    Description(),
    Description(has_rate=True),
    Description(terms=1, orbits=0.5),
    Description(terms=1, orbits=1.0),
    Description(terms=1, orbits=2.0),
    Description(terms=3, orbits=2.0),
)


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """A description fitted; its clock is that of the history, `end_s` its last instant.

    q_reference: body from LVLH.  coefficients_rad: shape (columns, 3), of the rotation vector
    that carries q_reference on.
    """

    description: Description
    period_s: float
    end_s: float
    q_reference: Rotation
    coefficients_rad: Array

    def at(self, t_s: Array) -> Rotation:
        """Body from LVLH at n instants."""
        since_end_s = t_s - self.end_s
        if self.description.has_rate:
            offset_rad, rate_rad_s, change_rad_s2 = self.coefficients_rad
            turn_rad = offset_rad + _turn_rad(rate_rad_s, change_rad_s2, since_end_s[:, None])
        else:
            turn_rad = _basis(self.description, self.period_s, since_end_s) @ self.coefficients_rad
        return Rotation.from_rotvec(turn_rad) * self.q_reference


def fit_extrapolation(
    description: Description, t_s: Array, q_body_from_lvlh: Rotation, period_s: float
) -> Extrapolation | None:
    """The description fitted to a history, or None where that is too short for it."""
    window_s = description.orbits * period_s
    if not description.terms:
        window_s = RATE_TAIL_S if description.has_rate else TAIL_S
    if not len(t_s) or t_s[-1] - t_s[0] < 0.95 * window_s:
        return None
    since_end_s = t_s - t_s[-1]
    used = since_end_s >= -window_s
    used[-_LEAST_ROWS:] = True
    q_reference = q_body_from_lvlh[-1]
    turn_rad = (q_body_from_lvlh[used] * q_reference.inv()).as_rotvec()
    basis = _basis(description, period_s, since_end_s[used])
    coefficients_rad: Array = np.asarray(
        np.linalg.lstsq(basis, turn_rad, rcond=None)[0], dtype=np.float64
    )
    if description.terms:
        left_rad = turn_rad - basis @ coefficients_rad
        recent = since_end_s[used] >= -OFFSET_TAIL_S
        coefficients_rad[0] += np.median(left_rad[recent], axis=0)
    if description.has_rate:
        recent = since_end_s[used] >= -TAIL_S
        recent[-_LEAST_ROWS:] = True
        bent_rad = basis[recent, 2:] @ coefficients_rad[2:]
        line = np.linalg.lstsq(basis[recent, :2], turn_rad[recent] - bent_rad, rcond=None)[0]
        coefficients_rad[:2] = line
    return Extrapolation(description, period_s, float(t_s[-1]), q_reference, coefficients_rad)


def _basis(description: Description, period_s: float, since_end_s: Array) -> Array:
    """Columns of the linear model, shape (n, columns); the first is constant."""
    columns = [np.ones_like(since_end_s)]
    if description.has_rate:
        columns += [since_end_s, 0.5 * since_end_s**2]
    for term in range(1, description.terms + 1):
        phase_rad = 2.0 * np.pi * term / period_s * since_end_s
        columns += [np.cos(phase_rad), np.sin(phase_rad)]
    return np.stack(columns, axis=1)


def _turn_rad(rate_rad_s: Array, change_rad_s2: Array, since_end_s: Array) -> Array:
    """Extrapolate by a present rate, shape (n, 3); since_end_s (n, 1).

    One that slows down goes on as the square of the time left until it is at rest, which begins
    with the present change and ends without a step of acceleration; any other stays.
    """
    slows = rate_rad_s * change_rad_s2 < 0.0
    rest_s = np.where(slows, -2.0 * rate_rad_s / np.where(slows, change_rad_s2, 1.0), 1.0)
    left = np.maximum(1.0 - since_end_s / rest_s, 0.0)
    return np.asarray(rate_rad_s * np.where(slows, rest_s / 3.0 * (1.0 - left**3), since_end_s))
