"""Interpolation between the rows of a uniform table."""

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array

NODES = 6


class UniformTable:
    """Polynomials of degree 5 through the six rows around each cell.

    The error in mid-table is 0.0049 (step w)^6 of a motion that turns at w: at 60 s, 3 mm of a
    low orbit.  In the first and last two cells it is up to five times that.  Outside the table
    the end polynomials go on.  Source: Lagrange interpolation on equidistant nodes.
    """

    def __init__(self, step_s: float, node_value: Array) -> None:
        """node_value: shape (n, k), n >= 6, rows at 0, step_s, 2 step_s, ..."""
        self._step_s = step_s
        cells = len(node_value) - 1
        first = np.clip(np.arange(cells) - NODES // 2 + 1, 0, len(node_value) - NODES)
        stencils = node_value[first[:, None] + np.arange(NODES)]
        place = np.arange(cells) - first
        inverses = np.array(
            [
                np.linalg.inv(np.vander(np.arange(NODES) - float(p), increasing=True))
                for p in range(NODES)
            ]
        )
        self._powers = np.ascontiguousarray(
            np.einsum("npk->pnk", np.matmul(inverses[place], stencils))
        )

    def at(self, t_s: Array) -> Array:
        """Shape (m, k) at t_s (m,)."""
        cell, u = self._place(t_s)
        total = self._powers[-1].take(cell, axis=0)
        for power in self._powers[-2::-1]:
            total *= u
            total += power.take(cell, axis=0)
        return np.asarray(total)

    def rate_at(self, t_s: Array) -> Array:
        """Derivative with respect to time, shape (m, k)."""
        cell, u = self._place(t_s)
        total = (NODES - 1) * self._powers[-1].take(cell, axis=0)
        for order in range(NODES - 2, 0, -1):
            total *= u
            total += order * self._powers[order].take(cell, axis=0)
        return np.asarray(total / self._step_s)

    def _place(self, t_s: Array) -> tuple[NDArray[np.intp], Array]:
        position = t_s / self._step_s
        cell = np.clip(position.astype(np.intp), 0, self._powers.shape[1] - 1)
        return cell, (position - cell)[:, None]
