"""One axis beside its plan: the planned motion, errors, noise, outliers, limits exceeded."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

import numpy as np

from planner.base.answer_members import Count, Internal, Member, answer
from planner.base.arrays import Array, Mask
from planner.base.commands import ROWS_PER_S, CommandTable
from planner.base.table_motion import axes_motion_at, smooth_motion_at
from planner.world.frames.time_scales import Utc, elapsed_s, shifted_utc
from planner.world.plan import Segment, SegmentKind

Basis = Literal["angles", "rates"]
Limit = Literal["angle_min", "angle_max", "rate", "acceleration"]
LimitUnit = Literal["deg", "deg/s", "deg/s2"]
SizeArcsec = Annotated[float, Member("arcsec", 0.0, decimals=4)]
SignedArcsec = Annotated[float, Member("arcsec", decimals=4)]
LimitDeg = Annotated[float, Member("deg", decimals=6)]


@dataclass(frozen=True, kw_only=True)
class FollowingOptions:
    """What is a gap between rows, an outlier, a sensor's step, and a limit exceeded."""

    edge_s: float = 1e-4  # by which a clock set right may put the table's ends outside
    # a longer step is a gap, counted in usual ones; half a step more, for a row that is late
    gap_steps: float = 4.0
    gap_min_s: float = 0.5  # where rows are dense: shorter than that nothing is missed
    clock_share: float = 1e-3  # by which a clock's rate may lengthen a step
    spike_rows: int = 7  # of the median that a spike stands out from: of three rows at most
    block_rows: int = 64  # of whose noise it is measured
    usual_percent: float = 80.0  # of the deviations: 1.28 sigma of white noise
    spike_times: float = 6.0  # of that: so that spikes are beyond 7.7 sigma
    spike_min_rad: float = math.radians(5.0 / 3600.0)  # what a platform can do from row to row
    spike_min_rad_s: float = math.radians(20.0 / 3600.0)
    outlier_rows: int = 31  # of the median that an outlier is far from: a third may be outliers
    quiet_percent: float = 40.0  # of the deviations, which a third of outliers doesn't reach:
    quiet_sigmas: float = 0.524  # so many sigmas of white noise
    outlier_sigmas: float = 8.0  # of the noise: none of a million rows of white noise is so far off
    lattice_min: float = 0.9  # of the gaps between values, to be whole multiples of the least
    whole: float = 0.02  # of a step, off the lattice: digits printed round it
    values_min: int = 20  # fewer may lie so by chance,
    repeated: float = 0.25  # unless each comes again and again: values over rows
    limit_sigma: float = 5.0  # of the noise, by which a limit must be passed
    limit_rows_min: int = 7  # of a stretch, so that a cubic through it leaves some to tell noise by
    apart_s: float = 1.0  # what is beyond again sooner is the same stretch
    limit_noise_max: float = 0.2  # of a limit: with more, nothing is told of it
    rate_span_s: float = 0.4  # of which the motion is a parabola
    acceleration_span_s: float = 1.0  # of which it is a cubic


OPTIONS = FollowingOptions()


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """Angle, rate and acceleration of one axis of a table, at t_s seconds after its epoch.

    Before the first row and after the last the axis is taken to rest where the table has it.  A
    table of accelerations, too, is of angles turned about a body's axes, which no drive moves.
    """

    table: CommandTable
    axis: int

    @property
    def has_drive(self) -> bool:
        """Whether a motor turns it, with friction and an encoder."""
        return self.table.acceleration_rad_s2 is None

    @property
    def stop_s(self) -> float:
        return float(len(self.table.position) - 1) / ROWS_PER_S

    def is_within(self, t_s: Array) -> Mask:
        """Whether the table covers each time, (n,)."""
        return np.asarray((t_s >= -OPTIONS.edge_s) & (t_s <= self.stop_s + OPTIONS.edge_s))

    def angle_rad(self, t_s: Array) -> Array:
        """(n,)."""
        return self._motion(t_s)[0]

    def rate_rad_s(self, t_s: Array) -> Array:
        """(n,); zero outside."""
        return np.where(self.is_within(t_s), self._motion(t_s)[1], 0.0)

    def acceleration_rad_s2(self, t_s: Array) -> Array:
        """(n,); zero outside."""
        return np.where(self.is_within(t_s), self._motion(t_s)[2], 0.0)

    def _motion(self, t_s: Array) -> tuple[Array, Array, Array]:
        column = slice(self.axis, self.axis + 1)
        rows = self.table.position[:, column], self.table.rate_rad_s[:, column]
        if self.table.acceleration_rad_s2 is None:
            angle, rate, acceleration = axes_motion_at(*rows, t_s)
        else:
            accelerations = self.table.acceleration_rad_s2[:, column]
            angle, rate, acceleration = smooth_motion_at(*rows, accelerations, t_s)
        return angle[:, 0], rate[:, 0], acceleration[:, 0]


@dataclass(frozen=True, kw_only=True, eq=False)
class Followed:
    """One axis beside its plan.

    t_s: (n,), by the plan's clock.  error_rad: measured less planned, (n,).  left_rad: the same
    less what the axis's gain and bias make of it, and a body's lag.  rate_rad_s: as measured, (n,),
    None without rates.  rate_left_rad_s: less planned, gain and bias where the basis is rates, else
    None.  basis: whether the error is that of angles, or the integral of rates, whose constant and
    steady drift stay unknown and are left out.  starts: rows that begin after a gap, the first
    among them.
    """

    motion: PlannedMotion
    t_s: Array
    error_rad: Array
    left_rad: Array
    rate_rad_s: Array | None
    rate_left_rad_s: Array | None
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


@answer
class PhaseErrors:
    """Measured less planned during one segment of the table.

    kind: kind of the segment.
    session: number of the session it belongs to, from 0; null on the way to the final state.
    start_utc: of the segment; UTC.
    stop_utc: of the segment; UTC.
    samples: there are of it.
    rms_rad: null without samples.
    max_rad: the largest, either way; null without samples.
    mean_rad: null without samples.
    """

    kind: SegmentKind
    session: Count | None
    start_utc: Utc
    stop_utc: Utc
    samples: Count
    rms_rad: SizeArcsec | None
    max_rad: SizeArcsec | None
    mean_rad: SignedArcsec | None


@answer
class Stretch:
    """Of time, by the plan's clock.

    start_utc: start of the stretch; UTC. E.g. `"2015-02-27T17:36:20.000Z"`.
    stop_utc: end of the stretch; UTC. E.g. `"2015-02-27T17:36:24.000Z"`.
    start_s, stop_s: after epoch_utc, the table's.
    """

    epoch_utc: Internal[datetime]
    start_s: Internal[float]
    stop_s: Internal[float]

    @property
    def start_utc(self) -> Utc:
        """Its beginning."""
        return shifted_utc(self.epoch_utc, self.start_s)

    @property
    def stop_utc(self) -> Utc:
        """Its end."""
        return shifted_utc(self.epoch_utc, self.stop_s)


def spikes(error: Array, least: float) -> Mask:
    """Values far from those before and after, (n,): of a wire or a bit, not of a motor.

    Up to three in a row; far is judged by how the rows around differ from their neighbours.
    """
    count = len(error)
    if count < OPTIONS.spike_rows:
        return np.zeros(count, dtype=bool)
    from scipy.ndimage import median_filter

    # Mirrored, as a first or last row would be its own median else.
    off = np.abs(error - median_filter(error, OPTIONS.spike_rows, mode="mirror"))
    around = _around(off, OPTIONS.usual_percent)
    return np.asarray(off > np.maximum(OPTIONS.spike_times * around, least))


def outlier_rows(error: Array) -> Mask:
    """Rows far from the median around them by the noise of those around, (n,).

    A swing or a stick is as far from its median as the rows around it are, and isn't one.
    """
    count = len(error)
    if count < OPTIONS.outlier_rows:
        return np.zeros(count, dtype=bool)
    from scipy.ndimage import median_filter

    off = np.abs(error - median_filter(error, OPTIONS.outlier_rows, mode="mirror"))
    sigma = _around(off, OPTIONS.quiet_percent) / OPTIONS.quiet_sigmas
    return np.asarray(off > OPTIONS.outlier_sigmas * sigma)


def _around(error: Array, level: float) -> Array:
    """The percentile of errors' sizes in a block of rows or in one beside it, for each row."""
    from scipy.ndimage import maximum_filter1d

    size = OPTIONS.block_rows
    blocks = -(-len(error) // size)
    padded = np.pad(
        error, (0, blocks * size - len(error)), mode="reflect" if blocks > 1 else "wrap"
    )
    usual = np.percentile(padded.reshape(blocks, -1), level, axis=1)
    return np.repeat(maximum_filter1d(usual, 3, mode="nearest"), size)[: len(error)]


def spikes_of_angles(error_rad: Array) -> Mask:
    """See `spikes`; 5 arcsec is within what a platform can do from row to row."""
    return spikes(error_rad, OPTIONS.spike_min_rad)


def spikes_of_rates(error_rad_s: Array) -> Mask:
    """See `spikes`."""
    return spikes(error_rad_s, OPTIONS.spike_min_rad_s)


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
    motion: PlannedMotion,
    t_s: Array,
    angle_rad: Array,
    rate_rad_s: Array,
    angle_scale: tuple[float, float] = (0.0, 0.0),
    rate_scale: tuple[float, float] = (0.0, 0.0),
) -> Followed | None:
    """The axis where it has samples within the table: angles where there are any, else rates.

    t_s: (n,), increasing; angle_rad and rate_rad_s: (n,), NaN where there is none.  angle_scale,
    rate_scale: the share of the motion by which the gain is above one, and the bias.
    """
    inside = motion.is_within(t_s)
    has_angle, has_rate = inside & np.isfinite(angle_rad), inside & np.isfinite(rate_rad_s)
    if np.sum(has_angle) >= np.sum(has_rate) and has_angle.any():
        own_s, rates = t_s[has_angle], rate_rad_s[has_angle]
        planned_rad = motion.angle_rad(own_s)
        error_rad = angle_rad[has_angle] - planned_rad
        return Followed(
            motion=motion,
            t_s=own_s,
            error_rad=error_rad,
            left_rad=error_rad - angle_scale[0] * planned_rad - angle_scale[1],
            rate_rad_s=rates if np.isfinite(rates).all() else None,
            rate_left_rad_s=None,
            basis="angles",
            starts=gap_starts(own_s),
        )
    if not has_rate.any():
        return None
    own_s, rates = t_s[has_rate], rate_rad_s[has_rate]
    starts = gap_starts(own_s)
    planned_rad_s = motion.rate_rad_s(own_s)
    off_rad_s = rates - planned_rad_s
    left_rad_s = off_rad_s - rate_scale[0] * planned_rad_s - rate_scale[1]
    return Followed(
        motion=motion,
        t_s=own_s,
        error_rad=_integral(own_s, off_rad_s, starts),
        left_rad=_integral(own_s, left_rad_s, starts),
        rate_rad_s=rates,
        rate_left_rad_s=left_rad_s,
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
        edge_s = OPTIONS.edge_s
        ends_s = [start_s - edge_s, stop_s + (edge_s if segment is segments[-1] else -edge_s)]
        size = vars(error_size(followed.error_rad[slice(*np.searchsorted(followed.t_s, ends_s))]))
        found.append(
            PhaseErrors(
                kind=segment.kind,
                session=segment.session,
                start_utc=segment.start_utc,
                stop_utc=segment.stop_utc,
                **size if size["samples"] else {**dict.fromkeys(size), "samples": 0},
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


def row_noise(error: Array) -> float:
    """1 sigma of white noise in (n,): third differences keep little of what is smooth."""
    if len(error) < 4:
        return 0.0
    return 1.4826 * float(np.median(np.abs(np.diff(error, 3)))) / math.sqrt(20.0)


def sensor_step(value: Array) -> float:
    """The step of an encoder or of the digits sent, of (n,); 0 where values are of no lattice."""
    finite = value[np.isfinite(value)]
    if not len(finite):
        return 0.0
    gaps = np.diff(np.sort(finite))
    gaps = gaps[gaps > 1e-12 * max(float(np.abs(finite).max()), 1e-3)]
    if not len(gaps) or (
        len(gaps) > OPTIONS.repeated * len(finite) and len(gaps) < OPTIONS.values_min
    ):
        return 0.0
    counts = gaps / gaps.min()
    is_whole = np.abs(counts - np.round(counts)) < OPTIONS.whole
    return float(gaps.min()) if is_whole.mean() > OPTIONS.lattice_min else 0.0


@dataclass(frozen=True, kw_only=True)
class MotionBounds:
    """What one axis is to keep within.  angle_rad: least and most; None: any."""

    angle_rad: tuple[float, float] | None
    rate_rad_s: float
    acceleration_rad_s2: float


@answer
class Exceeded(Stretch):
    """A stretch in which the measured motion went beyond a limit, by more than its noise.

    limit: the limit that was exceeded. E.g. `"rate"`.
    value: the farthest, in `unit`. E.g. `3.2`.
    bound: the limit, in `unit`. E.g. `3.0`.
    unit: of both. E.g. `"deg/s"`.
    """

    limit: Limit
    value: LimitDeg
    bound: LimitDeg

    @property
    def unit(self) -> Annotated[LimitUnit, Member()]:
        """As it is written; value and bound are in radians."""
        units: dict[Limit, LimitUnit] = {"rate": "deg/s", "acceleration": "deg/s2"}
        return units.get(self.limit, "deg")


def limits_exceeded(followed: Followed, bounds: MotionBounds) -> tuple[list[Exceeded], list[Limit]]:
    """Stretches beyond, and the limits that the samples could tell of.

    A row or two far from those around are no motion, and are drawn over.
    """
    found: list[Exceeded] = []
    checked: list[Limit] = []
    t_s, epoch_utc = followed.t_s, followed.motion.table.epoch_utc
    error_rad = _without_outliers(t_s, followed.error_rad)
    angle_rad = followed.motion.angle_rad(t_s) + error_rad
    step = sensor_step(followed.motion.angle_rad(t_s) + followed.error_rad)
    if followed.basis == "angles" and bounds.angle_rad is not None:
        checked += ["angle_min", "angle_max"]
        margin = OPTIONS.limit_sigma * max(row_noise(angle_rad), 0.5 * step)
        low, high = bounds.angle_rad
        found += _beyond("angle_min", epoch_utc, t_s, -angle_rad, -low, margin, -1.0)
        found += _beyond("angle_max", epoch_utc, t_s, angle_rad, high, margin, 1.0)
    motions: tuple[tuple[Limit, int, float, float], ...] = (
        ("rate", 1, bounds.rate_rad_s, OPTIONS.rate_span_s),
        ("acceleration", 2, bounds.acceleration_rad_s2, OPTIONS.acceleration_span_s),
    )
    measured, orders = error_rad, 0
    if followed.rate_rad_s is not None:
        off_rad_s = followed.rate_rad_s - followed.motion.rate_rad_s(t_s)
        measured, orders = _without_outliers(t_s, off_rad_s), 1
        step = sensor_step(followed.rate_rad_s)
    for limit, order, bound, span_s in motions:
        told = False
        for run in followed.runs:
            off, noise = _slope(t_s[run], measured[run], order - orders, span_s, step)
            if off is not None and noise < OPTIONS.limit_noise_max * bound:
                told = True
                motion = followed.motion
                planned = (motion.rate_rad_s, motion.acceleration_rad_s2)[order - 1](t_s[run])
                margin = OPTIONS.limit_sigma * noise
                found += _beyond(limit, epoch_utc, t_s[run], planned + off, bound, margin, 1.0)
                found += _beyond(limit, epoch_utc, t_s[run], -planned - off, bound, margin, -1.0)
        if told:
            checked.append(limit)
    return sorted(found, key=lambda one: one.start_s), checked


def _without_outliers(t_s: Array, error: Array) -> Array:
    """Straight lines over rows that spikes would be told of were they the only ones."""
    bad = outlier_rows(error)
    ends = np.flatnonzero(np.diff(bad.astype(np.int8), prepend=0, append=0))
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        bad[first:last] &= last - first <= OPTIONS.spike_rows // 2
    return np.interp(t_s, t_s[~bad], error[~bad]) if bad.any() else error


def _slope(
    t_s: Array, error: Array, order: int, span_s: float, step: float
) -> tuple[Array | None, float]:
    """The derivative of this order of an error over a run, and its noise: only the error is small
    enough to be drawn through uneven or missing rows.

    step: of the sensor, by half of which a row may be off.
    """
    if len(t_s) < OPTIONS.limit_rows_min:
        return None, 0.0
    noise = max(row_noise(error), 0.5 * step)
    if order == 0:
        return error, noise
    step_s = (t_s[-1] - t_s[0]) / (len(t_s) - 1)
    rows = max(OPTIONS.limit_rows_min, 2 * round(0.5 * span_s / step_s) + 1)
    if rows > len(t_s):
        return None, 0.0
    # SciPy's signals take 0.2 s to import, which only a comparison should pay.
    from scipy.signal import savgol_filter

    even_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    even = np.interp(even_s, t_s, error)
    slope = savgol_filter(even, rows, order + 1, deriv=order, delta=step_s)
    kernel = savgol_filter(
        np.eye(1, 2 * rows + 1, rows)[0], rows, order + 1, deriv=order, delta=step_s
    )
    return np.interp(t_s, even_s, slope), noise * float(np.linalg.norm(kernel))


def _beyond(
    limit: Limit,
    epoch_utc: datetime,
    t_s: Array,
    value: Array,
    bound: float,
    margin: float,
    sign: float,
) -> list[Exceeded]:
    beyond = np.flatnonzero(value > bound + margin)
    found = []
    for rows in np.split(beyond, np.flatnonzero(np.diff(t_s[beyond]) > OPTIONS.apart_s) + 1):
        if not len(rows):
            continue
        first, last = rows[0], rows[-1] + 1
        found.append(
            Exceeded(
                limit=limit,
                epoch_utc=epoch_utc,
                start_s=float(t_s[first]),
                stop_s=float(t_s[last - 1]),
                value=sign * float(value[first:last].max()),
                bound=sign * bound,
            )
        )
    return found
