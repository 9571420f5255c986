"""Where an axis stuck and slipped: it stands while its command moves, then catches up.

What stands still is judged by the slope of a few rows, as many as the noise asks for.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from planner.arrays import Array, Mask
from planner.telemetry.following import Followed

_STUCK, _SLIPS = 0.3, 1.6  # of the commanded rate
_STEADY = 0.15  # of the commanded rate that the noise of a slope may be
_WINDOWS_S = (0.15, 0.3, 0.6, 1.2)
_SHARE_MIN = 0.3  # of the time stuck: a swing about the command stands still for 0.25 at most
_CYCLES_MIN = 2  # of stuck and slipping
_APART_CYCLES = 2.5  # longer between two slips ends a stretch
_RATE_MIN_RAD_S = np.radians(0.5 / 3600.0)
_RATE_MAX_RAD_S = np.radians(0.2)  # faster is no creeping: what is told then is a servo's swing


@dataclass(frozen=True, kw_only=True)
class StickSlip:
    """start_s, stop_s: after the table's epoch.  slips: how often it let go.  stuck_share: of the
    time.  slip_rad: largest way caught up at once.  rate_rad_s: largest command in it."""

    start_s: float
    stop_s: float
    slips: int
    stuck_share: float
    slip_rad: float
    rate_rad_s: float


def stick_slip(followed: Followed) -> list[StickSlip]:
    """In order of time."""
    found: list[StickSlip] = []
    for run in followed.runs:
        if run.stop - run.start > 16:
            found += _in_run(followed, run)
    return found


def _in_run(followed: Followed, run: slice) -> list[StickSlip]:
    t_s = followed.t_s[run]
    command_rad_s = followed.motion.rate_rad_s(t_s)
    speed_rad_s = np.abs(command_rad_s)
    step_s = (t_s[-1] - t_s[0]) / (len(t_s) - 1)
    relative = np.full(len(t_s), np.nan)
    for window_s in _WINDOWS_S:
        rows = max(3, 2 * round(0.5 * window_s / step_s) + 1)
        if rows >= len(t_s):
            break
        off_rad_s, noise_rad_s = _rate_error(followed, run, rows, step_s)
        clear = np.isnan(relative) & (speed_rad_s > max(noise_rad_s / _STEADY, _RATE_MIN_RAD_S))
        clear &= speed_rad_s < _RATE_MAX_RAD_S
        relative[clear] = 1.0 + off_rad_s[clear] / command_rad_s[clear]
    stuck, slips = np.abs(relative) < _STUCK, relative > _SLIPS
    found = [
        _stretch(t_s, followed.error_rad[run], speed_rad_s, stuck, slice(first, last))
        for first, last in _alternating(t_s, stuck, slips)
    ]
    return [one for one in found if one.stuck_share > _SHARE_MIN]


def _rate_error(followed: Followed, run: slice, rows: int, step_s: float) -> tuple[Array, float]:
    """Measured less commanded rate over so many rows, and its noise."""
    if followed.rate_error_rad_s is None:
        error_rad = followed.error_rad[run]
        slope = savgol_filter(error_rad, rows, 1, deriv=1, delta=step_s)
        # Of a straight line through so many rows of independent noise.
        return slope, _noise(error_rad) / (step_s * np.sqrt(rows * (rows**2 - 1) / 12.0))
    off_rad_s = followed.rate_error_rad_s[run]
    return uniform_filter1d(off_rad_s, rows), _noise(off_rad_s) / np.sqrt(rows)


def _noise(error: Array) -> float:
    """Of a row by itself: third differences keep little of what is smooth."""
    return 1.4826 * float(np.median(np.abs(np.diff(error, 3)))) / math.sqrt(20.0)


def _alternating(t_s: Array, stuck: Mask, slips: Mask) -> list[tuple[int, int]]:
    """First and last row of stretches with at least so many changes from stuck to slipping."""
    told = np.flatnonzero(stuck | slips)
    if not len(told):
        return []
    changes = told[1:][slips[told[1:]] & stuck[told[:-1]]]  # where it lets go
    if len(changes) < _CYCLES_MIN:
        return []
    usual_s = float(np.median(np.diff(t_s[changes])))
    groups = np.split(changes, np.flatnonzero(np.diff(t_s[changes]) > _APART_CYCLES * usual_s) + 1)
    found = []
    for group in groups:
        if len(group) >= _CYCLES_MIN:
            before = told[np.searchsorted(told, group[0]) - 1]
            while before > 0 and stuck[before - 1]:
                before -= 1
            last = group[-1]
            while last + 1 < len(t_s) and slips[last + 1]:
                last += 1
            found.append((int(before), int(last) + 1))
    return found


def _stretch(
    t_s: Array, error_rad: Array, speed_rad_s: Array, stuck: Mask, rows: slice
) -> StickSlip:
    held = stuck[rows].astype(np.int8)
    ends = np.flatnonzero(np.diff(held) < 0)
    off_rad = error_rad[rows]
    caught_up = [
        float(np.ptp(off_rad[first : next_end + 1]))
        for first, next_end in zip(ends, [*ends[1:], len(held) - 1], strict=True)
    ]
    return StickSlip(
        start_s=float(t_s[rows][0]),
        stop_s=float(t_s[rows][-1]),
        slips=len(ends),
        stuck_share=float(held.mean()),
        slip_rad=max(caught_up, default=0.0),
        rate_rad_s=float(speed_rad_s[rows].max()),
    )
