"""How far the telemetry's clock is ahead of the plan's, and how fast it gains, with their errors.

Robust least squares (Huber 1981, sec. 7.8) of all columns together on the table's cubic Hermite.
A time tag is t + offset + drift t, t the seconds since the table's epoch.  What isn't time is not
taken for it: a constant of every column (an encoder's zero, a gyro's bias), and of angles what
friction holds an axis back by, one way or the other, and what a drive lags by under acceleration.
What both axes are late by is the clock's: no telemetry of the axes alone can tell it from a delay
they share.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from planner.arrays import Array, Indices
from planner.telemetry.columns import Kind
from planner.telemetry.motion import PlannedMotion

DRIFT_SIGMA = 1e-3  # before anything is measured: worse ones are no clocks
# Of a column's constant, an angle's friction, and its share of the acceleration, s^2.
_NUISANCE_SIGMA = {
    "angle": (math.radians(1.0), math.radians(0.1), 0.1),
    "rate": (math.radians(0.1),),
}
_CREEP_RAD_S = math.radians(0.01)  # over which friction turns with the motion
_OFFSET_SIGMA_S = 100.0
_HUBER = 2.0  # sigmas; beyond them an error counts by its size, not its square
_ROUNDS_MAX = 40
_SCALE_MIN = 1e-10  # rad: JSON's ninth decimal of a degree is 2e-11
_BLOCKS = 40  # of time: errors within one may go together, and the sigmas tell it
_LATE_SIGMA = 4.0  # an axis is later than the other when it is by more


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One column: tag_s and value, (n,), in radians or rad/s and without gaps."""

    motion: PlannedMotion
    kind: Kind
    tag_s: Array
    value: Array

    def planned(self, t_s: Array) -> tuple[Array, Array]:
        """The value and its rate of change, (n,) each."""
        if self.kind == "angle":
            return self.motion.angle_rad(t_s), self.motion.rate_rad_s(t_s)
        return self.motion.rate_rad_s(t_s), self.motion.acceleration_rad_s2(t_s)

    def nuisance(self, t_s: Array) -> Array:
        """What else the value may be off by, (n, k), each part in its own unit."""
        constant = np.ones(len(t_s))
        if self.kind == "rate":
            return constant[:, None]
        friction = -np.tanh(self.motion.rate_rad_s(t_s) / _CREEP_RAD_S)
        return np.stack([constant, friction, -self.motion.acceleration_rad_s2(t_s)], axis=1)

    @property
    def nuisance_sigma(self) -> tuple[float, ...]:
        """Before anything is measured, (k,)."""
        return _NUISANCE_SIGMA[self.kind]


@dataclass(frozen=True)
class Estimate:
    """With its 1-sigma error."""

    value: float
    sigma: float


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """offset_s, drift: of the telemetry's clock at the table's epoch.  lags_s: by axis, how much
    later it moves than the earlier one of them; None where an axis has no samples.
    """

    offset_s: Estimate
    drift: Estimate
    lags_s: tuple[Estimate | None, ...]

    def t_s(self, tag_s: Array) -> Array:
        """Seconds after the table's epoch at time tags."""
        return np.asarray((tag_s - self.offset_s.value) / (1.0 + self.drift.value))


@dataclass(frozen=True, eq=False)
class _Fit:
    """parameters: offset, drift, then each channel's own.  covariance_parameters: of them."""

    parameters: Array
    covariance_parameters: Array


def align(channels: Sequence[Channel], start_offset_s: float, axes: int) -> Alignment:
    """Offset and drift that the channels share, and how much later one axis is."""
    starts = dict.fromkeys((start_offset_s, 0.0))
    fit = min((_fit(channels, start) for start in starts), key=lambda one: _cost(channels, one))
    return _with_lags(channels, fit, axes)


def _with_lags(channels: Sequence[Channel], fit: _Fit, axes: int) -> Alignment:
    """The axes one by one: a drive may be late and never early."""
    offset, drift = fit.parameters[:2]
    sigma_s, drift_sigma = np.sqrt(np.diag(fit.covariance_parameters)[:2])
    late: list[Estimate | None] = []
    for axis in range(axes):
        own = [channel for channel in channels if channel.motion.axis == axis]
        late.append(_late(own, fit) if own else None)
    known = [one for one in late if one is not None]
    first_s = min(one.value for one in known)
    spread_s = max(one.value for one in known) - first_s
    if spread_s > _LATE_SIGMA * math.hypot(*(one.sigma for one in known)):
        sigma_s = max(sigma_s, min(known, key=lambda one: one.value).sigma)
        offset += first_s
        late = [one and replace(one, value=one.value - first_s) for one in late]
    return Alignment(
        offset_s=Estimate(float(offset), float(sigma_s)),
        drift=Estimate(float(drift), float(drift_sigma)),
        lags_s=tuple(late),
    )


def _late(own: Sequence[Channel], fit: _Fit) -> Estimate:
    """Against the offset of all, their drift taken as it is."""
    fixed = [
        replace(channel, tag_s=(channel.tag_s - fit.parameters[0]) / (1.0 + fit.parameters[1]))
        for channel in own
    ]
    alone = _fit(fixed, 0.0, drift_sigma=1e-12)
    return Estimate(float(alone.parameters[0]), float(np.sqrt(alone.covariance_parameters[0, 0])))


def _fit(
    channels: Sequence[Channel], start_offset_s: float, drift_sigma: float = DRIFT_SIGMA
) -> _Fit:
    nuisance_sigma = [sigma for channel in channels for sigma in channel.nuisance_sigma]
    prior_weights = 1.0 / np.array([_OFFSET_SIGMA_S, drift_sigma, *nuisance_sigma]) ** 2
    parameters = np.zeros(len(prior_weights))
    parameters[0] = start_offset_s
    places = _places(channels)
    for channel, columns in zip(channels, places, strict=True):
        off, _ = _residual(channel, parameters, columns)
        parameters[columns[2]] = np.median(off) if len(off) else 0.0
    scale_by_channel = np.full(len(channels), np.inf)
    for _ in range(_ROUNDS_MAX):
        normal, right_parameters = np.diag(prior_weights), -prior_weights * parameters
        right_parameters[0] = 0.0  # nothing is known of the offset beforehand
        for number, (channel, columns) in enumerate(zip(channels, places, strict=True)):
            residual, slope = _residual(channel, parameters, columns)
            scale_by_channel[number] = _scale(residual)
            weighted = _weight(residual, scale_by_channel[number])[:, None] * slope
            normal[np.ix_(columns, columns)] += weighted.T @ slope
            right_parameters[columns] += weighted.T @ residual
        step = _solve(normal, right_parameters)
        parameters = parameters + step
        if abs(step[0]) < 1e-9 and abs(step[1]) < 1e-13:
            break
    return _Fit(parameters, _covariance(channels, parameters, scale_by_channel, prior_weights))


def _places(channels: Sequence[Channel]) -> list[Indices]:
    """Of each channel the parameters it hangs on: the clock's, then its own."""
    ends = 2 + np.cumsum([0, *(len(channel.nuisance_sigma) for channel in channels)])
    return [np.array([0, 1, *range(first, last)]) for first, last in pairwise(ends.tolist())]


def _residual(channel: Channel, parameters: Array, columns: Indices) -> tuple[Array, Array]:
    """What is left of the rows within the table, and by what it falls, (n, k)."""
    t_s = (channel.tag_s - parameters[0]) / (1.0 + parameters[1])
    inside = channel.motion.is_within(t_s)
    t_s = t_s[inside]
    planned, change = channel.planned(t_s)
    nuisance = channel.nuisance(t_s)
    slope = np.column_stack([-change, -change * t_s, nuisance])
    return channel.value[inside] - planned - nuisance @ parameters[columns[2:]], slope


def _scale(error: Array) -> float:
    if not len(error):
        return 1.0
    middle = np.median(error)
    return max(1.4826 * float(np.median(np.abs(error - middle))), _SCALE_MIN)


def _weight(error: Array, scale: float) -> Array:
    """Huber's, over the scale squared."""
    size = np.abs(error) / scale
    return np.asarray(np.minimum(1.0, _HUBER / np.maximum(size, 1e-300)) / scale**2)


def _solve(normal: Array, right_parameters: Array) -> Array:
    unit = np.sqrt(np.diag(normal))
    return np.asarray(
        np.linalg.solve(normal / np.outer(unit, unit), right_parameters / unit) / unit
    )


def _covariance(
    channels: Sequence[Channel], parameters: Array, scale_by_channel: Array, prior_weights: Array
) -> Array:
    """Of white errors, or of errors that go together within a block of time where that is more.

    Source: Huber 1981, sec. 7.6; blocks as clusters: Liang and Zeger 1986, eq. 6.
    """
    normal = np.diag(prior_weights)
    scores = np.zeros((_BLOCKS, len(parameters)))
    spread = np.zeros_like(normal)
    for channel, columns, scale in zip(channels, _places(channels), scale_by_channel, strict=True):
        residual, slope = _residual(channel, parameters, columns)
        if not len(residual):
            continue
        weight = _weight(residual, float(scale))
        normal[np.ix_(columns, columns)] += slope.T @ (weight[:, None] * slope)
        score = (weight * residual)[:, None] * slope
        spread[np.ix_(columns, columns)] += score.T @ score
        block = np.arange(len(residual)) * _BLOCKS // len(residual)
        first = np.searchsorted(block, np.unique(block))
        scores[np.ix_(np.unique(block), columns)] += np.add.reduceat(score, first, axis=0)
    unit = 1.0 / np.sqrt(np.diag(normal))
    inverse = np.linalg.inv(normal * np.outer(unit, unit)) * np.outer(unit, unit)
    together = scores.T @ scores * _BLOCKS / (_BLOCKS - 3.0)
    white, clustered = (
        inverse @ (np.diag(prior_weights) + middle) @ inverse for middle in (spread, together)
    )
    return white if white[0, 0] > clustered[0, 0] else clustered


def _cost(channels: Sequence[Channel], fit: _Fit) -> float:
    """Mean error by its size, rows outside the table as a whole motion off."""
    total, rows = 0.0, 0
    for channel, columns in zip(channels, _places(channels), strict=True):
        residual, _ = _residual(channel, fit.parameters, columns)
        planned, _ = channel.planned(channel.tag_s)
        room = max(float(np.std(planned)), _SCALE_MIN)
        inside = float(np.sum(np.minimum(np.abs(residual) / room, 1.0)))
        total += inside + 0.5 * (len(channel.tag_s) - len(residual))
        rows += len(channel.tag_s)
    return total / max(rows, 1)
