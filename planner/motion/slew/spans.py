"""A motion whose jerk is linear on spans: its states, its hulls, and how it meets its end.

All in normalised time: the motion lasts 1.  widths (n,), states (n + 1, 3) of angle, rate,
acceleration at the knots, jerks (n, 2) at both ends of each span.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from planner.base.arrays import Array, Indices, Mask

if TYPE_CHECKING:
    import casadi

Quantity = TypeVar("Quantity", Array, "casadi.SX")

# What of a span's hulls lies between its knots: orders (0 angle to 2 acceleration), and where each
# coefficient stands, shares of the span (Greville abscissae).
BETWEEN = np.array([0, 0, 0, 1, 1, 2]), np.array([1 / 4, 1 / 2, 3 / 4, 1 / 3, 2 / 3, 1 / 2])
MEETINGS, MET = 2, 1e-14  # of the end: the second mends what rounding left of the first
REGULAR = 1e-12  # a determinant, 1 of what is diagonal


def bernstein_hulls(
    h: Quantity, begin: Iterable[Quantity], end: Iterable[Quantity], j0: Quantity
) -> tuple[list[Quantity], list[Quantity], list[Quantity]]:
    """Bernstein coefficients of angle (5), rate (4), acceleration (3) of spans of width h.

    begin, end: angle, rate, acceleration there.  j0: jerk at the begin.
    """
    (q0, v0, a0), (q1, v1, a1) = begin, end
    return (
        [q0, q0 + h * v0 / 4, q0 + h * v0 / 2 + h**2 * a0 / 12, q1 - h * v1 / 4, q1],
        [v0, v0 + h * a0 / 3, v1 - h * a1 / 3, v1],
        [a0, a0 + h * j0 / 2, a1],
    )


def hull_between(widths: Array, states: Array, jerks: Array) -> Array:
    """The coefficients that BETWEEN names, (n, 6)."""
    found = bernstein_hulls(widths, states[:-1].T, states[1:].T, jerks[:, 0])
    return np.column_stack([inner for hull in found for inner in hull[1:-1]])


def values_at(widths: Array, states: Array, jerks: Array, places: Array, orders: Indices) -> Array:
    """Angle, rate or acceleration by orders (m,) at places (n, m), shares of the spans."""
    t = places * widths[:, None]
    j, s = jerks[:, :1], np.diff(jerks, axis=1) / widths[:, None]
    q, v, a = (states[:-1, order, None] for order in range(3))
    return np.where(
        orders == 0,
        q + t * (v + t * (a / 2.0 + t * (j / 6.0 + t * s / 24.0))),
        np.where(orders == 1, v + t * (a + t * (j / 2.0 + t * s / 6.0)), a + t * (j + t * s / 2.0)),
    )


def trajectory(widths: Array, start: Array, jerks: Array) -> Array:
    """The states at all knots, from the first one."""
    h, (early, late) = widths, jerks.T
    states = np.empty((len(h) + 1, 3))
    states[0] = start
    q, v, a = states.T
    a[1:] = h * (early + late) / 2.0
    np.cumsum(a, out=a)
    v[1:] = h * (a[:-1] + h * (2.0 * early + late) / 6.0)
    np.cumsum(v, out=v)
    q[1:] = h * (v[:-1] + h * (a[:-1] / 2.0 + h * (3.0 * early + late) / 24.0))
    np.cumsum(q, out=q)
    return states


def jerk_cost(widths: Array, jerks: Array) -> float:
    """The integral of squared jerk."""
    early, late = jerks.T
    return float(widths @ (early * early + early * late + late * late)) / 3.0


def least_cost(ends: Array) -> float:
    """The cost of the quintic between these ends: no motion has less, whatever its limits."""
    (q0, v0, a0), (q1, v1, a1) = ends
    dq, dv, da = q1 - q0 - v0 - a0 / 2.0, v1 - v0 - a0, a1 - a0
    moments = np.array([da, da - 2.0 * dv, da - 6.0 * dv + 12.0 * dq])  # by Legendre's polynomials
    return float(moments**2 @ np.array([1.0, 3.0, 5.0]))


def meet_end(
    widths: Array, flat: Mask, ends: Array, jerk_max: float, jerks: Array
) -> tuple[Array, Array]:
    """The states and the jerks, least changed, that lead exactly from ends[0] to ends[1].

    Changed least where they are near their limit, so that none breaks it; equal on flat spans.
    """
    h, left = widths[:, None], (1.0 - np.cumsum(widths))[:, None]
    a, v, q = h * [0.5, 0.5], h**2 * [2.0, 1.0] / 6.0, h**3 * [3.0, 1.0] / 24.0
    moves = np.array([q + left * (v + left / 2.0 * a), v + left * a, a])
    moves[:, flat] = moves[:, flat].mean(axis=2, keepdims=True)
    moves = moves.reshape(3, -1)
    states = trajectory(widths, ends[0], jerks)
    for _ in range(MEETINGS):
        missed = ends[1] - states[-1]
        if np.abs(missed).max() <= MET:
            break
        eased = moves * (np.maximum(jerk_max - np.abs(jerks), 0.0) ** 2 / h).ravel()
        jerks = jerks + (solve_scaled(eased @ moves.T, missed) @ eased).reshape(-1, 2)
        states = trajectory(widths, ends[0], jerks)
    return states, jerks


def solve_scaled(system: Array, wanted: Array) -> Array:
    """A small symmetric system whose rows and columns are first scaled, by least squares where it
    is all but singular."""
    size = np.sqrt(np.diag(system)) + 1e-300
    scaled, share = system / np.outer(size, size), wanted / size
    (_, xy, xz), (_, _, yz) = scaled[:2].tolist()
    if 1.0 + 2.0 * xy * yz * xz - xy * xy - yz * yz - xz * xz > REGULAR:  # its determinant
        return np.linalg.solve(scaled, share) / size
    return np.linalg.lstsq(scaled, share)[0] / size


def turning_shares(states: Array) -> Array:
    """Where angle and rate turn within each span, shares (n, 2); a half where they don't."""
    before, after = states[:-1, 1:], states[1:, 1:]
    turns = before * after < 0.0
    return np.asarray(np.where(turns, before / np.where(turns, before - after, 1.0), 0.5))


def where_to_cut(states: Array, active: Mask) -> Array:
    """Where to cut each span, shares (n,): where angle or rate, the one at its limit, turns, or in
    the middle."""
    at = turning_shares(states)
    at = np.where(active & (at > 0.1) & (at < 0.9), at, 0.5)
    return np.where(at[:, 1] != 0.5, at[:, 1], at[:, 0])
