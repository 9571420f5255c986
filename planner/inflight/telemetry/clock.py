"""The clock as the columns that follow their plan tell it: sought, fitted, and without spikes.

A column that doesn't, of an axis that is dead or flew another plan, tells nothing of the time.
Telemetry that holds nothing of the plan's motion is refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.alignment import AlignedColumn, Alignment, align
from planner.inflight.telemetry.following import PlannedMotion, spikes_of_angles, spikes_of_rates
from planner.inflight.telemetry.samples import OPTIONS as SAMPLES
from planner.inflight.telemetry.samples import RAD_BY_UNIT, Kind, TelemetryColumn
from planner.world.frames.time_scales import utc_text


@dataclass(frozen=True, kw_only=True)
class ClockOptions:
    """How the offset of a clock is sought, and when a column is told not to be of its axis."""

    offset_max_s: float = 120.0  # a later one is another session's
    near_s: float = 60.0  # before and after the plan: rows beyond tell nothing of it
    # between offsets tried: well within what a fit finds from there, as axes take seconds to
    # change their rate
    step_s: float = 0.4
    rows: int = 400  # of each column, evenly, that offsets are tried with
    fits: float = 0.25  # of what the motion would be off by if it weren't it
    as_good: float = 0.02  # misfits that the step between offsets makes of columns that fit
    clearly: float = 0.2  # of the misfit as it was sent, for it to be taken as turned round
    still_rad: float = np.radians(0.05)  # of a motion's spread: less tells nothing
    still_rad_s: float = np.radians(0.005)
    blocks: int = 40  # whose medians noise and outliers hardly move
    unrelated_share: float = 0.3  # of the motion's spread: what is off by more isn't on its plan
    # share of rows outside the plan: with more a constant isn't free, since part of its motion
    # may be met by chance
    outside_max: float = 0.3
    drift_max: float = 0.02  # a share of time; what gains more is no clock
    another: float = 0.1  # of the motion: clearly another axis's, or in another unit


OPTIONS = ClockOptions()

_TURN_RAD = 2.0 * np.pi


def _still(kind: Kind) -> float:
    return OPTIONS.still_rad if kind == "angle" else OPTIONS.still_rad_s


def offsets_s() -> Array:
    """Those tried; the telemetry's clock ahead where positive."""
    count = round(OPTIONS.offset_max_s / OPTIONS.step_s)
    return np.asarray(np.arange(-count, count + 1) * OPTIONS.step_s, dtype=np.float64)


def turned_to_plan(
    columns: Sequence[TelemetryColumn], tag_s: Array, motions: Sequence[PlannedMotion]
) -> tuple[list[TelemetryColumn], list[int], float]:
    """Columns with their sign changed where they are measured the other way round, the signs, and
    the offset that suits them all.

    tag_s: (n,), the telemetry's clock less the table's epoch.
    """
    signs = []
    total = np.zeros(len(offsets_s()))
    for column in columns:
        motion, kind = motions[column.meaning.axis], column.meaning.kind
        value, sign = column.value_rad, 1
        misfit = best = _misfit_shares(value, kind, tag_s, motion)
        if misfit.min() > OPTIONS.fits:
            for turned, is_biased in ((-1, False), (1, True), (-1, True)):
                tried = _misfit_shares(turned * value, kind, tag_s, motion, is_biased=is_biased)
                if tried.min() < min(OPTIONS.fits, OPTIONS.clearly * misfit.min(), best.min()):
                    best, sign = tried, turned
        signs.append(sign)
        # Those that fit at some offset say which: an axis that isn't on its plan at none.
        total = total + best / (best.min() + OPTIONS.as_good)
    # Of equals, as in a steady track, the least offset.
    least = np.flatnonzero(total <= total.min() * (1.0 + 1e-9) + 1e-12)
    turned_columns = [
        replace(column, value=sign * column.value)
        for column, sign in zip(columns, signs, strict=True)
    ]
    return turned_columns, signs, float(min(offsets_s()[least], key=abs))


def _misfit_shares(
    value: Array, kind: Kind, tag_s: Array, motion: PlannedMotion, *, is_biased: bool = False
) -> Array:
    """Misfits of angles or rates, (n,), at each offset tried, as a share of the motion.

    is_biased: whether a constant is free.
    """
    rows = np.flatnonzero(np.isfinite(value) & np.isfinite(tag_s))
    reach_s = OPTIONS.offset_max_s
    rows = rows[(tag_s[rows] > -reach_s) & (tag_s[rows] < motion.stop_s + reach_s)]
    if not len(rows):
        return np.ones(len(offsets_s()))
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, OPTIONS.rows).round().astype(np.intp))]
    t_s = tag_s[rows] - offsets_s()[:, None]
    planned = _planned(motion, kind, t_s)
    off = _off_plan(value[rows], planned, kind)
    if is_biased:
        off = off - np.median(off, axis=1, keepdims=True)
    room = max(float(np.std(_planned(motion, kind, tag_s[rows]))), _still(kind))
    return np.asarray(
        np.where(motion.is_within(t_s), np.minimum(np.abs(off) / room, 1.0), 0.5).mean(axis=1)
    )


def _off_plan(value: Array, planned_value: Array, kind: Kind) -> Array:
    """Measured less planned; of angles to the nearest whole turn."""
    off = value - planned_value
    return off - _TURN_RAD * np.round(off / _TURN_RAD) if kind == "angle" else off


def _planned(motion: PlannedMotion, kind: Kind, t_s: Array) -> Array:
    """Straight lines between rows do here."""
    columns = motion.table.position if kind == "angle" else motion.table.rate_rad_s
    return np.interp(t_s, motion.table.t_s, columns[:, motion.axis])


@dataclass(frozen=True, kw_only=True, eq=False)
class ToldClock:
    """unrelated: columns that don't follow their plan, by axis and kind, and tell nothing of it."""

    alignment: Alignment
    is_spike: Mask
    unrelated: tuple[tuple[int, Kind], ...]


def tell_clock(
    tag_s: Array,
    angle_rad: Array,
    rate_rad_s: Array,
    motions: Sequence[PlannedMotion],
    start_s: float,
) -> ToldClock:
    """Aligned, spikes found against that, and aligned again without them.

    tag_s: (n,), increasing.  angle_rad, rate_rad_s: (n, d), NaN where there is none.
    start_s: about what the offset is.
    """
    own_s = tag_s - start_s
    near = (own_s > -OPTIONS.near_s) & (own_s < motions[0].stop_s + OPTIONS.near_s)
    is_spike = np.zeros(len(tag_s), dtype=bool)
    for _ in range(2):
        channels = _channels(tag_s, angle_rad, rate_rad_s, motions, near & ~is_spike)
        alignment = align(channels, start_s, len(motions))
        on_plan = _on_plan(channels, alignment, start_s, len(motions))
        if len(on_plan) < len(channels):
            alignment = align(on_plan, start_s, len(motions))
        if is_spike.any():
            break
        is_spike = _spikes(alignment.t_s(tag_s), angle_rad, rate_rad_s, motions)
        if not is_spike.any():
            break
    unrelated = [channel for channel in channels if channel not in on_plan]
    return ToldClock(
        alignment=alignment,
        is_spike=is_spike,
        unrelated=tuple((channel.motion.axis, channel.kind) for channel in unrelated),
    )


def _channels(
    tag_s: Array,
    angle_rad: Array,
    rate_rad_s: Array,
    motions: Sequence[PlannedMotion],
    usable: Mask,
) -> list[AlignedColumn]:
    kinds: tuple[tuple[Kind, Array], ...] = (("angle", angle_rad), ("rate", rate_rad_s))
    channels = [
        AlignedColumn(motion=motion, kind=kind, tag_s=tag_s[own], value=value[own, motion.axis])
        for motion in motions
        for kind, value in kinds
        if (own := usable & np.isfinite(value[:, motion.axis])).sum() >= SAMPLES.rows_min
    ]
    if not channels:
        raise InvalidInput(
            f"a comparison needs {SAMPLES.rows_min} samples of an axis while the plan is flown",
            field="samples",
        )
    return channels


def _on_plan(
    channels: Sequence[AlignedColumn], alignment: Alignment, start_s: float, axes: int
) -> list[AlignedColumn]:
    """Without those that follow neither with the clock of all nor with one of their own; all where
    none follows."""
    told = [_follows(one, alignment) for one in channels]
    follows_itself = [
        is_told is False and _follows(one, align([one], start_s, axes)) is True
        for one, is_told in zip(channels, told, strict=True)
    ]
    if not (True in told or True in follows_itself):
        return [*channels]
    return [
        one
        for one, is_told, by_itself in zip(channels, told, follows_itself, strict=True)
        if is_told is not False or by_itself
    ]


def _follows(channel: AlignedColumn, alignment: Alignment) -> bool | None:
    t_s = alignment.t_s(channel.tag_s)
    return follows(channel.value, channel.kind, t_s, channel.motion)


def _spikes(
    t_s: Array, angle_rad: Array, rate_rad_s: Array, motions: Sequence[PlannedMotion]
) -> Mask:
    bad = np.zeros(len(t_s), dtype=bool)
    for motion in motions:
        for value, planned, find in (
            (angle_rad[:, motion.axis], motion.angle_rad, spikes_of_angles),
            (rate_rad_s[:, motion.axis], motion.rate_rad_s, spikes_of_rates),
        ):
            own = np.flatnonzero(np.isfinite(value))
            if len(own):
                bad[own] |= find(value[own] - planned(t_s[own]))
    return bad


def require_followed(
    columns: Sequence[TelemetryColumn],
    tag_s: Array,
    motions: Sequence[PlannedMotion],
    alignment: Alignment,
) -> None:
    """Raises InvalidInput where no column that the plan moves follows it, or too late to be told.

    tag_s: (n,), the telemetry's clock less the table's epoch, increasing.
    """
    offset_s = alignment.offset_s.value
    t_s = alignment.t_s(tag_s)
    told = [
        follows(column.value_rad, column.meaning.kind, t_s, motions[column.meaning.axis])
        for column in columns
    ]
    if any(told) and abs(offset_s) > OPTIONS.offset_max_s:
        raise InvalidInput(
            f"the telemetry's clock is {abs(offset_s):.1f} s "
            f"{'ahead of' if offset_s > 0.0 else 'behind'} the plan's, which begins at "
            f"{utc_text(motions[0].table.epoch_utc)}; up to {OPTIONS.offset_max_s:g} s are told: "
            "give the epoch that t_s counts from",
            field="samples.epoch",
        )
    drift = alignment.drift.value
    if any(told) and abs(drift) > OPTIONS.drift_max:
        raise InvalidInput(
            f"the samples fit the plan only by a clock that gains {100.0 * drift:+.2g} % of time, "
            "and no clock does: they are of axes that stopped, of another plan, or their time tags "
            "jump; send a part of them",
            field="samples",
        )
    is_lost = abs(offset_s) > OPTIONS.offset_max_s
    if any(told) or not (is_lost or False in told):
        return
    names = ", ".join(column.name[:40] for column in columns)
    raise InvalidInput(
        f"{names} hold nothing of the plan's motion{_why(columns, tag_s, motions)}; send the "
        "measured angles or rates of the flight, each under its axis's name, and the id of the "
        f"plan that was flown, with t_s from samples.epoch; clocks up to {OPTIONS.offset_max_s:g} "
        "s off are found",
        field=f"samples.{columns[0].name[:40]}" if len(columns) == 1 else "samples",
    )


def follows(value: Array, kind: Kind, t_s: Array, motion: PlannedMotion) -> bool | None:
    """Whether angles or rates, (n,), are off by little of the motion's spread, but for a constant;
    None where the plan doesn't move the axis meanwhile, or too few rows are left to tell.
    """
    is_within = motion.is_within(t_s)
    rows = np.flatnonzero(np.isfinite(value) & is_within)
    if len(rows) < SAMPLES.rows_min:
        return None
    planned = (motion.angle_rad if kind == "angle" else motion.rate_rad_s)(t_s[rows])
    off = _off_plan(value[rows], planned, kind)
    planned, off = (_medians(one) for one in (planned, off))
    spread = float(np.std(planned))
    if spread < _still(kind):
        return None
    if np.mean(~is_within) <= OPTIONS.outside_max:
        return bool(np.std(off) < OPTIONS.unrelated_share * spread)
    return bool(np.sqrt(np.mean(off**2)) < OPTIONS.unrelated_share * spread)


def _medians(value: Array) -> Array:
    parts = np.array_split(value, min(OPTIONS.blocks, len(value)))
    return np.array([np.median(part) for part in parts])


def _why(columns: Sequence[TelemetryColumn], tag_s: Array, motions: Sequence[PlannedMotion]) -> str:
    told = [column.value[np.isfinite(column.value)] for column in columns]
    if all(np.ptp(value) == 0.0 for value in told):
        same = ", ".join(dict.fromkeys(f"{value[0] + 0.0:g}" for value in told))
        return f": they stay at {same} from the first row to the last"
    for is_swapped, sign, words in (
        (True, 1.0, "each fits the other axis: their names are swapped"),
        (True, -1.0, "each fits the other axis with its sign changed"),
    ):
        if all(
            _least_misfit(
                sign * column.value_rad, column, tag_s, motions[column.meaning.axis - is_swapped]
            )
            < OPTIONS.another
            for column in columns
        ):
            return f", but {words}"
    for unit, rad in RAD_BY_UNIT.items():
        if all(
            _least_misfit(rad * column.value, column, tag_s, motions[column.meaning.axis])
            < OPTIONS.another
            for column in columns
        ):
            return f", but each fits in {unit}: name them so"
    return ""


def _least_misfit(
    value_rad: Array, column: TelemetryColumn, tag_s: Array, motion: PlannedMotion
) -> float:
    return float(_misfit_shares(value_rad, column.meaning.kind, tag_s, motion).min())
