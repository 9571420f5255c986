"""A planned slew: piecewise polynomials, their exact extremes, and what they break."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S
from planner.base.solvers import SolverRun
from planner.motion.pointing.hermite import cubic_range
from planner.motion.slew.problem import LIMIT_TOLERANCE, AxisState, SlewProblem
from planner.world.platforms import AxisLimits

ORDERS = ("angle", "rate", "acceleration", "jerk")
SAMPLES = 9
NEGLIGIBLE = 1e-13  # of a polynomial's largest coefficient: rounding, not a leading term


class Extreme(NamedTuple):
    """Least and greatest value of one derivative, SI, and when."""

    least: float
    least_at_s: float
    greatest: float
    greatest_at_s: float


class LimitViolation(NamedTuple):
    """axis breaks limit ("angle", "rate", "acceleration", "jerk"): the worst value and when."""

    axis: str
    limit: str
    value: float
    bound: float
    at_s: float


@dataclass(frozen=True, kw_only=True)
class AxisProfile:
    """Motion of one axis: on [breakpoints_s[k], breakpoints_s[k+1]] a polynomial.

    breakpoints_s: (k+1,), the first 0.  coefficients: (k, degree+1), a cubic's at least,
    ascending powers of the time since the piece's own breakpoint, rad/s^j.
    """

    breakpoints_s: Array
    coefficients: Array

    @property
    def duration_s(self) -> float:
        return float(self.breakpoints_s[-1])

    def evaluate(self, t_s: Array) -> tuple[Array, Array, Array, Array]:
        """Angle, rate, acceleration, jerk at t_s (n,); at a breakpoint, of the later piece."""
        angle, rate, acceleration, jerk = self.lowest(t_s, 4)
        return angle, rate, acceleration, jerk

    def lowest(self, t_s: Array, orders: int) -> list[Array]:
        """The first so many of these."""
        last = len(self.coefficients) - 1
        piece = np.clip(np.searchsorted(self.breakpoints_s, t_s, side="right") - 1, 0, last)
        x = t_s - self.breakpoints_s[piece]
        values = []
        for derivative in self._derivatives[:orders]:
            *lower, value = np.take(derivative.T, piece, axis=1)
            for coefficient in reversed(lower):
                value = value * x + coefficient
            values.append(value)
        return values

    @cached_property
    def extremes(self) -> tuple[Extreme, Extreme, Extreme, Extreme]:
        """Exact extremes of angle, rate, acceleration and jerk, from roots of derivatives."""
        return (self._extreme_of(0), self._extreme_of(1), self._extreme_of(2), self._extreme_of(3))

    @cached_property
    def jerk_squared_integral(self) -> float:
        """Integral of squared jerk, rad^2/s^5; infinite where the acceleration jumps."""
        if self.acceleration_jumps:
            return float("inf")
        jerk = self._derivatives[3]
        unit, orders = jerk * self._powers[:, : jerk.shape[1]], np.arange(jerk.shape[1])
        hilbert = 1.0 / (1.0 + np.add.outer(orders, orders))
        return float(np.diff(self.breakpoints_s) @ (unit @ hilbert * unit).sum(axis=1))

    @cached_property
    def acceleration_jumps(self) -> bool:
        """Whether the acceleration is discontinuous inside the profile, beyond rounding."""
        acceleration = self._derivatives[2]
        at_end = (acceleration * self._powers[:, : acceleration.shape[1]]).sum(axis=1)
        scale = np.abs(acceleration[:, 0]).max() + np.abs(at_end).max() + 1e-12
        return bool(np.any(np.abs(at_end[:-1] - acceleration[1:, 0]) > 1e-6 * scale))

    @cached_property
    def end_values(self) -> Array:
        """Angle, rate, acceleration, jerk at the first and the last instant, shape (2, 4)."""
        powers = self._powers[-1]
        at_end = [
            derivative[-1] @ powers[: derivative.shape[1]] for derivative in self._derivatives
        ]
        return np.array([[derivative[0, 0] for derivative in self._derivatives], at_end])

    def surely_within(self, limits: AxisLimits) -> bool:
        """Whether the hull of each piece keeps all limits: proof when true, nothing when false."""
        return self._all_within(limits, _bernstein_from_power)

    def surely_outside(self, limits: AxisLimits) -> bool:
        """Whether a sample breaks a limit: proof when true, nothing when false."""
        return not self._all_within(limits, _samples_from_power)

    def _all_within(self, limits: AxisLimits, values_from_power: Callable[[int], Array]) -> bool:
        for derivative, (low, high) in zip(self._derivatives, limits.bounds, strict=True):
            count = derivative.shape[1]
            values = (derivative * self._powers[:, :count]) @ values_from_power(count).T
            slack = LIMIT_TOLERANCE * (high - low)
            if values.min() < low - slack or values.max() > high + slack:
                return False
        return True

    @cached_property
    def _powers(self) -> Array:
        """Shares of each piece's width, ascending from 0, as many as its polynomial has."""
        return np.diff(self.breakpoints_s)[:, None] ** np.arange(self.coefficients.shape[1])

    @cached_property
    def _derivatives(self) -> tuple[Array, ...]:
        """Coefficients of angle, rate, acceleration and jerk."""
        c = self.coefficients
        chain = [c]
        for _ in range(3):
            c = c[:, 1:] * np.arange(1, c.shape[1])
            chain.append(c)
        return tuple(chain)

    def _extreme_of(self, order: int) -> Extreme:
        width = np.diff(self.breakpoints_s)
        derivative = self._derivatives[order]
        unit = derivative * self._powers[:, : derivative.shape[1]]
        values = [unit[:, 0], unit.sum(axis=1)]
        times = [self.breakpoints_s[:-1], self.breakpoints_s[1:]]
        for piece in _pieces_that_may_reach_beyond(unit):
            s = _turning_points(unit[piece])
            values.append(polynomial.polyval(s, unit[piece]))
            times.append(self.breakpoints_s[piece] + s * width[piece])
        value, at_s = np.concatenate(values), np.concatenate(times)
        low, high = int(np.argmin(value)), int(np.argmax(value))
        return Extreme(float(value[low]), float(at_s[low]), float(value[high]), float(at_s[high]))


@dataclass(frozen=True, kw_only=True)
class SlewSolution:
    """The slew of all axes, judged by its own polynomials and not by a solver's word.

    profiles: one per axis, all of duration_s.  status: how each axis was solved.
    iterations: of the solver, all axes together.  wall_s: time spent solving.
    violations: every limit the exact extremes break, none from `optimal_slew`.
    end_error_rad: distance from the wanted end angle, per axis; on the track it dies away
    with the time constant settling_s.
    lower_bounds_rad2_s5: of the integral of squared jerk, per axis: no motion between the same
    states within the limits costs less; none where no optimum was sought.
    runs: of the solver, per axis, None where the motion is no solver's; of a detour the one of
    both axes.
    search_truncated: whether the bound of work ended the search for a better one.
    """

    problem: SlewProblem
    profiles: tuple[AxisProfile, ...]
    status: tuple[str, ...]
    iterations: int
    wall_s: float
    violations: tuple[LimitViolation, ...]
    end_error_rad: tuple[float, ...]
    lower_bounds_rad2_s5: tuple[float, ...] = ()
    runs: tuple[SolverRun | None, ...] = ()
    settling_s: float = 0.0
    search_truncated: bool = False

    @property
    def duration_s(self) -> float:
        return self.profiles[0].duration_s

    @property
    def jerk_squared_integral(self) -> float:
        """Sum over the axes of the integral of squared jerk, rad^2/s^5."""
        return sum(profile.jerk_squared_integral for profile in self.profiles)

    def motion(self, t_s: Array) -> tuple[Array, Array, Array, Array]:
        """Angle, rate, acceleration, jerk, each (n, m), at t_s (n,) since the slew's start."""
        per_axis = [profile.evaluate(t_s) for profile in self.profiles]
        angle, rate, acceleration, jerk = (
            np.stack([values[order] for values in per_axis], axis=1) for order in range(4)
        )
        return angle, rate, acceleration, jerk


def chain_profiles(parts: list[AxisProfile]) -> AxisProfile:
    """One motion after the other; each must begin as the one before ends."""
    breakpoints_s, begin_s = [np.zeros(1)], 0.0
    for part in parts:
        breakpoints_s.append(begin_s + part.breakpoints_s[1:])
        begin_s += part.duration_s
    width = max(part.coefficients.shape[1] for part in parts)
    pieces = [
        np.pad(part.coefficients, ((0, 0), (0, width - part.coefficients.shape[1])))
        for part in parts
    ]
    return AxisProfile(
        breakpoints_s=np.concatenate(breakpoints_s), coefficients=np.concatenate(pieces)
    )


def violations(axis: str, profile: AxisProfile, limits: AxisLimits) -> tuple[LimitViolation, ...]:
    """Limits that the profile breaks anywhere, the worst value of each."""
    found = []
    for name, extreme, (low, high) in zip(ORDERS, profile.extremes, limits.bounds, strict=True):
        slack = LIMIT_TOLERANCE * (high - low)
        if extreme.greatest > high + slack and extreme.greatest - high >= low - extreme.least:
            found.append(LimitViolation(axis, name, extreme.greatest, high, extreme.greatest_at_s))
        elif extreme.least < low - slack:
            found.append(LimitViolation(axis, name, extreme.least, low, extreme.least_at_s))
    return tuple(found)


def obeys(profile: AxisProfile, start: AxisState, end: AxisState, limits: AxisLimits) -> bool:
    """Whether the profile leads from start to end and keeps every limit at every instant."""
    if not _meets_ends(profile, start, end, limits):
        return False
    if profile.surely_within(limits):
        return True
    return not profile.surely_outside(limits) and not violations("", profile, limits)


def _meets_ends(profile: AxisProfile, start: AxisState, end: AxisState, limits: AxisLimits) -> bool:
    """Whether the profile begins and ends in the given states, to 1e-9 of the limits."""
    for values, state in zip(profile.end_values, (start, end), strict=True):
        wanted = (state.angle_rad, state.rate_rad_s, state.acceleration_rad_s2)
        for value, target, (low, high) in zip(values[:3], wanted, limits.bounds[:3], strict=True):
            if abs(value - target) > LIMIT_TOLERANCE * (high - low):
                return False
    return True


def _pieces_that_may_reach_beyond(unit: Array) -> NDArray[np.intp]:
    """Pieces (on [0, 1]) whose hull reaches beyond what all pieces begin and end with."""
    hull = unit @ _bernstein_from_power(unit.shape[1]).T
    ends = hull[:, [0, -1]]
    return np.flatnonzero((hull.min(axis=1) < ends.min()) | (hull.max(axis=1) > ends.max()))


@cache
def _bernstein_from_power(count: int) -> Array:
    """Bernstein coefficients are this (count, count) matrix times ascending power ones."""
    matrix = np.zeros((count, count))
    for row in range(count):
        ratio = 1.0
        for column in range(row + 1):
            matrix[row, column] = ratio
            ratio *= (row - column) / (count - 1 - column) if column < count - 1 else 0.0
    return matrix


@cache
def _samples_from_power(count: int) -> Array:
    """Values at a few places of [0, 1] are this matrix times ascending power coefficients."""
    return np.linspace(0.0, 1.0, SAMPLES)[:, None] ** np.arange(count)


def _turning_points(unit: Array) -> Array:
    """Roots in (0, 1) of the derivative of one polynomial on [0, 1]."""
    slope = unit[1:] * np.arange(1, len(unit))
    significant = np.flatnonzero(np.abs(slope) > NEGLIGIBLE * np.abs(slope).max())
    if significant.size == 0 or significant[-1] == 0:
        return np.empty(0)
    roots = polynomial.polyroots(slope[: significant[-1] + 1])
    real = roots.real[np.abs(roots.imag) < 1e-6]
    return np.asarray(real[(real > 0.0) & (real < 1.0)])


# The motion flown from rows every 0.2 s: the cubic Hermite between them.

REPRODUCTION_RAD = np.deg2rad(0.1 / 3600.0)  # how far the flown Hermite may leave the plan
SAMPLES_PER_ROW = 8  # the deviation is a quartic bump in a cell: its peak is met within 4 %


def rows_in(duration_s: float) -> int:
    """How many command steps a slew of duration_s takes; ValueError if it isn't a whole number."""
    rows = round(duration_s / COMMAND_STEP_S)
    if rows < 1 or abs(rows * COMMAND_STEP_S - duration_s) > 1e-6 * COMMAND_STEP_S:
        raise ValueError(
            f"duration_s must be a multiple of the command step, 0.2 s, not {duration_s}"
        )
    return rows


def reproduces(profile: AxisProfile, rows: int, limits: AxisLimits) -> bool:
    """Whether the Hermite of the sampled profile keeps the limits and the plan to 0.1 arcsec.

    The jerk of the Hermite is a weighted mean of the plan's, so it needs no test.
    """
    return not (
        cells_that_break(profile, rows, limits).size or cells_that_leave(profile, rows).size
    )


def cells_that_break(profile: AxisProfile, rows: int, limits: AxisLimits) -> Indices:
    """Cells between two rows in which the Hermite passes a limit of angle, rate, acceleration."""
    angle, rate = profile.lowest(np.linspace(0.0, profile.duration_s, rows + 1), 2)
    ranges = cubic_range(profile.duration_s / rows, angle[:, None], rate[:, None])
    broken = np.zeros(rows, dtype=bool)
    for (least, greatest), (low, high) in zip(ranges[:3], limits.bounds[:3], strict=True):
        slack = LIMIT_TOLERANCE * (high - low)
        broken |= (greatest[:, 0] > high + slack) | (least[:, 0] < low - slack)
    return np.flatnonzero(broken)


def cells_that_leave(profile: AxisProfile, rows: int) -> Indices:
    """Cells in which the Hermite is more than 0.1 arcsec from the profile."""
    step_s = profile.duration_s / rows
    cells = _cells_in_doubt(profile, rows)
    s = np.arange(1, SAMPLES_PER_ROW) / SAMPLES_PER_ROW
    starts_s = cells.astype(float) * step_s
    angle0, rate0 = profile.lowest(starts_s, 2)
    angle1, rate1 = profile.lowest(starts_s + step_s, 2)
    between = (starts_s[:, None] + s * step_s).ravel()
    planned = profile.lowest(between, 1)[0].reshape(len(cells), len(s))
    h00, h01 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s**2 * (3.0 - 2.0 * s)
    h10, h11 = s * (1.0 - s) ** 2 * step_s, s**2 * (s - 1.0) * step_s
    hermite = (
        np.outer(angle0, h00) + np.outer(angle1, h01) + np.outer(rate0, h10) + np.outer(rate1, h11)
    )
    return np.asarray(cells[(np.abs(hermite - planned) > REPRODUCTION_RAD).any(axis=1)])


def _cells_in_doubt(profile: AxisProfile, rows: int) -> Indices:
    """Cells with a breakpoint inside, and those where the fourth derivative is large.

    Elsewhere the Hermite's error is at most step^4 / 384 of that derivative (de Boor 2001, ch. V).
    """
    step_s = profile.duration_s / rows
    at_row = profile.breakpoints_s / step_s
    begins, ends = np.floor(at_row[:-1] + 1e-9), np.ceil(at_row[1:] - 1e-9)
    inside = np.flatnonzero(np.abs(at_row - np.round(at_row)) > 1e-9)
    powers = np.arange(4, profile.coefficients.shape[1])
    width = np.diff(profile.breakpoints_s)[:, None]
    scale = powers * (powers - 1) * (powers - 2) * (powers - 3)
    fourth = np.abs(profile.coefficients[:, 4:] * scale * width ** (powers - 4)).sum(axis=1)
    doubtful = np.flatnonzero(fourth * step_s**4 / 384.0 > REPRODUCTION_RAD)
    cells = [np.floor(at_row[inside])]
    cells += [np.arange(begins[piece], ends[piece]) for piece in doubtful]
    return np.unique(np.clip(np.concatenate(cells), 0, rows - 1)).astype(np.intp)
