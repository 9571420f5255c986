"""What does it cost a slew to leave a structure at rest?

A mode deflected by an axis's acceleration a follows x'' + 2 z w x' + w^2 x = -a.  What is left
of it after the slew, beside its deflection under the track's own acceleration, is the integral
of jerk(t) exp(lambda (T - t)), lambda the mode's eigenvalue: linear in the coefficients of a
spline, so its square is a quadratic cost that vanishing vibration makes zero.
"""

import math

import numpy as np
from numpy.typing import NDArray

from planner.platforms import StructuralMode

Array = NDArray[np.float64]
# The squared jerk of a move is 1/2; of the cubic's vibration these shares would cost as much.
WEIGHTS = ((0.96, 1e4), (1.0, 1e5), (1.04, 1e4))  # detuned by so much, with such weight
CUBIC_RESIDUAL = 6.0 * math.sqrt(2.0)  # of a unit move in unit time: its two steps of acceleration
GAUSS_PHASE_MAX_RAD = 12.0  # over one span: twenty points are exact to rounding
_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(20)


def modal_cost(
    spans: Array,
    pieces: Array,
    living: NDArray[np.intp],
    duration_s: float,
    modes: tuple[StructuralMode, ...],
) -> Array:
    """Matrix (n, n) of the modes' cost c^T P c / 2 of n spline coefficients.

    spans: breakpoints in normalised time.  pieces: (len(spans) - 1, degree + 1, degree + 1),
    power coefficients from the spline coefficients that live on a span, numbered by living
    (len(spans) - 1, degree + 1).  Each mode is weighted at its frequency and 4 % beside it, in
    units of what the paper's cubic would leave.
    Source: Singer, Seering 1990, residual vibration as a constraint on the command; here soft.
    """
    n = int(living.max()) + 1
    cost = np.zeros((n, n))
    for mode in modes:
        for detuned, weight in WEIGHTS:
            left = _residual(spans, pieces, living, duration_s * detuned * mode.eigenvalue_rad_s)
            left /= CUBIC_RESIDUAL
            cost += weight * (np.outer(left.real, left.real) + np.outer(left.imag, left.imag))
    return cost


def _residual(
    spans: Array, pieces: Array, living: NDArray[np.intp], eigenvalue: complex
) -> NDArray[np.complex128]:
    """Integral over [0, 1] of each spline's third derivative times exp(eigenvalue (1 - tau))."""
    width = np.diff(spans)
    powers = np.arange(3, pieces.shape[1])
    third = pieces[:, 3:] * (powers * (powers - 1) * (powers - 2))[:, None]
    moments = np.stack([_moments(eigenvalue * h, len(powers)) for h in width])
    moments *= width[:, None] ** np.arange(1, len(powers) + 1)
    moments *= np.exp(eigenvalue * (1.0 - spans[:-1]))[:, None]
    residual = np.zeros(int(living.max()) + 1, dtype=complex)
    np.add.at(residual, living, np.einsum("kj,kjn->kn", moments, third))
    return residual


def _moments(phase: complex, count: int) -> NDArray[np.complex128]:
    """Integrals over [0, 1] of s^j exp(-phase s), j < count."""
    if abs(phase) < GAUSS_PHASE_MAX_RAD:
        s = (_NODES + 1.0) / 2.0
        wave = _GAUSS_WEIGHTS / 2.0 * np.exp(-phase * s)
        return np.array([wave @ s**power for power in range(count)])
    found = [(1.0 - np.exp(-phase)) / phase]
    for power in range(1, count):
        found.append((power * found[-1] - np.exp(-phase)) / phase)
    return np.array(found)
