"""A test for staircases: an axis that stands and jumps while its command creeps.

Rows are cut into parts in which the axis either stands (its measured angle is constant) or follows
(its error is): the cut with the least squares and a price on each part.  Where the same price on
parts that only follow does clearly worse, the axis stood.  Source: optimal partitioning, Jackson et
al. 2005, sec. 2.
"""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask

_PART_PRICE = 6.0  # squares over the noise's: two free numbers a part
_STAND_ROWS_MIN = 3


@dataclass(frozen=True)
class StaircasePart:
    """Rows first to last, without last.  level: constant part of the angle, or of the error."""

    first: int
    last: int
    stands: bool
    level: float


@dataclass(frozen=True)
class Staircase:
    """cost: squares left over the noise's, and the price of the parts.  left_variance_rad2: of a
    row."""

    cost: float
    left_variance_rad2: float
    parts: tuple[StaircasePart, ...]

    def stands(self, rows: int) -> Mask:
        """Of so many rows, (n,)."""
        mask = np.zeros(rows, dtype=bool)
        for part in self.parts:
            mask[part.first : part.last] = part.stands
        return mask


def fit_staircase(
    error_rad: Array, angle_rad: Array, variance_rad2: float, *, may_stand: bool
) -> Staircase:
    """The cheapest parts.  error_rad, angle_rad: (n,), measured less planned, and measured; n up to
    a few hundred."""
    count = len(error_rad)
    cost_of_part = _squares_of_parts(error_rad)
    is_stand = np.zeros_like(cost_of_part, dtype=bool)
    if may_stand:
        standing = _squares_of_parts(angle_rad)
        standing[np.tri(count, count + 1, _STAND_ROWS_MIN - 1, dtype=bool)] = np.inf  # too short
        is_stand = standing < cost_of_part
        cost_of_part = np.minimum(cost_of_part, standing)
    cost_of_part = cost_of_part / variance_rad2 + _PART_PRICE
    cost, origin = np.zeros(count + 1), np.zeros(count + 1, dtype=np.intp)
    for last in range(1, count + 1):
        total = cost[:last] + cost_of_part[:last, last]
        origin[last] = first = int(total.argmin())
        cost[last] = total[first]
    parts: list[StaircasePart] = []
    last = count
    while last:
        first = int(origin[last])
        stands = bool(is_stand[first, last])
        level = float(np.mean((angle_rad if stands else error_rad)[first:last]))
        parts.append(StaircasePart(first, last, stands, level))
        last = first
    left = (float(cost[count]) - _PART_PRICE * len(parts)) * variance_rad2
    free = max(count - 2 * len(parts), 1)
    return Staircase(float(cost[count]), left / free, tuple(reversed(parts)))


def swing_squares(t_s: Array, error: Array, variance_rad2: float) -> float:
    """Least squares over the noise's of a swing beside a parabola, at the price of three parts."""
    place = np.linspace(-1.0, 1.0, len(t_s))
    trend, _ = np.linalg.qr(np.polynomial.legendre.legvander(place, 2))
    left = error - trend @ (trend.T @ error)
    cycles = np.arange(1.0, 2.0 * (len(t_s) - 1)) / 4.0  # of the stretch, up to half a row's rate
    phase = 2.0 * np.pi * cycles[:, None] * (t_s - t_s[0]) / (t_s[-1] - t_s[0])
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=1)  # (frequencies, 2, n)
    waves = waves - waves @ trend @ trend.T
    along = waves @ left
    inverse = np.linalg.pinv(waves @ waves.transpose(0, 2, 1), 1e-9)
    explained = np.einsum("fi,fij,fj->f", along, inverse, along)
    return float(left @ left - explained.max()) / variance_rad2 + 3.0 * _PART_PRICE


def _squares_of_parts(value: Array) -> Array:
    """About their means, of rows first to last without it, (n, n + 1); infinite where none are."""
    centred = value - value.mean()
    sums, squares = (np.concatenate([[0.0], np.cumsum(one)]) for one in (centred, centred**2))
    last = np.arange(len(value) + 1)
    rows = last - last[:-1, None]
    own = squares - squares[:-1, None] - (sums - sums[:-1, None]) ** 2 / np.maximum(rows, 1)
    return np.where(rows > 0, np.maximum(own, 0.0), np.inf)
