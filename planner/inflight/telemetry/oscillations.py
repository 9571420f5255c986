"""Oscillations of an axis about its plan: when, how fast and how far.

The spectrum of windows says where to look, a least-squares sinusoid what is there: windows that
tell the same frequency one after the other are one oscillation, and its ends are where its
amplitude falls to half.  Source of the spectrum's threshold: Scargle 1982, eq. 13, of the
frequencies that a window can tell.
"""

import math
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Annotated

import numpy as np

from planner.base.answer_members import Member, answer
from planner.base.arrays import Array
from planner.inflight.telemetry.following import Followed, SizeArcsec, Stretch, sensor_step


@dataclass(frozen=True, kw_only=True)
class OscillationOptions:
    """When a peak of an error's spectrum is told as an oscillation."""

    # short ones for swings that come and go, long ones for slow swings
    windows_s: tuple[float, ...] = (24.0, 60.0, 80.0)
    overlap: float = 1.1  # of the bands that the longest windows and the shorter ones search
    window_rows_min: int = 32  # of a spectrum
    cycles_min: float = 4.0  # of a window
    # of a window: what peaks here is drift, or a swing too slow to be told from it
    cycles_slow: float = 3.0
    rows_per_cycle_min: float = 2.2  # beside the Nyquist frequency lines are mirrored
    share_min: float = 0.35  # of a window's variance
    false_alarm: float = 1e-6  # in a window of noise
    above_others: float = 30.0  # times the median power: a hump of slow noise is no line
    alike: float = 0.15  # of the frequency: one oscillation from window to window
    falls_to: float = 0.5  # of its height: there an oscillation begins and ends


OPTIONS = OscillationOptions()


@answer
class Oscillation(Stretch):
    """A stretch in which the axis swings about its plan.

    frequency_hz: of the sinusoid that fits best. E.g. `0.8`.
    amplitude_rad: of the sinusoid. E.g. `12.5`.
    """

    frequency_hz: Annotated[float, Member(least=0.0, decimals=6)]
    amplitude_rad: SizeArcsec


@dataclass(frozen=True)
class _Line:
    start_s: float
    stop_s: float
    frequency_hz: float


def oscillations(followed: Followed) -> list[Oscillation]:
    """In order of time."""
    found: list[Oscillation] = []
    step_rad, epoch_utc = 0.0, followed.motion.table.epoch_utc
    if followed.basis == "angles":
        step_rad = sensor_step(followed.motion.angle_rad(followed.t_s) + followed.error_rad)
    for run in _long_enough(followed):
        if followed.rate_left_rad_s is None:
            found += _in_run(epoch_utc, followed.t_s[run], followed.left_rad[run])
        else:  # whose noise is white, while that of their integral wanders
            found += [
                replace(one, amplitude_rad=one.amplitude_rad / (2.0 * math.pi * one.frequency_hz))
                for one in _in_run(epoch_utc, followed.t_s[run], followed.rate_left_rad_s[run])
            ]
    # A steady motion beats with the steps of an encoder, at 0.32 of them.
    return [one for one in found if one.amplitude_rad > 0.5 * step_rad]


def searched_hz(followed: Followed) -> tuple[float, float] | None:
    """Lowest and highest frequency that `oscillations` finds, in the longest stretch without a gap;
    None where all are too short."""
    steps = [(run.stop - run.start, _step_s(followed.t_s[run])) for run in _long_enough(followed)]
    if not steps:
        return None
    rows, step_s = max(steps, key=lambda one: one[0] * one[1])
    return _band_hz(max(_sizes(rows, step_s)), step_s)


def _long_enough(followed: Followed) -> list[slice]:
    return [run for run in followed.runs if run.stop - run.start >= OPTIONS.window_rows_min]


def _step_s(t_s: Array) -> float:
    return float(t_s[-1] - t_s[0]) / (len(t_s) - 1)


def _sizes(rows: int, step_s: float) -> set[int]:
    """Rows of the windows in a run of so many."""
    return {
        min(rows, max(OPTIONS.window_rows_min, round(span_s / step_s)))
        for span_s in OPTIONS.windows_s
    }


def _band_hz(size: int, step_s: float) -> tuple[float, float]:
    """Frequencies that a window of so many rows tells."""
    return OPTIONS.cycles_min / (size * step_s), 1.0 / (OPTIONS.rows_per_cycle_min * step_s)


def _in_run(epoch_utc: datetime, t_s: Array, error_rad: Array) -> list[Oscillation]:
    """Of errors of any unit: the amplitude is in theirs."""
    step_s = _step_s(t_s)
    even_s = t_s[0] + step_s * np.arange(len(t_s))
    even_rad = np.interp(even_s, t_s, error_rad)
    lines = []
    *shorter, last = sorted(_sizes(len(even_s), step_s))
    for size in (*shorter, last):
        highest_hz, hop = _band_hz(size, step_s)[1], max(size // 4, 1)
        if len(shorter) > 1 and size == last:  # the shorter ones tell the rest
            highest_hz, hop = OPTIONS.overlap * _band_hz(shorter[-1], step_s)[0], size // 2
        for first in [*range(0, len(even_s) - size, hop), len(even_s) - size]:
            found_hz = _line_hz(even_rad[first : first + size], step_s, highest_hz)
            if found_hz is not None:
                start_s = float(even_s[first])
                lines.append(_Line(start_s, start_s + step_s * size, found_hz))
    found = (_oscillation(epoch_utc, even_s, even_rad, line, step_s) for line in _joined(lines))
    return [one for one in found if one is not None]


def _line_hz(error_rad: Array, step_s: float, highest_hz: float) -> float | None:
    """The frequency that stands out of a window's spectrum."""
    count = len(error_rad)
    place = np.linspace(-1.0, 1.0, count)
    trend = np.polynomial.legendre.legvander(place, 3)
    left = error_rad - trend @ np.linalg.lstsq(trend, error_rad, rcond=None)[0]
    variance = float(np.mean(left**2))
    if not variance > 0.0:
        return None
    window = np.hanning(count)
    padded = 4 * count
    power = np.abs(np.fft.rfft(left * window, padded)) ** 2
    frequency_hz = np.fft.rfftfreq(padded, step_s)
    span_s = count * step_s
    lowest_hz, _ = _band_hz(count, step_s)
    usable = frequency_hz >= OPTIONS.cycles_slow / span_s
    peak = int(np.flatnonzero(usable)[np.argmax(power[usable])])
    if not lowest_hz <= frequency_hz[peak] <= highest_hz:
        return None
    if power[peak] < OPTIONS.above_others * float(np.median(power[usable])):
        return None
    best_hz = _refined_hz(left, step_s, float(frequency_hz[peak]), 1.0 / span_s)
    _, rest = _sinusoid(left, _even_s(count, step_s), best_hz)
    explained = 1.0 - float(np.mean(rest**2)) / variance
    # Power over the noise's, of the best among so many frequencies of pure noise.
    chance = 0.5 * count * math.exp(-0.5 * count * explained / max(1.0 - explained, 1e-12) / 2.0)
    return best_hz if explained > OPTIONS.share_min and chance < OPTIONS.false_alarm else None


def _refined_hz(error_rad: Array, step_s: float, frequency_hz: float, room_hz: float) -> float:
    """Least squares near a peak of the spectrum."""
    t_s = _even_s(len(error_rad), step_s)
    for _ in range(3):
        tried = frequency_hz + room_hz * np.linspace(-0.5, 0.5, 9)
        rest = [float(np.sum(_sinusoid(error_rad, t_s, hz)[1] ** 2)) for hz in tried]
        frequency_hz, room_hz = float(tried[int(np.argmin(rest))]), 0.25 * room_hz
    return frequency_hz


def _even_s(count: int, step_s: float) -> Array:
    return np.asarray(np.arange(count) * step_s, dtype=np.float64)


def _sinusoid(error_rad: Array, t_s: Array, frequency_hz: float) -> tuple[float, Array]:
    """Amplitude of the sinusoid that fits best, beside a straight line, and what is left."""
    phase = 2.0 * np.pi * frequency_hz * t_s
    design = np.stack([np.cos(phase), np.sin(phase), np.ones(len(t_s)), t_s - t_s.mean()], axis=1)
    parts = np.linalg.solve(design.T @ design, design.T @ error_rad)
    return float(np.hypot(parts[0], parts[1])), error_rad - design @ parts


def _joined(lines: list[_Line]) -> list[_Line]:
    """Windows that touch and tell the same, as one."""
    groups: list[list[_Line]] = []
    for line in sorted(lines, key=lambda one: one.start_s):
        group = next((group for group in groups if any(_is_same(line, one) for one in group)), None)
        if group is None:
            groups.append([line])
        else:
            group.append(line)
    return [
        _Line(
            group[0].start_s,
            max(line.stop_s for line in group),
            float(np.median([line.frequency_hz for line in group])),
        )
        for group in groups
    ]


def _is_same(line: _Line, earlier: _Line) -> bool:
    is_alike = abs(line.frequency_hz - earlier.frequency_hz) < OPTIONS.alike * earlier.frequency_hz
    return is_alike and line.start_s <= earlier.stop_s


def _oscillation(
    epoch_utc: datetime, even_s: Array, even_rad: Array, line: _Line, step_s: float
) -> Oscillation | None:
    """Where in its windows it is, and its sinusoid there; None where little is left of it."""
    rows = slice(*np.searchsorted(even_s, [line.start_s, line.stop_s]))
    t_s, error_rad = even_s[rows], even_rad[rows]
    envelope = _envelope(t_s, error_rad, line.frequency_hz, step_s)
    high = np.flatnonzero(envelope > OPTIONS.falls_to * np.percentile(envelope, 90.0))
    t_s, error_rad = t_s[high[0] : high[-1] + 1], error_rad[high[0] : high[-1] + 1]
    if (t_s[-1] - t_s[0]) * line.frequency_hz < 2.0:
        return None
    trend = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, len(t_s)), 3)
    left = error_rad - trend @ np.linalg.lstsq(trend, error_rad, rcond=None)[0]
    return Oscillation(
        epoch_utc=epoch_utc,
        start_s=float(t_s[0]),
        stop_s=float(t_s[-1]),
        frequency_hz=_refined_hz(left, step_s, line.frequency_hz, 1.0 / (t_s[-1] - t_s[0])),
        amplitude_rad=float(np.sqrt(np.mean(envelope[high[0] : high[-1] + 1] ** 2))),
    )


def _envelope(t_s: Array, error_rad: Array, frequency_hz: float, step_s: float) -> Array:
    """Amplitude near the frequency at each row, over two cycles, or as many as tell the frequency
    from its mirror image beyond half the sampling rate."""
    cycle_s = max(2.0 / frequency_hz, 1.0 / (1.0 / step_s - 2.0 * frequency_hz))
    rows = 2 * round(0.5 * cycle_s / step_s) + 1
    kernel = np.ones(rows) / rows
    smooth = np.convolve(np.pad(error_rad, rows, mode="reflect"), kernel, mode="same")
    left = error_rad - smooth[rows:-rows]
    offset_s = step_s * (np.arange(rows) - rows // 2)
    passed = 1.0 - float(np.mean(np.cos(2.0 * np.pi * frequency_hz * offset_s)))
    turning = left * np.exp(-2j * np.pi * frequency_hz * t_s)
    padded = np.pad(turning, rows, mode="reflect")
    return np.asarray(2.0 * np.abs(np.convolve(padded, kernel, mode="same")[rows:-rows]) / passed)
