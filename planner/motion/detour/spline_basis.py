"""Clamped B-splines: what their coefficients give at every instant of normalised time tau."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array

ENDS = 3  # angle, rate and acceleration at an end fix so many coefficients there
GAUSS_POINTS = 3  # exact to degree 5; squared third derivatives of a quintic have degree 4


@dataclass(frozen=True)
class SplineBasis:
    """Everything the knots determine; n coefficients, the first and last three fixed.

    breakpoints_tau: the knots without repetition, from 0 to 1.
    fixed_from_ends: (6, 6) from the normalised angle, rate, acceleration at both ends.
    power_matrix: (spans, degree + 1, degree + 1), power coefficients from the coefficients
    whose splines don't vanish on a span; all n of hundreds of spans would take 100 MB.
    """

    knots: Array
    breakpoints_tau: Array
    fixed: NDArray[np.intp]
    free: NDArray[np.intp]
    fixed_from_ends: Array
    power_matrix: Array

    @property
    def support(self) -> NDArray[np.intp]:
        """Coefficients whose splines don't vanish on each span, shape (spans, degree + 1)."""
        spans, powers, _ = self.power_matrix.shape
        return np.asarray(np.arange(spans)[:, None] + np.arange(powers))


def spline_basis(breakpoints_tau: Array, degree: int) -> SplineBasis:
    knots = np.concatenate([np.zeros(degree), breakpoints_tau, np.ones(degree)])
    n = len(knots) - degree - 1
    derivatives = derivative_matrices(knots, degree)
    fixed = np.r_[0:ENDS, n - ENDS : n]
    ends = np.stack(
        [
            *(derivatives[order][0] for order in range(ENDS)),
            *(derivatives[order][-1] for order in reversed(range(ENDS))),
        ]
    )
    return SplineBasis(
        knots=knots,
        breakpoints_tau=breakpoints_tau,
        fixed=fixed,
        free=np.arange(ENDS, n - ENDS),
        fixed_from_ends=np.linalg.inv(ends[:, fixed]),
        power_matrix=_power_matrix(breakpoints_tau, knots, degree),
    )


def derivative_matrices(knots: Array, degree: int) -> list[Array]:
    """D_0 = 1 to D_3: coefficients of each derivative from the spline's own, (n - order, n)."""
    n = len(knots) - degree - 1
    chain = [np.eye(n)]
    for order in range(1, ENDS + 1):
        weight = _difference_weights(knots, n, degree, order)
        chain.append(weight[:, None] * np.diff(chain[-1], axis=0))
    return chain


def _difference_weights(knots: Array, n: int, degree: int, order: int) -> Array:
    """What the differences of the coefficients of derivative order - 1 count, (n - order,)."""
    count, p = n - order, degree - order + 1
    inner = knots[order:-order]
    return np.asarray(p / (inner[p : p + count] - inner[:count]))


def _power_matrix(breakpoints_tau: Array, knots: Array, degree: int) -> Array:
    """Taylor coefficients at each span's start, from the coefficients of its support."""
    n, spans = len(knots) - degree - 1, len(breakpoints_tau) - 1
    local = np.tile(np.eye(degree + 1), (spans, 1, 1))
    power_matrix, factorial = np.empty((spans, degree + 1, degree + 1)), 1.0
    for power in range(degree + 1):
        if power:
            weight = _difference_weights(knots, n, degree, power)
            here = weight[np.arange(spans)[:, None] + np.arange(degree + 1 - power)]
            local = here[:, :, None] * np.diff(local, axis=1)
            factorial *= power
        reduced = knots[power : len(knots) - power]
        values = _values_at_starts(reduced, degree - power, breakpoints_tau[:-1])
        power_matrix[:, power] = np.einsum("kl,kln->kn", values, local) / factorial
    return power_matrix


def _values_at_starts(knots: Array, degree: int, starts_tau: Array) -> Array:
    """B-splines that don't vanish on each span, at its start (Cox-de Boor), (k, degree + 1)."""
    left = np.arange(len(starts_tau))[:, None] + degree
    at = starts_tau[:, None]
    values = np.ones((len(starts_tau), 1))
    for p in range(1, degree + 1):
        low, high = knots[left + np.arange(1 - p, 1)], knots[left + np.arange(1, p + 1)]
        share = values / (high - low)
        values = np.pad((high - at) * share, ((0, 0), (0, 1)))
        values[:, 1:] += (at - low) * share
    return values


def jerk_cost(basis: SplineBasis, n: int) -> Array:
    """Integral over [0, 1] of the outer product of third derivatives, shape (n, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    width, support = np.diff(basis.breakpoints_tau), basis.support
    total = np.zeros((n, n))
    powers = np.arange(3, basis.power_matrix.shape[1])
    factor = powers * (powers - 1) * (powers - 2)
    for node, weight in zip(nodes, weights, strict=True):
        x = width * (node + 1.0) / 2.0
        third = np.einsum(
            "kj,kjn->kn", factor * x[:, None] ** (powers - 3), basis.power_matrix[:, 3:]
        )
        squares = (weight * width / 2.0)[:, None, None] * third[:, :, None] * third[:, None, :]
        np.add.at(total, (support[:, :, None], support[:, None, :]), squares)
    return total
