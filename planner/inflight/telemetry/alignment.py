"""The telemetry clock's offset and drift from the plan's, with their errors.

Robust least squares (Huber 1981, sec. 7.8) of all columns together on the table's cubic Hermite.
A time tag is t + offset + drift t, t the seconds since the table's epoch.  What isn't time is not
taken for it: a constant of every column (an encoder's zero, a gyro's bias), and of angles what
friction holds an axis back by, one way or the other, and what a drive lags by under acceleration.
What both axes are late by is the clock's: no telemetry of the axes alone can tell it from a delay
they share.  A drive may be late and never early: the clock's offset is that of the earlier axis.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import ndtr

from planner.base.arrays import Array, Indices
from planner.inflight.telemetry.columns import Kind
from planner.inflight.telemetry.motion import PlannedMotion


@dataclass(frozen=True, kw_only=True)
class AlignmentOptions:
    """How a clock's offset, drift and lag are fitted, and when a lag is told."""

    drift_sigma: float = 1e-3  # before anything is measured: worse ones are no clocks
    creep_rad_s: float = math.radians(0.01)  # over which friction turns with the motion
    offset_sigma_s: float = 100.0  # before anything is measured: as good as unknown
    huber: float = 2.0  # sigmas; beyond them an error counts by its size, not its square
    rounds_max: int = 40  # of reweighting
    scale_min: float = 1e-10  # rad: JSON's ninth decimal of a degree is 2e-11
    blocks: int = 40  # of time: errors within one may go together, and the sigmas tell it
    late_sigma: float = 4.0  # an axis is later than the other when it is by more
    # Times what is not known of a lag: the mean square of the offset's error over its sigma is at
    # most 1.3 at any lag, in the mean of many noises; 1.9 without.
    lag_room: float = 1.25
    lag_sigma_max_s: float = 1.0  # no drive is so late: an axis known worse tells nothing of it


OPTIONS = AlignmentOptions()

# Of a column's constant, an angle's friction, and its share of the acceleration, s^2.
_NUISANCE_SIGMA = {
    "angle": (math.radians(1.0), math.radians(0.1), 0.1),
    "rate": (math.radians(0.1),),
}


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
        friction = -np.tanh(self.motion.rate_rad_s(t_s) / OPTIONS.creep_rad_s)
        return np.stack([constant, friction, -self.motion.acceleration_rad_s2(t_s)], axis=1)

    @property
    def nuisance_sigma(self) -> tuple[float, ...]:
        """Before anything is measured, (k,)."""
        return _NUISANCE_SIGMA[self.kind]


@dataclass(frozen=True)
class ClockEstimate:
    """With its 1-sigma error."""

    value: float
    sigma: float


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """offset_s, drift: of the telemetry's clock at the table's epoch.  common_offset_s: the same if
    both axes are equally late; None where they clearly aren't, or one tells no time.
    lags_s: by axis, how much later it moves than the earlier one of them, with the error of the
    difference; None where it tells no time.  reference_offset_s, reference_gain: those that the
    axes' errors are taken with.
    """

    offset_s: ClockEstimate
    drift: ClockEstimate
    common_offset_s: ClockEstimate | None
    lags_s: tuple[ClockEstimate | None, ...]
    reference_offset_s: float
    reference_gain: float

    def t_s(self, tag_s: Array) -> Array:
        """Seconds after the table's epoch at time tags."""
        return np.asarray((tag_s - self.reference_offset_s) / (1.0 + self.reference_gain))


@dataclass(frozen=True, eq=False)
class _Fit:
    """parameters: drift, the offsets, then each channel's own.  covariance_parameters: of them."""

    parameters: Array
    covariance_parameters: Array

    def estimate(self, place: int) -> ClockEstimate:
        """Of a parameter by itself."""
        sigma = math.sqrt(self.covariance_parameters[place, place])
        return ClockEstimate(float(self.parameters[place]), sigma)


def align(channels: Sequence[Channel], start_offset_s: float, axes: int) -> Alignment:
    """Offset and drift that the channels share, and how much later one axis is.

    Where the axes clearly differ, the offset is that of the earlier one; else the one that suits
    both, and its sigma holds that either may be the earlier by what is not known of their
    difference: nothing is known of lags beforehand.  The drift suits the axes with an offset each.
    """
    starts = dict.fromkeys((start_offset_s, 0.0))
    shared = min((_fit(channels, start) for start in starts), key=lambda one: _cost(channels, one))
    told = sorted({channel.motion.axis for channel in channels})
    each = _fit(channels, float(shared.parameters[1]), told) if len(told) > 1 else shared
    own_s = [each.estimate(1 + place) for place in range(len(told))]
    lag_s = _lag_s(each) if len(told) > 1 else None
    lags_s: list[ClockEstimate | None] = [None] * axes
    if lag_s is None or lag_s.sigma > OPTIONS.lag_sigma_max_s:
        best = min(range(len(told)), key=lambda place: own_s[place].sigma)
        lags_s[told[best]] = ClockEstimate(0.0, own_s[best].sigma)
        offset_s, reference, common_s = shared.estimate(1), shared, None
    else:
        first = int(own_s[1].value < own_s[0].value)
        lags_s[told[first]] = ClockEstimate(0.0, lag_s.sigma)
        lags_s[told[1 - first]] = lag_s
        if lag_s.value > OPTIONS.late_sigma * lag_s.sigma:
            offset_s, reference, common_s = own_s[first], each, None
        else:
            common_s = shared.estimate(1)
            offset_s, reference = (
                ClockEstimate(common_s.value, _earlier_sigma(each, common_s)),
                shared,
            )
    return Alignment(
        offset_s=offset_s,
        drift=each.estimate(0),
        common_offset_s=common_s,
        lags_s=tuple(lags_s),
        reference_offset_s=offset_s.value,
        reference_gain=float(reference.parameters[0]),
    )


def _lag_s(each: _Fit) -> ClockEstimate:
    """By how much the offsets of two axes differ."""
    ends = np.array([1.0, -1.0])
    variance_s2 = float(ends @ each.covariance_parameters[1:3, 1:3] @ ends)
    return ClockEstimate(abs(float(ends @ each.parameters[1:3])), math.sqrt(variance_s2))


def _earlier_sigma(each: _Fit, told: ClockEstimate) -> float:
    """Rms error of an offset that is told for the earlier of two axes, of which each is known as
    the fit has it.  Source: moments of the least of two normal variables, Clark 1961, eqs. 2-4."""
    apart_s = OPTIONS.lag_room * _lag_s(each).sigma
    first, second = each.parameters[1:3] - told.value
    variance_s2 = OPTIONS.lag_room**2 * each.covariance_parameters
    later = (second - first) / apart_s
    is_first = float(ndtr(later))
    squares_s2 = (
        (first**2 + variance_s2[1, 1]) * is_first
        + (second**2 + variance_s2[2, 2]) * (1.0 - is_first)
        - (first + second) * apart_s * math.exp(-0.5 * later**2) / math.sqrt(2.0 * math.pi)
    )
    return max(math.sqrt(max(squares_s2, 0.0)), told.sigma)


def _fit(
    channels: Sequence[Channel], start_offset_s: float, axes_apart: Sequence[int] = ()
) -> _Fit:
    """axes_apart: those that have an offset each; none: all share one."""
    nuisance_sigma = [sigma for channel in channels for sigma in channel.nuisance_sigma]
    clocks = max(len(axes_apart), 1)
    offset_sigmas_s = [OPTIONS.offset_sigma_s] * clocks
    prior_weights = 1.0 / np.array([OPTIONS.drift_sigma, *offset_sigmas_s, *nuisance_sigma]) ** 2
    parameters = np.zeros(len(prior_weights))
    parameters[1 : 1 + clocks] = start_offset_s
    places = _places(channels, axes_apart)
    for channel, columns in zip(channels, places, strict=True):
        off, _ = _residual(channel, parameters, columns)
        parameters[columns[2]] = np.median(off) if len(off) else 0.0
    scale_by_channel = np.full(len(channels), np.inf)
    for _ in range(OPTIONS.rounds_max):
        normal, right_parameters = np.diag(prior_weights), -prior_weights * parameters
        right_parameters[1 : 1 + clocks] = 0.0  # nothing is known of offsets beforehand
        for number, (channel, columns) in enumerate(zip(channels, places, strict=True)):
            residual, slope = _residual(channel, parameters, columns)
            scale_by_channel[number] = _scale(residual)
            weighted = _weight(residual, scale_by_channel[number])[:, None] * slope
            normal[np.ix_(columns, columns)] += weighted.T @ slope
            right_parameters[columns] += weighted.T @ residual
        step = _solve(normal, right_parameters)
        parameters = parameters + step
        if abs(step[0]) < 1e-13 and np.abs(step[1 : 1 + clocks]).max() < 1e-9:
            break
    covariance = _covariance(channels, places, parameters, scale_by_channel, prior_weights)
    return _Fit(parameters, covariance)


def _places(channels: Sequence[Channel], axes_apart: Sequence[int] = ()) -> list[Indices]:
    """Of each channel the parameters it hangs on: drift and offset, then its own."""
    counts = [len(channel.nuisance_sigma) for channel in channels]
    ends = 1 + max(len(axes_apart), 1) + np.cumsum([0, *counts])
    return [
        np.array([0, 1 + (axes_apart.index(channel.motion.axis) if axes_apart else 0), *own])
        for channel, own in zip(channels, (range(*e) for e in pairwise(ends.tolist())), strict=True)
    ]


def _residual(channel: Channel, parameters: Array, columns: Indices) -> tuple[Array, Array]:
    """What is left of the rows within the table, and by what it falls, (n, k)."""
    drift, offset_s = parameters[columns[:2]]
    t_s = (channel.tag_s - offset_s) / (1.0 + drift)
    inside = channel.motion.is_within(t_s)
    t_s = t_s[inside]
    planned, change = channel.planned(t_s)
    nuisance = channel.nuisance(t_s)
    slope = np.column_stack([-change * t_s, -change, nuisance])
    return channel.value[inside] - planned - nuisance @ parameters[columns[2:]], slope


def _scale(error: Array) -> float:
    if not len(error):
        return 1.0
    middle = np.median(error)
    return max(1.4826 * float(np.median(np.abs(error - middle))), OPTIONS.scale_min)


def _weight(error: Array, scale: float) -> Array:
    """Huber's, over the scale squared."""
    size = np.abs(error) / scale
    return np.asarray(np.minimum(1.0, OPTIONS.huber / np.maximum(size, 1e-300)) / scale**2)


def _solve(normal: Array, right_parameters: Array) -> Array:
    unit = np.sqrt(np.diag(normal))
    return np.asarray(
        np.linalg.solve(normal / np.outer(unit, unit), right_parameters / unit) / unit
    )


def _covariance(
    channels: Sequence[Channel],
    places: Sequence[Indices],
    parameters: Array,
    scale_by_channel: Array,
    prior_weights: Array,
) -> Array:
    """Of white errors, or of errors that go together within a block of time where that is more.

    Source: Huber 1981, sec. 7.6; blocks as clusters: Liang and Zeger 1986, eq. 6.
    """
    normal = np.diag(prior_weights)
    scores = np.zeros((OPTIONS.blocks, len(parameters)))
    spread = np.zeros_like(normal)
    for channel, columns, scale in zip(channels, places, scale_by_channel, strict=True):
        residual, slope = _residual(channel, parameters, columns)
        if not len(residual):
            continue
        weight = _weight(residual, float(scale))
        normal[np.ix_(columns, columns)] += slope.T @ (weight[:, None] * slope)
        score = (weight * residual)[:, None] * slope
        spread[np.ix_(columns, columns)] += score.T @ score
        block = np.arange(len(residual)) * OPTIONS.blocks // len(residual)
        first = np.searchsorted(block, np.unique(block))
        scores[np.ix_(np.unique(block), columns)] += np.add.reduceat(score, first, axis=0)
    unit = 1.0 / np.sqrt(np.diag(normal))
    inverse = np.linalg.inv(normal * np.outer(unit, unit)) * np.outer(unit, unit)
    together = scores.T @ scores * OPTIONS.blocks / (OPTIONS.blocks - 3.0)
    white, clustered = (
        inverse @ (np.diag(prior_weights) + middle) @ inverse for middle in (spread, together)
    )
    grown = np.sqrt(np.maximum(np.diag(white) / np.diag(clustered), 1.0))
    return np.asarray(clustered * np.outer(grown, grown))


def _cost(channels: Sequence[Channel], fit: _Fit) -> float:
    """Mean error by its size, rows outside the table as a whole motion off."""
    total, rows = 0.0, 0
    for channel, columns in zip(channels, _places(channels), strict=True):
        residual, _ = _residual(channel, fit.parameters, columns)
        planned, _ = channel.planned(channel.tag_s)
        room = max(float(np.std(planned)), OPTIONS.scale_min)
        inside = float(np.sum(np.minimum(np.abs(residual) / room, 1.0)))
        total += inside + 0.5 * (len(channel.tag_s) - len(residual))
        rows += len(channel.tag_s)
    return total / max(rows, 1)
