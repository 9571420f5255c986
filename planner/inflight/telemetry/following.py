"""Following errors of an axis: over all, and in each phase of the table."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from planner.base.arrays import Array, Mask
from planner.inflight.telemetry.motion import EDGE_S, PlannedMotion
from planner.world.frames.time_scales import elapsed_s
from planner.world.plan import Segment, SegmentKind

Basis = Literal["angles", "rates"]


@dataclass(frozen=True, kw_only=True)
class FollowingOptions:
    """What is a gap between rows, and what is a spike."""

    # a longer step is a gap, counted in usual ones; half a step more, for a row that is late
    gap_steps: float = 4.0
    gap_min_s: float = 0.5  # where rows are dense: shorter than that nothing is missed
    clock_share: float = 1e-3  # by which a clock's rate may lengthen a step
    spike_rows: int = 7  # of the median that a spike stands out from: of three rows at most
    around_rows: int = 64  # of whose noise it is measured
    usual_percent: float = 80.0  # of the deviations: 1.28 sigma of white noise
    spike_times: float = 6.0  # of that: so that spikes are beyond 7.7 sigma


OPTIONS = FollowingOptions()

_SPIKE_MIN_RAD, _SPIKE_MIN_RAD_S = np.radians(5.0 / 3600.0), np.radians(20.0 / 3600.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Followed:
    """One axis beside its plan.

    t_s: (n,), by the plan's clock.  error_rad: measured less planned, (n,).  rate_rad_s: as
    measured, (n,), None without rates.  rate_error_rad_s: the same less planned where the basis
    is rates, else None.  basis: whether the error is that of angles, or the
    integral of rates, whose constant and steady drift stay unknown and are left out.
    starts: rows that begin after a gap, the first among them.
    """

    motion: PlannedMotion
    t_s: Array
    error_rad: Array
    rate_rad_s: Array | None
    rate_error_rad_s: Array | None
    basis: Basis
    starts: tuple[int, ...]

    @property
    def runs(self) -> list[slice]:
        """Rows without a gap between."""
        ends = (*self.starts[1:], len(self.t_s))
        return [slice(first, last) for first, last in zip(self.starts, ends, strict=True)]


@dataclass(frozen=True, kw_only=True)
class ErrorSize:
    """Of so many samples; NaN of none."""

    samples: int
    rms_rad: float
    max_rad: float
    mean_rad: float


@dataclass(frozen=True, kw_only=True)
class PhaseErrors:
    """Errors during one segment of the table, in seconds after its epoch."""

    kind: SegmentKind
    session: int | None
    start_s: float
    stop_s: float
    error: ErrorSize


def spikes(error: Array, least: float) -> Mask:
    """Values far from those before and after, (n,): of a wire or a bit, not of a motor.

    Up to three in a row; far is judged by how the rows around differ from their neighbours.
    """
    count = len(error)
    if count < OPTIONS.spike_rows:
        return np.zeros(count, dtype=bool)
    from scipy.ndimage import maximum_filter1d, median_filter

    off = np.abs(error - median_filter(error, OPTIONS.spike_rows, mode="nearest"))
    blocks = -(-count // OPTIONS.around_rows)
    padded = np.pad(
        off, (0, blocks * OPTIONS.around_rows - count), mode="reflect" if blocks > 1 else "wrap"
    )
    usual = np.percentile(padded.reshape(blocks, -1), OPTIONS.usual_percent, axis=1)
    around = np.repeat(maximum_filter1d(usual, 3, mode="nearest"), OPTIONS.around_rows)[:count]
    return np.asarray(off > np.maximum(OPTIONS.spike_times * around, least))


def spikes_of_angles(error_rad: Array) -> Mask:
    """See `spikes`; 5 arcsec is within what a platform can do from row to row."""
    return spikes(error_rad, float(_SPIKE_MIN_RAD))


def spikes_of_rates(error_rad_s: Array) -> Mask:
    """See `spikes`."""
    return spikes(error_rad_s, float(_SPIKE_MIN_RAD_S))


def gap_starts(t_s: Array) -> tuple[int, ...]:
    """Rows that begin after a gap, the first row among them."""
    if len(t_s) < 2:
        return (0,)
    step_s = np.diff(t_s)
    usual_s = float(np.median(step_s))
    most = (
        np.floor(max(OPTIONS.gap_steps, OPTIONS.gap_min_s / usual_s) * (1.0 + OPTIONS.clock_share))
        + 0.5
    )
    return (0, *(int(row) + 1 for row in np.flatnonzero(step_s > most * usual_s)))


def follow(
    motion: PlannedMotion, t_s: Array, angle_rad: Array, rate_rad_s: Array
) -> Followed | None:
    """The axis where it has samples within the table: angles where there are any, else rates.

    t_s: (n,), increasing; angle_rad and rate_rad_s: (n,), NaN where there is none.
    """
    inside = motion.is_within(t_s)
    has_angle, has_rate = inside & np.isfinite(angle_rad), inside & np.isfinite(rate_rad_s)
    if np.sum(has_angle) >= np.sum(has_rate) and has_angle.any():
        own_s = t_s[has_angle]
        rates = rate_rad_s[has_angle]
        return Followed(
            motion=motion,
            t_s=own_s,
            error_rad=angle_rad[has_angle] - motion.angle_rad(own_s),
            rate_rad_s=rates if np.isfinite(rates).all() else None,
            rate_error_rad_s=None,
            basis="angles",
            starts=gap_starts(own_s),
        )
    if not has_rate.any():
        return None
    own_s, rates = t_s[has_rate], rate_rad_s[has_rate]
    starts = gap_starts(own_s)
    off_rad_s = rates - motion.rate_rad_s(own_s)
    return Followed(
        motion=motion,
        t_s=own_s,
        error_rad=_integral(own_s, off_rad_s, starts),
        rate_rad_s=rates,
        rate_error_rad_s=off_rad_s,
        basis="rates",
        starts=starts,
    )


def error_size(error_rad: Array) -> ErrorSize:
    """Of errors (n,)."""
    if not len(error_rad):
        return ErrorSize(samples=0, rms_rad=np.nan, max_rad=np.nan, mean_rad=np.nan)
    return ErrorSize(
        samples=len(error_rad),
        rms_rad=float(np.sqrt(np.mean(error_rad**2))),
        max_rad=float(np.max(np.abs(error_rad))),
        mean_rad=float(np.mean(error_rad)),
    )


def phases(followed: Followed, segments: Sequence[Segment]) -> list[PhaseErrors]:
    """Segment by segment of the table."""
    epoch_utc = followed.motion.table.epoch_utc
    found = []
    for segment in segments:
        start_s, stop_s = (elapsed_s(at, epoch_utc) for at in (segment.start_utc, segment.stop_utc))
        # A row where two meet is the later one's, though the clock that was found be a little off.
        ends_s = [start_s - EDGE_S, stop_s + (EDGE_S if segment is segments[-1] else -EDGE_S)]
        rows = slice(*np.searchsorted(followed.t_s, ends_s))
        found.append(
            PhaseErrors(
                kind=segment.kind,
                session=segment.session,
                start_s=start_s,
                stop_s=stop_s,
                error=error_size(followed.error_rad[rows]),
            )
        )
    return found


def _integral(t_s: Array, off_rad_s: Array, starts: tuple[int, ...]) -> Array:
    """Run by run; less its straight line, which a gyro's bias and the first angle make."""
    error_rad = np.zeros(len(t_s))
    for first, last in zip(starts, (*starts[1:], len(t_s)), strict=True):
        run = slice(first, last)
        mean = 0.5 * (off_rad_s[run][1:] + off_rad_s[run][:-1])
        sums = np.concatenate([[0.0], np.cumsum(mean * np.diff(t_s[run]))])
        if last - first > 2:
            into_s = t_s[run] - t_s[first]
            sums = sums - np.polyval(np.polyfit(into_s, sums, 1), into_s)
        error_rad[run] = sums
    return error_rad
