"""Errors larger than the telemetry's noise, and their causes.

An axis off its plan, a clock that jumped, outliers too many to be left out, or none known.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from scipy.ndimage import median_filter

from planner.base.arrays import Array
from planner.inflight.telemetry.following import Followed, error_size
from planner.inflight.telemetry.noise import row_noise
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text


@dataclass(frozen=True, kw_only=True)
class DiagnosisOptions:
    """When what is left of an error is told, and as what."""

    worth_telling_rad: float = math.radians(60.0 / 3600.0)  # rms of an error: 60 arcsec
    times_noise: float = 10.0  # rms over the noise: less is noise that isn't white
    poor: float = 0.3  # of the motion: errors so large mean another plan, or columns mistaken
    around_rows: int = 31  # of whose median an outlier is far
    outlier_sigmas: float = 8.0  # of the noise: none of a million rows of white noise is so far off
    outliers_make: float = 2.0  # times the rms of the other rows, at least
    alternates: float = -0.5  # correlation of neighbours: of white noise it is 0
    scale_within_s: float = 0.5  # of a whole number of leap seconds
    jump_rows: int = 2000  # of each axis, evenly
    splits: int = 50  # tried, and once more between the neighbours of the best
    jump_leaves: float = 0.1  # of the squares that no jump explains, at most


OPTIONS = DiagnosisOptions()

_TAI_AS_UTC, _TAI_AHEAD_S = datetime(1999, 1, 1, tzinfo=UTC), 32  # IERS Bulletin C 16
_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0


def clock_jump(axes: Sequence[Followed]) -> str | None:
    """Words on a jump of the telemetry's clock, if one explains the errors of all axes."""
    if max(error_size(one.error_rad).rms_rad for one in axes) < OPTIONS.worth_telling_rad / 10.0:
        return None
    t_s, error_rad, design = _rows(axes)
    if len(t_s) < 2 * OPTIONS.splits:
        return None
    before = _squares(design, error_rad)[0]
    low_s, high_s = np.quantile(t_s, [0.02, 0.98])
    best = (math.inf, 0.0, 0.0)
    for _ in range(2):
        for split_s in np.linspace(low_s, high_s, OPTIONS.splits):
            step = design[:, 0] * (t_s > split_s)
            left, parts = _squares(np.column_stack([step, design]), error_rad)
            best = min(best, (left, float(split_s), float(parts[0])))
        room_s = (high_s - low_s) / (OPTIONS.splits - 1)
        low_s, high_s = best[1] - room_s, best[1] + room_s
    left, split_s, jump_s = best
    if left > OPTIONS.jump_leaves * before:
        return None
    at = utc_text(shifted_utc(axes[0].motion.table.epoch_utc, split_s))
    return (
        f"the telemetry's clock jumps by about {jump_s:+.3g} s near {at}: time_offset_s, "
        "clock_drift, lags and errors are those of no one clock; compare the rows before and after "
        "by themselves"
    )


def other_scale(offset_s: float, epoch_utc: datetime) -> str | None:
    """Words on a clock that is ahead of UTC by what another time scale is."""
    tai_s = round(elapsed_s(epoch_utc, _TAI_AS_UTC) - (epoch_utc - _TAI_AS_UTC).total_seconds())
    tai_s += _TAI_AHEAD_S
    for name, ahead_s in (("TAI", tai_s), ("GPS time", tai_s - 19), ("TT", tai_s + 32.184)):
        if abs(offset_s - ahead_s) < OPTIONS.scale_within_s:
            return (
                f"the telemetry's clock is {offset_s:.3f} s ahead of UTC, as {name} was by "
                f"{ahead_s:g} s: its time tags may be of that scale"
            )
    return None


def no_lag(name: str, followed: Followed) -> str:
    """Words on why no lag of the axis is told."""
    size = error_size(followed.error_rad)
    if size.rms_rad > OPTIONS.poor * float(np.std(followed.motion.angle_rad(followed.t_s))):
        return (
            f"{name} doesn't follow its plan, it is {math.degrees(size.rms_rad):.3g} deg rms off: "
            "it has no lag_s, and the other axis tells the clock; is it the plan that was flown, "
            "and the column of this axis?"
        )
    return (
        f"{name} has no lag_s: it is not known to a second, as the plan moves the axis too little, "
        "or it follows too loosely; the other axis tells the clock"
    )


def alternating(name: str, followed: Followed) -> str | None:
    """Words on errors that change from row to row by turns: rows of two sources."""
    error_rad = followed.error_rad
    if len(error_rad) < OPTIONS.around_rows:
        return None
    off_rad = error_rad - median_filter(error_rad, OPTIONS.around_rows, mode="nearest")
    off_rad = off_rad - np.mean(off_rad)
    squares = float(np.sum(off_rad**2))
    if not squares or np.sum(off_rad[1:] * off_rad[:-1]) > OPTIONS.alternates * squares:
        return None
    return (
        f"errors of {name} change sign from row to row: rows of two sources whose clocks or zeros "
        "differ; send one of them, clock and lags may be off by more than their sigmas"
    )


def outliers_left(name: str, followed: Followed) -> str | None:
    """Words on rows far from those around, where they make most of the error."""
    error_rad = followed.error_rad
    if len(error_rad) < OPTIONS.around_rows:
        return None
    off_rad = np.abs(error_rad - median_filter(error_rad, OPTIONS.around_rows, mode="nearest"))
    far_rad = OPTIONS.outlier_sigmas * 1.4826 * float(np.median(off_rad))
    far = off_rad > far_rad
    if not far.any() or far.all():
        return None
    all_rad, others_rad = (error_size(one).rms_rad for one in (error_rad, error_rad[~far]))
    if all_rad < OPTIONS.outliers_make * others_rad or all_rad < OPTIONS.worth_telling_rad / 10.0:
        return None
    return (
        f"{int(far.sum())} of {len(far)} rows of {name} ({100.0 * far.mean():.2g} %) are likely "
        f"outliers that were not left out: {_ARCSEC_PER_RAD * far_rad:.3g} arcsec and more from "
        f"the median around; without them its rms is {_ARCSEC_PER_RAD * others_rad:.3g} arcsec, "
        f"not {_ARCSEC_PER_RAD * all_rad:,.0f}"
    )


def beyond_noise(name: str, followed: Followed, is_told: bool) -> str | None:
    """Words on errors that noise from row to row doesn't explain.

    is_told: whether the answer explains them otherwise.
    """
    size = error_size(followed.error_rad)
    if len(followed.error_rad) < 4 or size.rms_rad < OPTIONS.worth_telling_rad:
        return None
    if size.rms_rad > OPTIONS.poor * float(np.std(followed.motion.angle_rad(followed.t_s))):
        return (
            f"{name} is {math.degrees(size.rms_rad):.3g} deg rms off, hardly on its plan: is it "
            "the plan that was flown, and the column of this axis?"
        )
    if is_told:
        return None
    noise_rad = row_noise(followed.error_rad)
    if size.rms_rad < OPTIONS.times_noise * noise_rad:
        return None
    rms, mean, noise = (_ARCSEC_PER_RAD * one for one in (size.rms_rad, size.mean_rad, noise_rad))
    return (
        f"{name} is {rms:,.0f} arcsec rms off, its noise is {noise:.2g}: the mean is {mean:+,.0f}, "
        "the rest comes and goes with the motion or in time, see phases; clock and lags may be off "
        "by more than their sigmas"
    )


def _rows(axes: Sequence[Followed]) -> tuple[Array, Array, Array]:
    """Times, errors and what they hang on: an offset of the clock, its drift, an axis's zero."""
    parts = []
    for number, one in enumerate(axes):
        last = len(one.t_s) - 1
        rows = np.unique(np.linspace(0, last, OPTIONS.jump_rows).round().astype(np.intp))
        t_s = one.t_s[rows]
        slope = -one.motion.rate_rad_s(t_s)
        zeros = np.zeros((len(rows), len(axes)))
        zeros[:, number] = 1.0
        parts.append(np.column_stack([t_s, one.error_rad[rows], slope, slope * t_s, zeros]))
    table = np.vstack(parts)
    return table[:, 0], table[:, 1], table[:, 2:]


def _squares(slope_matrix: Array, error_rad: Array) -> tuple[float, Array]:
    parts = np.asarray(np.linalg.lstsq(slope_matrix, error_rad, rcond=None)[0], dtype=np.float64)
    return float(np.sum((error_rad - slope_matrix @ parts) ** 2)), parts
