"""The cost of a slew that leaves a structure vibrating, and how little of that is wanted.

A mode deflected by an axis's acceleration a follows x'' + 2 z w x' + w^2 x = -a.  What is left
of it after the slew, beside its deflection under the track's own acceleration, is the integral
of jerk(t) exp(lambda (T - t)), lambda the mode's eigenvalue: linear in the coefficients of a
spline, so its square is a quadratic cost that vanishing vibration makes zero.
"""

import math

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array
from planner.platforms import StructuralMode
from planner.slew.spline_basis import SplineBasis

DETUNED = (0.96, 1.0, 1.04)  # each mode is weighted at its frequency and 4 % beside it
# The squared jerk of a move is 1/2; of the cubic's vibration these shares would cost as much.
WEIGHTS = (1e4, 1e5, 1e4)
WANTED = (0.1, 0.01, 0.1)  # of what the cubic leaves
CUBIC_RESIDUAL = 6.0 * math.sqrt(2.0)  # of a unit move in unit time: its two steps of acceleration
GAUSS_PHASE_MAX_RAD = 12.0  # over one span: twenty points are exact to rounding
_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(20)


def modal_rows(
    basis: SplineBasis, duration_s: float, modes: tuple[StructuralMode, ...]
) -> NDArray[np.complex128]:
    """What a unit of each of n spline coefficients leaves of the detuned modes, (3 modes, n).

    In units of what the paper's cubic would leave of a unit move.
    """
    return _residuals(basis, np.array(_eigenvalues(duration_s, modes))) / CUBIC_RESIDUAL


def modal_cost(rows: NDArray[np.complex128], weight_factors: Array | None = None) -> Array:
    """Matrix (n, n) of the cost c^T P c / 2 of the rows' squares.

    weight_factors: (len(rows),), multiply their usual weights.
    Source: Singer, Seering 1990, residual vibration as a constraint on the command; here soft.
    """
    weights = np.resize(WEIGHTS, len(rows)) * (1.0 if weight_factors is None else weight_factors)
    return np.asarray(sum((part.T * weights) @ part for part in (rows.real, rows.imag)))


def wanted_residuals(
    ends_over_scale: Array, duration_s: float, modes: tuple[StructuralMode, ...]
) -> Array:
    """What may be left, in units of `modal_rows`: shares of what the cubic between the ends leaves.

    ends_over_scale: angle, rate, acceleration at the start, and the same backwards at the end,
    in normalised time.
    """
    angle, rate, acceleration, last_acceleration, last_rate, last_angle = ends_over_scale
    step = 6.0 * (last_angle - angle)
    begins = step - 4.0 * rate - 2.0 * last_rate
    stops = 2.0 * rate + 4.0 * last_rate - step
    left = [
        (begins - acceleration) * np.exp(eigenvalue)
        + (stops - begins) * np.expm1(eigenvalue) / eigenvalue
        + last_acceleration
        - stops
        for eigenvalue in _eigenvalues(duration_s, modes)
    ]
    return np.asarray(np.resize(WANTED, len(left)) * np.abs(left) / CUBIC_RESIDUAL)


def _eigenvalues(duration_s: float, modes: tuple[StructuralMode, ...]) -> list[complex]:
    """In normalised time."""
    return [duration_s * share * mode.eigenvalue_rad_s for mode in modes for share in DETUNED]


def _residuals(basis: SplineBasis, eigenvalues: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Integrals over [0, 1] of each spline's third derivative times exp(eigenvalue (1 - tau)).

    Shape (len(eigenvalues), n).
    """
    width, support = np.diff(basis.breakpoints_tau), basis.support
    powers = np.arange(3, basis.power_matrix.shape[1])
    third = basis.power_matrix[:, 3:] * (powers * (powers - 1) * (powers - 2))[:, None]
    moments = _moments(np.outer(eigenvalues, width), len(powers))
    moments *= width[:, None] ** np.arange(1, len(powers) + 1)
    moments *= np.exp(np.outer(eigenvalues, 1.0 - basis.breakpoints_tau[:-1]))[:, :, None]
    residuals = np.zeros((int(support.max()) + 1, len(eigenvalues)), dtype=complex)
    np.add.at(residuals, support, np.einsum("ekj,kjn->kne", moments, third))
    return residuals.T


def _moments(phase: NDArray[np.complex128], count: int) -> NDArray[np.complex128]:
    """Integrals over [0, 1] of s^j exp(-phase s), j < count, along a new last axis."""
    moments = np.empty((*phase.shape, count), dtype=complex)
    slow = np.abs(phase) < GAUSS_PHASE_MAX_RAD
    s = (_NODES + 1.0) / 2.0
    weights = _GAUSS_WEIGHTS[:, None] / 2.0 * s[:, None] ** np.arange(count)
    moments[slow] = np.exp(-np.multiply.outer(phase[slow], s)) @ weights
    fast = phase[~slow]
    end = np.exp(-fast)
    integral = (1.0 - end) / fast
    for power in range(count):
        moments[~slow, power] = integral
        integral = ((power + 1) * integral - end) / fast
    return moments
