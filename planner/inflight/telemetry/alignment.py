"""The telemetry's clock, and the gain and bias of every column, with their errors.

Robust least squares (Huber 1981, sec. 7.8) of all columns together on the table's cubic Hermite.
A time tag is t + offset + drift t, t the seconds since the table's epoch.  What isn't time is not
taken for it: a column's gain and bias (an encoder's scale and zero, a gyro's), and of angles what
friction holds an axis back by, one way or the other, and what a drive lags by under acceleration.
What all axes are late by is the clock's: no telemetry of the axes alone can tell it from a delay
they share.  An axis may be late and never early: the clock's offset is that of the earliest axis.
An attitude about a body's axis has neither gain nor friction.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
from scipy.special import ndtr

from planner.base.arrays import Array, Indices
from planner.inflight.telemetry.error_spectrum import fit_spectrum, mean_power
from planner.inflight.telemetry.estimates import Estimate, Inseparable
from planner.inflight.telemetry.following import PlannedMotion
from planner.inflight.telemetry.samples import Kind


@dataclass(frozen=True, kw_only=True)
class AlignmentOptions:
    """How clock, gains and biases are fitted, and when a lag is told.

    The sigmas are those before anything is measured.
    """

    drift_sigma: float = 1e-3  # worse ones are no clocks
    offset_sigma_s: float = 100.0  # as good as unknown
    gain_sigma: float = 0.3  # what differs by more isn't told to follow its plan
    bias_sigma_rad: float = math.radians(1.0)
    bias_sigma_rad_s: float = math.radians(0.1)
    friction_sigma_rad: float = math.radians(0.1)
    late_sigma_s2: float = 0.1  # of an angle's share of the acceleration
    creep_rad_s: float = math.radians(0.01)  # over which friction turns with the motion
    huber: float = 2.0  # sigmas; beyond them an error counts by its size, not its square
    rounds_max: int = 40  # of reweighting,
    settled: float = 1e-8  # or until a round's step is this, in sigmas squared
    scale_min: float = 1e-10  # rad: JSON's ninth decimal of a degree is 2e-11
    blocks: int = 40  # of time: errors within one may go together, and the sigmas tell it
    # An axis is later than the other when it is by more: 1 in 20,000 by chance, as sigmas of 40
    # blocks are themselves known to a ninth (Student's t).
    late_sigma: float = 4.6
    # Times what is not known of a lag: the mean square of the offset's error over its sigma is at
    # most 1.3 at any lag, in the mean of many noises; 1.9 without.
    lag_room: float = 1.25
    poor: float = 0.05  # mean error, as a share of the motion, with which no offset is tried, too
    lag_sigma_max_s: float = 1.0  # no drive is so late: an axis known worse tells nothing of it
    seen_sigma: float = 3.0  # friction, lag and gain that are less leave the ideal clock standing
    taken_max: float = 0.9  # share of an error's power that a fit is taken to have taken, at most
    inseparable: float = 0.98  # correlation: either sigma is five times what the other known makes


OPTIONS = AlignmentOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class AlignedColumn:
    """One column: tag_s and value, (n,), in radians or rad/s and without gaps."""

    motion: PlannedMotion
    kind: Kind
    tag_s: Array
    value: Array

    @property
    def has_gain(self) -> bool:
        """Whether a sensor may measure it larger or smaller; an attitude's can't."""
        return self.kind == "rate" or self.motion.has_drive

    def gain_above_one(self, parameters: Array, columns: Indices) -> float:
        """Of a fit's parameters, at this one's places; zero where none is estimated."""
        return float(parameters[columns[3]]) if self.has_gain and len(columns) > 3 else 0.0

    def planned(self, t_s: Array) -> tuple[Array, Array]:
        """The value and its rate of change, (n,) each."""
        if self.kind == "angle":
            return self.motion.angle_rad(t_s), self.motion.rate_rad_s(t_s)
        return self.motion.rate_rad_s(t_s), self.motion.acceleration_rad_s2(t_s)

    def nuisance(self, t_s: Array, is_ideal: bool) -> Array:
        """What else the value may be off by, (n, k), each part in its own unit: bias, and of axes
        that aren't ideal the gain above one, friction and the share of the acceleration."""
        constant = np.ones(len(t_s))
        if is_ideal:
            return constant[:, None]
        if self.kind == "rate":
            return np.stack([constant, self.motion.rate_rad_s(t_s)], axis=1)
        late = -self.motion.acceleration_rad_s2(t_s)
        if not self.has_gain:
            return np.stack([constant, late], axis=1)
        rate_rad_s = self.motion.rate_rad_s(t_s)
        friction = -np.tanh(rate_rad_s / OPTIONS.creep_rad_s)
        return np.stack([constant, self.motion.angle_rad(t_s), friction, late], axis=1)

    def nuisance_sigma(self, is_ideal: bool) -> tuple[float, ...]:
        """Before anything is measured, (k,)."""
        is_angle = self.kind == "angle"
        bias = OPTIONS.bias_sigma_rad if is_angle else OPTIONS.bias_sigma_rad_s
        if is_ideal:
            return (bias,)
        if not self.has_gain:
            return (bias, OPTIONS.late_sigma_s2)
        drive = (OPTIONS.friction_sigma_rad, OPTIONS.late_sigma_s2) if is_angle else ()
        return (bias, OPTIONS.gain_sigma, *drive)


@dataclass(frozen=True, kw_only=True)
class ColumnScale:
    """A column is its gain times the plan's value, plus its bias [rad, or rad/s].  gain: None of
    what has none."""

    axis: int
    kind: Kind
    gain: Estimate | None
    bias: Estimate


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """offset_s, drift: of the telemetry's clock at the table's epoch.  common_offset_s: the same if
    all axes are equally late; None where they clearly aren't, or only one tells the time.
    earliest: axis than which none is clearly earlier, the best known of these.  lags_s: by axis,
    how much later it moves than that, with the error of the difference; None where it tells no
    time.  scales: of the columns that tell the time.
    reference_offset_s, reference_drift_share: those that the axes' errors are taken with.
    """

    offset_s: Estimate
    drift: Estimate
    common_offset_s: Estimate | None
    earliest: int
    lags_s: tuple[Estimate | None, ...]
    scales: tuple[ColumnScale, ...]
    fit: "Fit"
    reference_offset_s: float
    reference_drift_share: float

    def by(self, fit: "Fit") -> "Alignment":
        """The same, with the axes' errors taken with a fit's clock."""
        drift, offset_s = fit.parameters[:2].tolist()
        return replace(self, reference_offset_s=offset_s, reference_drift_share=drift)

    def t_s(self, tag_s: Array) -> Array:
        """Seconds after the table's epoch at time tags."""
        return np.asarray((tag_s - self.reference_offset_s) / (1.0 + self.reference_drift_share))


@dataclass(frozen=True, eq=False)
class Fit:
    """parameters: drift, the offsets, then each channel's own.  covariances_parameters: of them,
    by the errors' spectra and by their blocks.  places: by channel."""

    channels: tuple[AlignedColumn, ...]
    axes_apart: tuple[int, ...]
    parameters: Array
    covariances_parameters: tuple[Array, Array]
    places: tuple[Indices, ...]

    def estimate(self, place: int, less: int | None = None) -> Estimate:
        """Of a parameter by itself, or less another one.

        The larger of both variances: of a difference, too, as the correlations of few blocks
        scatter and make it small by chance.
        """
        weights = np.zeros(len(self.parameters))
        weights[place] = 1.0
        if less is not None:
            weights[less] = -1.0
        variance = max(float(weights @ one @ weights) for one in self.covariances_parameters)
        return Estimate(value=float(weights @ self.parameters), sigma=math.sqrt(variance))

    def parts(self) -> dict[tuple[int, Kind], tuple[float, float]]:
        """By axis and kind what a gain is above one by, and a bias."""
        return {
            (channel.motion.axis, channel.kind): (
                channel.gain_above_one(self.parameters, columns),
                float(self.parameters[columns[2]]),
            )
            for channel, columns in zip(self.channels, self.places, strict=True)
        }

    def scales(self) -> tuple[ColumnScale, ...]:
        """Of each channel."""
        found = []
        for channel, columns in zip(self.channels, self.places, strict=True):
            above = self.estimate(columns[3]) if channel.has_gain else None
            found.append(
                ColumnScale(
                    axis=channel.motion.axis,
                    kind=channel.kind,
                    gain=replace(above, value=1.0 + above.value) if above else None,
                    bias=self.estimate(columns[2]),
                )
            )
        return tuple(found)


def align(channels: Sequence[AlignedColumn], start_offset_s: float, axes: int) -> Alignment:
    """Offset and drift that the channels share, and how much later some axes are.

    Where axes clearly differ, the offset is that of the earliest one; else the one that suits
    all, and its sigma holds that any may be the earliest by what is not known of their
    differences: nothing is known of lags beforehand.  The drift suits the axes with an offset each.
    """
    shared = _fit(channels, start_offset_s)
    if _cost(channels, shared) > OPTIONS.poor:
        shared = min(shared, _fit(channels, 0.0), key=lambda one: _cost(channels, one))
    told = sorted({channel.motion.axis for channel in channels})
    each = _fit(channels, float(shared.parameters[1]), told) if len(told) > 1 else shared
    own_s = [each.estimate(1 + place) for place in range(len(told))]
    best = min(range(len(told)), key=lambda place: own_s[place].sigma)
    known = [
        place
        for place in range(len(told))
        if place == best or _lag_s(each, place, best).sigma <= OPTIONS.lag_sigma_max_s
    ]
    lags_s: list[Estimate | None] = [None] * axes
    if len(known) == 1:
        first = best
        lags_s[told[best]] = Estimate(value=0.0, sigma=own_s[best].sigma)
        offset_s, reference, common_s = shared.estimate(1), shared, None
    else:
        # None is clearly earlier than these; of them the lags are told behind the best known, as
        # the earliest by chance may be one of which little is known.
        earliest = [
            place
            for place in known
            if not any(is_late(_lag_s(each, place, than)) for than in known if than != place)
        ]
        first = min(earliest, key=lambda place: own_s[place].sigma)
        lag_s = {place: _lag_s(each, place, first) for place in known if place != first}
        lags_s[told[first]] = Estimate(value=0.0, sigma=min(one.sigma for one in lag_s.values()))
        for place, one in lag_s.items():
            lags_s[told[place]] = one
        near = [place for place in lag_s if place in earliest]
        if len(near) < len(lag_s):
            offset_s, reference, common_s = own_s[first], each, None
        else:
            common_s = offset_s = shared.estimate(1)
            reference = shared
        # Of many the earliest is less known than of any two.
        sigmas_s = [_earlier_sigma(each, offset_s, first, place) for place in near]
        offset_s = replace(offset_s, sigma=max([offset_s.sigma, *sigmas_s]))
    return Alignment(
        offset_s=offset_s,
        drift=each.estimate(0),
        common_offset_s=common_s,
        earliest=told[first],
        lags_s=tuple(lags_s),
        scales=each.scales(),
        fit=each,
        reference_offset_s=offset_s.value,
        reference_drift_share=float(reference.parameters[0]),
    )


def _lag_s(each: Fit, place: int, than: int) -> Estimate:
    """By how much an axis is later than another."""
    return each.estimate(1 + place, less=1 + than)


def _earlier_sigma(each: Fit, told: Estimate, place: int, other: int) -> float:
    """Rms error of an offset that is told for the earlier of two axes, of which each is known as
    the fit has it.  Source: moments of the least of two normal variables, Clark 1961, eqs. 2-4."""
    apart_s = OPTIONS.lag_room * _lag_s(each, place, other).sigma
    pair = [1 + min(place, other), 1 + max(place, other)]
    first, second = each.parameters[pair] - told.value
    sigmas_s = np.array([each.estimate(one).sigma for one in pair])
    first_s2, second_s2 = (OPTIONS.lag_room * sigmas_s) ** 2
    later = (second - first) / apart_s
    is_first = float(ndtr(later))
    squares_s2 = (
        (first**2 + first_s2) * is_first
        + (second**2 + second_s2) * (1.0 - is_first)
        - (first + second) * apart_s * math.exp(-0.5 * later**2) / math.sqrt(2.0 * math.pi)
    )
    return max(math.sqrt(max(squares_s2, 0.0)), told.sigma)


def is_late(lag_s: Estimate) -> bool:
    """Whether an axis is clearly later."""
    return lag_s.value > OPTIONS.late_sigma * lag_s.sigma


def ideal_fit(alignment: Alignment) -> Fit | None:
    """The clock if the axes do as they are told, which is sharper: no friction, lag or gain, but
    for a bias.  None where the samples show any of these."""
    fit = alignment.fit
    shown = [fit.estimate(place) for columns in fit.places for place in columns[3:]]
    lags_s = [lag_s for lag_s in alignment.lags_s if lag_s is not None]
    if any(abs(one.value) > OPTIONS.seen_sigma * one.sigma for one in (*shown, *lags_s)):
        return None
    return _fit(fit.channels, alignment.offset_s.value, is_ideal=True)


def inseparable(alignment: Alignment, names: Sequence[str]) -> list[Inseparable]:
    """Of clock, lag, gains and biases those that the samples don't tell apart."""
    fit = alignment.fit
    told = {"clock_drift": {0: 1.0}, "time_offset_s": {1: 1.0}}
    if len(fit.axes_apart) > 1:
        first = 1 + fit.axes_apart.index(alignment.earliest)
        told["time_offset_s"] = {first: 1.0}
        for place, axis in enumerate(fit.axes_apart, start=1):
            if place != first:
                told[f"axes.{names[axis]}.lag_s"] = {place: 1.0, first: -1.0}
    for channel, columns in zip(fit.channels, fit.places, strict=True):
        name = f"axes.{names[channel.motion.axis]}"
        if f"{name}.bias" in told:  # an angle's, where there are rates besides
            continue
        if channel.has_gain:
            told[f"{name}.gain"] = {columns[3]: 1.0}
        told[f"{name}.bias"] = {columns[2]: 1.0}
    parts = np.zeros((len(told), len(fit.parameters)))
    for row, weights in zip(parts, told.values(), strict=True):
        row[[*weights]] = [*weights.values()]
    covariance = parts @ fit.covariances_parameters[1] @ parts.T
    sigma = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(sigma, sigma)
    return [
        Inseparable(names=(a, b), correlation=float(correlation[i, j]))
        for (i, a), (j, b) in combinations(enumerate(told), 2)
        if abs(correlation[i, j]) > OPTIONS.inseparable
    ]


def _fit(
    channels: Sequence[AlignedColumn],
    start_offset_s: float,
    axes_apart: Sequence[int] = (),
    *,
    is_ideal: bool = False,
) -> Fit:
    """axes_apart: those that have an offset each; none: all share one."""
    nuisance_sigma = [one for channel in channels for one in channel.nuisance_sigma(is_ideal)]
    clocks = max(len(axes_apart), 1)
    offset_sigmas_s = [OPTIONS.offset_sigma_s] * clocks
    prior_weights = 1.0 / np.array([OPTIONS.drift_sigma, *offset_sigmas_s, *nuisance_sigma]) ** 2
    parameters = np.zeros(len(prior_weights))
    parameters[1 : 1 + clocks] = start_offset_s
    places = _places(channels, axes_apart, is_ideal)
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
        if step @ normal @ step < OPTIONS.settled:
            break
    covariances = _covariances(channels, places, parameters, scale_by_channel, prior_weights)
    return Fit(tuple(channels), tuple(axes_apart), parameters, covariances, tuple(places))


def _places(
    channels: Sequence[AlignedColumn], axes_apart: Sequence[int], is_ideal: bool
) -> list[Indices]:
    """Of each channel the parameters it hangs on: drift and offset, then its own."""
    counts = [len(channel.nuisance_sigma(is_ideal)) for channel in channels]
    ends = 1 + max(len(axes_apart), 1) + np.cumsum([0, *counts])
    return [
        np.array([0, 1 + (axes_apart.index(channel.motion.axis) if axes_apart else 0), *own])
        for channel, own in zip(channels, (range(*e) for e in pairwise(ends.tolist())), strict=True)
    ]


def _residual(channel: AlignedColumn, parameters: Array, columns: Indices) -> tuple[Array, Array]:
    """What is left of the rows within the table, and by what it falls, (n, k)."""
    drift, offset_s = parameters[columns[:2]]
    t_s = (channel.tag_s - offset_s) / (1.0 + drift)
    inside = channel.motion.is_within(t_s)
    t_s = t_s[inside]
    planned, change = channel.planned(t_s)
    nuisance = channel.nuisance(t_s, is_ideal=len(columns) == 3)
    gain = 1.0 + channel.gain_above_one(parameters, columns)
    slope = np.column_stack([-gain * change * t_s, -gain * change, nuisance])
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


def _covariances(
    channels: Sequence[AlignedColumn],
    places: Sequence[Indices],
    parameters: Array,
    scale_by_channel: Array,
    prior_weights: Array,
) -> tuple[Array, Array]:
    """Of white errors, or of a body's attitude and rates of errors that wander in time, alike
    throughout; and of errors that go together within a block of time.

    Source: Huber 1981, sec. 7.6; blocks as clusters: Liang and Zeger 1986, eq. 6.
    """
    normal = np.diag(prior_weights)
    errors: list[tuple[Array, Array]] = []  # weighted, and by what they fall
    for channel, columns, scale in zip(channels, places, scale_by_channel, strict=True):
        residual, slope = _residual(channel, parameters, columns)
        weight = _weight(residual, float(scale))
        normal[np.ix_(columns, columns)] += slope.T @ (weight[:, None] * slope)
        errors.append((weight * residual, slope))
    unit = 1.0 / np.sqrt(np.diag(normal))
    inverse = np.linalg.inv(normal * np.outer(unit, unit)) * np.outer(unit, unit)
    scores = np.zeros((OPTIONS.blocks, len(parameters)))
    spread = np.zeros_like(normal)
    for channel, columns, scale, (error, slope) in zip(
        channels, places, scale_by_channel, errors, strict=True
    ):
        if not len(error):
            continue
        score = error[:, None] * slope
        if channel.motion.has_drive:
            spread[np.ix_(columns, columns)] += score.T @ score
        else:
            taken = inverse[np.ix_(columns, columns)] / float(scale) ** 2
            step_s = float(np.median(np.diff(channel.tag_s)))
            spread[np.ix_(columns, columns)] += slope.T @ _wandering(error, slope, taken, step_s)
        block = np.arange(len(error)) * OPTIONS.blocks // len(error)
        first = np.searchsorted(block, np.unique(block))
        scores[np.ix_(np.unique(block), columns)] += np.add.reduceat(score, first, axis=0)
    together = scores.T @ scores * OPTIONS.blocks / (OPTIONS.blocks - 3.0)
    prior = np.diag(prior_weights)
    return inverse @ (prior + spread) @ inverse, inverse @ (prior + together) @ inverse


def _wandering(error: Array, slope_matrix: Array, taken_matrix: Array, step_s: float) -> Array:
    """Covariance of the errors (n,) of evenly spaced rows, as their spectrum tells it, times their
    slopes, (n, k).  taken_matrix: (k, k), by which the slopes' spectrum tells what share of the
    errors' the fit has taken at each frequency."""
    power_level, stretches, rows = mean_power([error])
    parts = np.fft.rfft(slope_matrix[: stretches * rows].reshape(stretches, rows, -1), axis=1)
    parts = parts[:, 1 : (rows + 1) // 2]
    share = np.einsum("bfi,ij,bfj->f", parts, taken_matrix, parts.conj()).real / (stretches * rows)
    spectrum = fit_spectrum(
        power_level / np.maximum(1.0 - share, 1.0 - OPTIONS.taken_max), rows, step_s
    )
    covariance = spectrum.covariance(len(error)) if spectrum else np.zeros(len(error))
    around = np.concatenate([covariance, [0.0], covariance[:0:-1]])
    spectra = np.fft.rfft(slope_matrix, 2 * len(error), axis=0) * np.fft.rfft(around)[:, None]
    return np.asarray(np.fft.irfft(spectra, 2 * len(error), axis=0)[: len(error)])


def _cost(channels: Sequence[AlignedColumn], fit: Fit) -> float:
    """Mean error by its size, rows outside the table as a whole motion off."""
    total, rows = 0.0, 0
    for channel, columns in zip(channels, fit.places, strict=True):
        residual, _ = _residual(channel, fit.parameters, columns)
        planned, _ = channel.planned(channel.tag_s)
        room = max(float(np.std(planned)), OPTIONS.scale_min)
        inside = float(np.sum(np.minimum(np.abs(residual) / room, 1.0)))
        total += inside + 0.5 * (len(channel.tag_s) - len(residual))
        rows += len(channel.tag_s)
    return total / max(rows, 1)
