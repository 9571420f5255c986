"""The ways in which an attitude to the local vertical may go on after the end of its history.

A vehicle in torque equilibrium swings about its mean attitude with the orbit and its
harmonics; one that has just manoeuvred holds its attitude or its rate for a while.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array

TAIL_S = 60.0  # the present rate is fitted to this much of the history
OFFSET_TAIL_S = 120.0
# Of the rate after a manoeuvre: 600 to 1,800 s do about as well on the hours after one that
# bench/attitude.py says were tuned on.
DYING_S = 900.0
_LEAST_ROWS = 3


@dataclass(frozen=True)
class Description:
    """What is fitted: `terms` orbital harmonics over the last `orbits`, or none of them.

    Without harmonics: a rate relative to LVLH (`has_rate`), constant or dying away exponentially
    (`is_dying`), or a constant attitude.
    """

    terms: int = 0
    orbits: float = 0.0
    has_rate: bool = False
    is_dying: bool = False

    def __str__(self) -> str:
        if self.terms:
            plural = "" if self.orbits == 1.0 else "s"
            return f"harmonics to order {self.terms} fitted over {self.orbits:g} orbit{plural}"
        if self.is_dying:
            return f"rate relative to LVLH that dies away in {DYING_S / 60.0:.0f} min"
        return "constant rate relative to LVLH" if self.has_rate else "constant LVLH attitude"

    @property
    def growth(self) -> float:
        """By which power of the lead its error is taken to grow beyond what could be tried.

        A rate that changes steadily errs by the square; an attitude held stays within the swing.
        """
        return 2.0 if self.has_rate and not self.is_dying else 1.5


DESCRIPTIONS = (
    Description(),
    Description(has_rate=True),
    Description(has_rate=True, is_dying=True),
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
        basis = _basis(self.description, self.period_s, t_s - self.end_s)
        return Rotation.from_rotvec(basis @ self.coefficients_rad) * self.q_reference


def fit_extrapolation(
    description: Description, t_s: Array, q_body_from_lvlh: Rotation, period_s: float
) -> Extrapolation | None:
    """The description fitted to a history, or None where that is too short for it."""
    window_s = description.orbits * period_s if description.terms else TAIL_S
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
    return Extrapolation(description, period_s, float(t_s[-1]), q_reference, coefficients_rad)


def _basis(description: Description, period_s: float, since_end_s: Array) -> Array:
    """Columns of the linear model, shape (n, columns); the first is constant."""
    columns = [np.ones_like(since_end_s)]
    if description.has_rate:
        columns.append(
            DYING_S * -np.expm1(-since_end_s / DYING_S) if description.is_dying else since_end_s
        )
    for term in range(1, description.terms + 1):
        phase_rad = 2.0 * np.pi * term / period_s * since_end_s
        columns += [np.cos(phase_rad), np.sin(phase_rad)]
    return np.stack(columns, axis=1)
