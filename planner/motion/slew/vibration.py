"""The cost of a slew that leaves a structure vibrating, and how little of that is wanted.

A mode deflected by an axis's acceleration a follows x'' + 2 z w x' + w^2 x = -a.  What is left
of it after the slew, beside its deflection under the track's own acceleration, is the integral
of jerk(t) exp(lambda (T - t)), lambda the mode's eigenvalue: linear in the coefficients of a
spline, so its square is a quadratic cost that vanishing vibration makes zero.
"""

import math

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.world.platforms import StructuralMode

DETUNED = (0.96, 1.0, 1.04)  # each mode is weighted at its frequency and 4 % beside it
# The squared jerk of a move is 1/2; of the cubic's vibration these shares would cost as much.
WEIGHTS = (1e4, 1e5, 1e4)
WANTED = (0.1, 0.01, 0.1)  # of what the cubic leaves
CUBIC_RESIDUAL = 6.0 * math.sqrt(2.0)  # of a unit move in unit time: its two steps of acceleration
GAUSS_PHASE_MAX_RAD = 12.0  # over one span: twenty points are exact to rounding
JERK_COST = 720.0  # least integral of squared jerk of a unit rest-to-rest move in unit time
_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(20)


def residual_vibration_rows(
    knots_tau: Array, duration_s: float, modes: tuple[StructuralMode, ...]
) -> NDArray[np.complex128]:
    """What a unit of the jerk at both ends of n spans leaves of the detuned modes, (3 modes, n, 2).

    The jerk is linear on each span.  In units of what the paper's cubic leaves of a unit move.
    """
    residuals = span_residuals(knots_tau, duration_s, modes, 2)
    width = np.diff(knots_tau)
    late = residuals[:, :, 1] / width
    return np.stack([residuals[:, :, 0] - late, late], axis=2)


def span_residuals(
    knots_tau: Array, duration_s: float, modes: tuple[StructuralMode, ...], count: int
) -> NDArray[np.complex128]:
    """What each power of time since a span's begin leaves as jerk there, (3 modes, n, count)."""
    eigenvalues, width = np.array(_mode_eigenvalues(duration_s, modes)), np.diff(knots_tau)
    moments = _exponential_moments(np.outer(eigenvalues, width), count)
    moments *= width[:, None] ** np.arange(1, count + 1)
    moments *= np.exp(np.outer(eigenvalues, 1.0 - knots_tau[:-1]))[:, :, None]
    return moments / CUBIC_RESIDUAL


def wanted_residuals(
    ends_over_scale: Array, duration_s: float, modes: tuple[StructuralMode, ...]
) -> Array:
    """What may be left, in the same units: shares of what the cubic's move leaves.

    ends_over_scale (2, 3): angle, rate, acceleration at start and end, in normalised time.
    """
    (angle, rate, acceleration), (last_angle, last_rate, last_acceleration) = ends_over_scale
    step = 6.0 * (last_angle - angle)
    begins = step - 4.0 * rate - 2.0 * last_rate
    stops = 2.0 * rate + 4.0 * last_rate - step
    left = [
        (begins - acceleration) * np.exp(eigenvalue)
        + (stops - begins) * np.expm1(eigenvalue) / eigenvalue
        + last_acceleration
        - stops
        for eigenvalue in _mode_eigenvalues(duration_s, modes)
    ]
    return np.asarray(np.resize(WANTED, len(left)) * np.abs(left) / CUBIC_RESIDUAL)


def _mode_eigenvalues(duration_s: float, modes: tuple[StructuralMode, ...]) -> list[complex]:
    """Complex eigenvalues of the modes in normalised time."""
    return [duration_s * share * mode.eigenvalue_rad_s for mode in modes for share in DETUNED]


def _exponential_moments(phase: NDArray[np.complex128], count: int) -> NDArray[np.complex128]:
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
