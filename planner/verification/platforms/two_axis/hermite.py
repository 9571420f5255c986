"""An axis between two rows: the cubic Hermite, and its extremes in closed form."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S


@dataclass(frozen=True)
class HermiteExtreme:
    """A value and where it is reached, t_s in seconds since the table's epoch."""

    value: float
    t_s: float


@dataclass(frozen=True, eq=False)
class AxisHermite:
    """One axis through its rows, `COMMAND_STEP_S` apart.

    angle_rad, rate_rad_s: shape (n,), n >= 2.  Within cell k, u seconds after row k, the angle
    is angle + rate u + half_acceleration u^2 + sixth_jerk u^3.
    """

    angle_rad: Array
    rate_rad_s: Array

    def over(self, rows: range) -> "AxisHermite":
        """The same between the first and the last of these rows."""
        part = slice(rows[0], rows[-1] + 1)
        return AxisHermite(self.angle_rad[part], self.rate_rad_s[part])

    @property
    def is_resting(self) -> Mask:
        """Shape (n - 1,): whether the axis stands still throughout a cell."""
        still = self.rate_rad_s == 0.0
        return np.asarray(still[:-1] & still[1:] & (self.angle_rad[:-1] == self.angle_rad[1:]))

    @cached_property
    def half_acceleration_rad_s2(self) -> Array:
        """Shape (n - 1,)."""
        step = np.diff(self.angle_rad) / COMMAND_STEP_S
        return np.asarray(
            (3.0 * step - 2.0 * self.rate_rad_s[:-1] - self.rate_rad_s[1:]) / COMMAND_STEP_S
        )

    @cached_property
    def sixth_jerk_rad_s3(self) -> Array:
        """Shape (n - 1,)."""
        step = np.diff(self.angle_rad) / COMMAND_STEP_S
        return np.asarray(
            (self.rate_rad_s[:-1] + self.rate_rad_s[1:] - 2.0 * step) / COMMAND_STEP_S**2
        )

    @property
    def acceleration_after_row_rad_s2(self) -> Array:
        """Shape (n - 1,): where each cell begins."""
        return 2.0 * self.half_acceleration_rad_s2

    @property
    def acceleration_before_row_rad_s2(self) -> Array:
        """Shape (n - 1,): where each cell ends."""
        return 2.0 * self.half_acceleration_rad_s2 + 6.0 * self.sixth_jerk_rad_s3 * COMMAND_STEP_S

    def angle_at(self, cell: NDArray[np.intp] | slice, u_s: Array) -> Array:
        """Angle u_s after the row the cell begins with; shapes broadcast."""
        a, r = self.angle_rad[:-1][cell], self.rate_rad_s[:-1][cell]
        h, j = self.half_acceleration_rad_s2[cell], self.sixth_jerk_rad_s3[cell]
        return np.asarray(a + u_s * (r + u_s * (h + u_s * j)))

    def rate_at(self, cell: NDArray[np.intp] | slice, u_s: Array) -> Array:
        """As `angle_at`, rad/s."""
        h, j = self.half_acceleration_rad_s2[cell], self.sixth_jerk_rad_s3[cell]
        return np.asarray(self.rate_rad_s[:-1][cell] + u_s * (2.0 * h + u_s * 3.0 * j))

    def crossings_s(self, rate_rad_s: float) -> Array:
        """When in its cell the rate passes a value, shape (2, n - 1); NaN where it doesn't."""
        return _quadratic_roots(
            3.0 * self.sixth_jerk_rad_s3,
            2.0 * self.half_acceleration_rad_s2,
            self.rate_rad_s[:-1] - rate_rad_s,
        )

    def angle_extremes(self) -> tuple[HermiteExtreme, HermiteExtreme]:
        """Least and greatest angle anywhere."""
        turning = _inside(self.crossings_s(0.0))
        return _extremes(
            (self.angle_rad[:-1], 0.0),
            *((self.angle_at(slice(None), u_s), u_s) for u_s in turning),
            (self.angle_rad[1:], COMMAND_STEP_S),
        )

    def rate_extreme(self) -> HermiteExtreme:
        """Greatest magnitude of the rate, with its sign."""
        with np.errstate(divide="ignore", invalid="ignore"):
            turning = _inside(-self.half_acceleration_rad_s2 / (3.0 * self.sixth_jerk_rad_s3))
        return _greatest_magnitude(
            (self.rate_rad_s[:-1], 0.0),
            (self.rate_at(slice(None), turning), turning),
            (self.rate_rad_s[1:], COMMAND_STEP_S),
        )

    def acceleration_extreme(self) -> HermiteExtreme:
        """Greatest magnitude of the acceleration, linear in each cell, with its sign."""
        return _greatest_magnitude(
            (self.acceleration_after_row_rad_s2, 0.0),
            (self.acceleration_before_row_rad_s2, COMMAND_STEP_S),
        )

    def jerk_extreme(self) -> HermiteExtreme:
        """Greatest magnitude of the jerk, constant in each cell, with its sign; cell's start."""
        return _greatest_magnitude((6.0 * self.sixth_jerk_rad_s3, 0.0))

    def acceleration_jump_extreme(self, initial_acceleration_rad_s2: float) -> HermiteExtreme:
        """Greatest step of the acceleration at a row; before row 0 it is the initial one."""
        before = np.append(initial_acceleration_rad_s2, self.acceleration_before_row_rad_s2[:-1])
        return _greatest_magnitude((self.acceleration_after_row_rad_s2 - before, 0.0))


def _extremes(*kinds: tuple[Array, Array | float]) -> tuple[HermiteExtreme, HermiteExtreme]:
    """Least and greatest; each kind: a value in every cell, and how far into the cell, s."""
    values = np.stack([value for value, _ in kinds])

    def at(place: int) -> HermiteExtreme:
        kind, cell = divmod(place, values.shape[1])
        u_s = kinds[kind][1]
        into_cell_s = u_s if isinstance(u_s, float) else float(u_s[cell])
        return HermiteExtreme(float(values[kind, cell]), cell / ROWS_PER_S + into_cell_s)

    return at(int(np.argmin(values))), at(int(np.argmax(values)))


def _greatest_magnitude(*kinds: tuple[Array, Array | float]) -> HermiteExtreme:
    return max(_extremes(*kinds), key=lambda extreme: abs(extreme.value))


def _inside(u_s: Array) -> Array:
    """Clipped into the cell, so that whatever comes of rounding lies on the curve; NaN to 0."""
    return np.clip(np.nan_to_num(u_s, nan=0.0), 0.0, COMMAND_STEP_S)


def _quadratic_roots(a: Array, b: Array, c: Array) -> Array:
    """Real roots of a u^2 + b u + c, shape (2, n), NaN or infinite where there is none.

    Source: Press 2007, Numerical Recipes, eq. 5.6.4 (no cancellation between b and the root).
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
        return np.stack([q / a, c / q])
