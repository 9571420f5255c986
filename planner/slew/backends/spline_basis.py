"""What do a clamped B-spline's coefficients give at every instant?"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array

ENDS = 3  # angle, rate and acceleration at an end fix so many coefficients there
GAUSS_POINTS = 3  # exact to degree 5; squared third derivatives of a quintic have degree 4


@dataclass(frozen=True)
class SplineBasis:
    """Everything the knots determine; n coefficients, the first and last three fixed.

    fixed_from_ends: (6, 6) from the normalised angle, rate, acceleration at both ends.
    pieces: (spans, degree + 1, degree + 1), power coefficients from the coefficients that live
    on a span; the others are nought, and hundreds of spans would make them 100 MB.
    """

    knots: Array
    spans: Array
    fixed: NDArray[np.intp]
    free: NDArray[np.intp]
    fixed_from_ends: Array
    pieces: Array

    @property
    def living(self) -> NDArray[np.intp]:
        """Which coefficients live on each span, shape (spans, degree + 1)."""
        spans, powers, _ = self.pieces.shape
        return np.asarray(np.arange(spans)[:, None] + np.arange(powers))


def spline_basis(breakpoints: Array, degree: int) -> SplineBasis:
    knots = np.concatenate([np.zeros(degree), breakpoints, np.ones(degree)])
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
        spans=breakpoints,
        fixed=fixed,
        free=np.arange(ENDS, n - ENDS),
        fixed_from_ends=np.linalg.inv(ends[:, fixed]),
        pieces=_power_pieces(breakpoints, knots, degree),
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


def _power_pieces(breakpoints: Array, knots: Array, degree: int) -> Array:
    """Taylor coefficients at each span's start, from the coefficients that live on it."""
    n, spans = len(knots) - degree - 1, len(breakpoints) - 1
    local = np.tile(np.eye(degree + 1), (spans, 1, 1))
    pieces, factorial = np.empty((spans, degree + 1, degree + 1)), 1.0
    for power in range(degree + 1):
        if power:
            weight = _difference_weights(knots, n, degree, power)
            here = weight[np.arange(spans)[:, None] + np.arange(degree + 1 - power)]
            local = here[:, :, None] * np.diff(local, axis=1)
            factorial *= power
        reduced = knots[power : len(knots) - power]
        values = _values_at_starts(reduced, degree - power, breakpoints[:-1])
        pieces[:, power] = np.einsum("kl,kln->kn", values, local) / factorial
    return pieces


def _values_at_starts(knots: Array, degree: int, starts: Array) -> Array:
    """The degree + 1 B-splines that live on each span, at its start (Cox-de Boor), (k, d + 1)."""
    left = np.arange(len(starts))[:, None] + degree
    at = starts[:, None]
    values = np.ones((len(starts), 1))
    for p in range(1, degree + 1):
        low, high = knots[left + np.arange(1 - p, 1)], knots[left + np.arange(1, p + 1)]
        share = values / (high - low)
        values = np.pad((high - at) * share, ((0, 0), (0, 1)))
        values[:, 1:] += (at - low) * share
    return values


def jerk_cost(basis: SplineBasis, n: int) -> Array:
    """Integral over [0, 1] of the outer product of third derivatives, shape (n, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    width, living = np.diff(basis.spans), basis.living
    total = np.zeros((n, n))
    powers = np.arange(3, basis.pieces.shape[1])
    factor = powers * (powers - 1) * (powers - 2)
    for node, weight in zip(nodes, weights, strict=True):
        x = width * (node + 1.0) / 2.0
        third = np.einsum("kj,kjn->kn", factor * x[:, None] ** (powers - 3), basis.pieces[:, 3:])
        squares = (weight * width / 2.0)[:, None, None] * third[:, :, None] * third[:, None, :]
        np.add.at(total, (living[:, :, None], living[:, None, :]), squares)
    return total
