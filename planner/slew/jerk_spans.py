"""A motion whose jerk is linear on spans: its states, and how it meets its end.

All in normalised time: the motion lasts 1.

Each span has five numbers: angle, rate, acceleration at its begin, jerk at its begin and end.
On a flat span the jerk is the mean of its two numbers throughout.
"""

import numpy as np

from planner.arrays import Array, Mask
from planner.compiled import compiled

MEETINGS = 3  # of the end: the later ones mend what rounding left of the first


@compiled
def reach(width: float, flat: bool, matrix: Array) -> None:
    """Angle, rate, acceleration at a span's end from its five numbers: fills matrix (3, 5)."""
    h = width
    matrix[:] = 0.0
    matrix[0, 0] = matrix[1, 1] = matrix[2, 2] = 1.0
    matrix[0, 1] = matrix[1, 2] = h
    matrix[0, 2] = h * h / 2.0
    for order in range(3):
        power = 3 - order
        whole = h if power == 1 else (h * h / 2.0 if power == 2 else h**3 / 6.0)
        late = whole / 2.0 if flat else whole / (power + 1.0)
        matrix[order, 3], matrix[order, 4] = whole - late, late


@compiled
def jerk_cost(widths: Array, jerks: Array) -> float:
    """The integral of squared jerk, of jerks (n, 2)."""
    early, late = jerks[:, 0], jerks[:, 1]
    return float(np.sum(widths * (early * early + early * late + late * late))) / 3.0


@compiled
def trajectory(widths: Array, flat: Mask, start: Array, jerks: Array) -> Array:
    """Angle, rate, acceleration at all knots, (n + 1, 3), of jerks (n, 2)."""
    states, step = np.empty((len(widths) + 1, 3)), np.empty((3, 5))
    states[0] = start
    for k in range(len(widths)):
        reach(widths[k], flat[k], step)
        for i in range(3):
            total = step[i, 3] * jerks[k, 0] + step[i, 4] * jerks[k, 1]
            for j in range(i, 3):
                total += step[i, j] * states[k, j]
            states[k + 1, i] = total
    return states


@compiled
def meet_end(widths: Array, flat: Mask, ends: Array, jerk_max: float, jerks: Array) -> Array:
    """The jerks, least changed, that lead exactly from ends[0] to ends[1].

    Changed least where they are near their limit, so that none breaks it.
    """
    n = len(widths)
    found, step = jerks.copy(), np.empty((3, 5))
    moves, ease = np.empty((3, n, 2)), np.empty((n, 2))
    for _ in range(MEETINGS):
        left = 0.0
        for k in range(n - 1, -1, -1):
            reach(widths[k], flat[k], step)
            for u in range(2):
                q, v, a = step[0, 3 + u], step[1, 3 + u], step[2, 3 + u]
                moves[0, k, u] = q + left * (v + left / 2.0 * a)
                moves[1, k, u] = v + left * a
                moves[2, k, u] = a
                ease[k, u] = max(jerk_max - abs(found[k, u]), 0.0) ** 2 / widths[k]
            left += widths[k]
        system = np.empty((3, 3))
        for i in range(3):
            for j in range(3):
                system[i, j] = np.sum(moves[i] * ease * moves[j])
        missed = ends[1] - trajectory(widths, flat, ends[0], found)[n]
        prices = solved(system, missed)
        if not np.all(np.isfinite(prices)):
            break
        for i in range(3):
            found += prices[i] * ease * moves[i]
    return found


@compiled
def solved(system: Array, wanted: Array) -> Array:
    """The solution (n,) of a small linear system, scaled rows and columns first; NaN where none.

    A symmetric system with a diagonal that isn't zero.
    """
    n = len(wanted)
    size = np.sqrt(np.abs(np.diag(system)))
    left, right = system / np.outer(size, size), wanted / size
    for i in range(n):
        pivot = i + np.argmax(np.abs(left[i:, i]))
        if not 1e-300 < abs(left[pivot, i]) < 1e300:
            return np.full(n, np.nan)
        for j in range(n):
            left[i, j], left[pivot, j] = left[pivot, j], left[i, j]
        right[i], right[pivot] = right[pivot], right[i]
        for row in range(i + 1, n):
            share = left[row, i] / left[i, i]
            right[row] -= share * right[i]
            for j in range(i, n):
                left[row, j] -= share * left[i, j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            right[i] -= left[i, j] * right[j]
        right[i] /= left[i, i]
    return right / size
