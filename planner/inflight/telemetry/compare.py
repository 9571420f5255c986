"""Telemetry beside its plan, from the rows as they came to what they say: the story of the room."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.alignment import (
    Alignment,
    ColumnScale,
    Fit,
    ideal_fit,
    inseparable,
    is_late,
)
from planner.inflight.telemetry.clock import OPTIONS as CLOCK
from planner.inflight.telemetry.clock import follows, require_followed, tell_clock, turned_to_plan
from planner.inflight.telemetry.estimates import Estimate, Inseparable
from planner.inflight.telemetry.findings import AxisComparison, ComparisonFound, SamplesUse
from planner.inflight.telemetry.following import (
    Followed,
    PlannedMotion,
    Stretch,
    error_size,
    follow,
    gap_starts,
    limits_exceeded,
    outlier_rows,
    phases,
    row_noise,
)
from planner.inflight.telemetry.oscillations import Oscillation, oscillations, searched_hz
from planner.inflight.telemetry.platforms.registry import sensors_of
from planner.inflight.telemetry.platforms.sensors import PlatformSensors
from planner.inflight.telemetry.request import ComparisonRequest
from planner.inflight.telemetry.samples import OPTIONS as SAMPLES
from planner.inflight.telemetry.samples import (
    CleanSamples,
    Dropped,
    Kind,
    Samples,
    TelemetryColumn,
    leave_out_held,
    order_rows,
)
from planner.inflight.telemetry.stick_slip import stick_slip
from planner.inflight.telemetry.wander import Wander, wander_of
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.plan import FlightPlan

_TURN_RAD = 2.0 * np.pi
_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0


@dataclass(frozen=True, kw_only=True)
class ComparisonOptions:
    """When what is left of an error is told, and as what."""

    gaps_max: int = 200  # told
    stretches_max: int = 1000  # told, of each kind
    worth_telling_rad: float = math.radians(60.0 / 3600.0)  # rms of an error: 60 arcsec
    times_noise: float = 10.0  # rms over the noise: less is noise that isn't white
    poor: float = 0.3  # of the motion: errors so large mean another plan, or columns mistaken
    outliers_make: float = 2.0  # times the rms of the other rows, at least
    jump_rows: int = 2000  # of each axis, evenly
    splits: int = 50  # tried, and once more between the neighbours of the best
    jump_leaves: float = 0.1  # of the squares that no jump explains, at most


OPTIONS = ComparisonOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """ideal_clock: offset and drift if the axes do as they are told, see `ideal_fit`."""

    plan: FlightPlan
    sensors: PlatformSensors
    clean: CleanSamples
    samples: SamplesUse
    alignment: Alignment
    ideal_clock: tuple[Estimate, Estimate] | None
    inseparable: tuple[Inseparable, ...]
    axes: tuple[AxisComparison, ...]
    notes: tuple[str, ...]

    def found(self, request: ComparisonRequest) -> ComparisonFound:
        """With what was measured beside the axes, and the platform found; raises Refusals."""
        sensors, alignment = self.sensors, self.alignment
        pointing = sensors.pointing(self, request.corrections, request.image_offsets)
        platform = sensors.found(self, request.identify)
        assumes, common_s = sensors.assumes, alignment.common_offset_s
        ideal_s, ideal_drift = self.ideal_clock or (None, None)
        return ComparisonFound(
            plan=request.plan,
            name=self.plan.scenario.name,
            epoch=utc_text(self.plan.table.epoch_utc, 1),
            samples=self.samples,
            time_offset_s=alignment.offset_s.if_so(assumes.earliest),
            clock_drift=alignment.drift.if_so(assumes.earliest),
            common_offset_s=common_s.if_so(assumes.equally_late) if common_s else None,
            ideal_offset_s=ideal_s.if_so(assumes.ideal) if ideal_s else None,
            ideal_drift=ideal_drift.if_so(assumes.ideal) if ideal_drift else None,
            inseparable=self.inseparable,
            axes={axis.name: axis for axis in self.axes},
            pointing=pointing,
            corrections=[parts.correction.told for parts in pointing],
            parameters=platform.parameters if platform else (),
            platform=platform.platform if platform else None,
            warnings=self.notes,
        )


def compare(plan: FlightPlan, samples: Samples) -> Comparison:
    """Raises InvalidInput for telemetry that tells nothing of the plan."""
    table, names, sensors = plan.table, plan.table.dof_names, sensors_of(plan)
    motions = sensors.motions
    valid = [replace(one, value=_valid(one.value, SAMPLES.value_max)) for one in samples.columns]
    columns = [column for column in valid if np.isfinite(column.value).any()]
    empty = [column.name for column in valid if column not in columns]
    if not columns:
        raise InvalidInput("no column holds a number", field="samples")
    tag_s = _valid(samples.t_s, SAMPLES.tag_max_s) + elapsed_s(samples.epoch_utc, table.epoch_utc)
    _require_some(tag_s, plan)
    sent = sensors.read(columns, tag_s)
    columns = list(sent.columns)
    columns, signs, start_s = turned_to_plan(columns, tag_s, motions)
    angle_rad, rate_rad_s, wrapped = _in_radians(columns, tag_s - start_s, motions)
    ordered = order_rows(tag_s, np.hstack([angle_rad, rate_rad_s]))
    row, dropped = ordered.row, ordered.dropped
    values: dict[Kind, Array] = {"angle": angle_rad[row], "rate": rate_rad_s[row]}
    notes_held = leave_out_held(values, tag_s[row] - start_s, motions, names, dropped)
    angle_rad[row], rate_rad_s[row] = values["angle"], values["rate"]
    row = row[np.isfinite(np.hstack([angle_rad[row], rate_rad_s[row]])).any(axis=1)]
    clock = tell_clock(tag_s[row], angle_rad[row], rate_rad_s[row], motions, start_s)
    alignment, ideal = clock.alignment, ideal_fit(clock.alignment)
    if ideal is not None:  # the errors are those beside the sharpest clock that nothing contradicts
        alignment = alignment.by(ideal)
    bad = clock.is_spike
    notes_unrelated = _leave_out_unrelated(angle_rad, rate_rad_s, clock.unrelated, names)
    ordered_columns = [replace(column, value=column.value[row]) for column in columns]
    require_followed(ordered_columns, tag_s[row], motions, alignment)
    t_s = alignment.t_s(tag_s[row])
    inside = motions[0].is_within(t_s)
    dropped["outside_plan"] = int(np.sum(~inside))
    dropped["outlier"] = int(np.sum(bad & inside))
    kept = inside & ~bad
    _require_enough(int(kept.sum()), dropped, plan)
    clean = CleanSamples(
        tag_s=tag_s[row][kept],
        angle_rad=angle_rad[row][kept],
        rate_rad_s=rate_rad_s[row][kept],
    )
    turned: dict[tuple[int, Kind], int] = {
        (column.meaning.axis, column.meaning.kind): sign
        for column, sign in zip(columns, signs, strict=True)
    }
    axes, notes = _axes(plan, sensors, clean, alignment, ideal or alignment.fit, turned)
    own_s = t_s[kept]
    gaps = [
        Stretch(epoch_utc=table.epoch_utc, start_s=float(own_s[k - 1]), stop_s=float(own_s[k]))
        for k in gap_starts(own_s)[1 : 1 + OPTIONS.gaps_max]
    ]
    used = SamplesUse(
        read=len(samples.t_s),
        used=len(own_s),
        dropped={reason: count for reason, count in sorted(dropped.items()) if count},
        reordered=ordered.reordered,
        wrapped=wrapped,
        start_utc=shifted_utc(table.epoch_utc, float(own_s[0])),
        stop_utc=shifted_utc(table.epoch_utc, float(own_s[-1])),
        step_s=float(np.median(np.diff(own_s))),
        gaps=tuple(gaps),
        columns=sent.told,
        ignored_columns=(*samples.ignored, *empty),
    )
    return Comparison(
        plan=plan,
        sensors=sensors,
        clean=clean,
        samples=used,
        alignment=alignment,
        ideal_clock=(ideal.estimate(1), ideal.estimate(0)) if ideal else None,
        inseparable=tuple(inseparable(alignment, names)),
        axes=tuple(axes),
        notes=(
            *(f"{name} holds no number" for name in empty),
            *sent.notes,
            *_notes_on_signs(columns, signs),
            *notes_held,
            *ordered.notes,
            *notes_unrelated,
            *notes,
        ),
    )


def _valid(value: Array, bound: float) -> Array:
    """NaN for what no sensor and no clock tells."""
    return np.where(np.abs(value) < bound, value, np.nan)


def _require_some(tag_s: Array, plan: FlightPlan) -> None:
    table, reach_s = plan.table, CLOCK.offset_max_s
    known = tag_s[np.isfinite(tag_s)]
    if not len(known):
        raise InvalidInput(
            f"no row has a time tag that can be read: seconds in t_s, or UTC such as "
            f"{utc_text(table.epoch_utc)} in utc",
            field="samples.t_s",
        )
    stop_s = float(table.t_s[-1])
    if known.max() < -reach_s or known.min() > stop_s + reach_s:
        first, last = (
            utc_text(shifted_utc(table.epoch_utc, float(np.clip(t, -1e9, 1e9))))
            for t in (known.min(), known.max())
        )
        raise InvalidInput(
            f"the samples run from {first} to {last}, the plan from {utc_text(table.epoch_utc)} "
            f"to {utc_text(shifted_utc(table.epoch_utc, stop_s))}: give the epoch that t_s counts "
            f"from, or the plan that was flown; offsets up to {reach_s:g} s are found",
            field="samples.epoch",
        )


def _require_enough(kept: int, dropped: Counter[Dropped], plan: FlightPlan) -> None:
    if kept < SAMPLES.rows_min:
        lost = ", ".join(f"{count} {reason}" for reason, count in dropped.items() if count)
        raise InvalidInput(
            f"{kept} rows are left ({lost or 'none was dropped'}); a comparison needs "
            f"{SAMPLES.rows_min} within the plan, which runs from "
            f"{utc_text(plan.table.epoch_utc)} for {plan.table.t_s[-1]:g} s",
            field="samples",
        )


def _in_radians(
    columns: Sequence[TelemetryColumn], t_s: Array, motions: Sequence[PlannedMotion]
) -> tuple[Array, Array, int]:
    """Angles within half a turn of the plan's, rates, (n, d) each; how many were brought there."""
    angle_rad = np.full((len(t_s), len(motions)), np.nan)
    rate_rad_s = np.full_like(angle_rad, np.nan)
    wrapped = 0
    for column in columns:
        axis, value = column.meaning.axis, column.value_rad
        if column.meaning.kind == "rate":
            rate_rad_s[:, axis] = value
            continue
        off_rad = motions[axis].angle_rad(np.nan_to_num(t_s)) - value
        turns = np.round(np.nan_to_num(off_rad / _TURN_RAD))
        wrapped += int(np.sum(turns != 0.0))
        angle_rad[:, axis] = value + _TURN_RAD * turns
    return angle_rad, rate_rad_s, wrapped


def _leave_out_unrelated(
    angle_rad: Array,
    rate_rad_s: Array,
    unrelated: Sequence[tuple[int, Kind]],
    names: Sequence[str],
) -> list[str]:
    """Sets columns that don't follow to NaN, (n, d), where the axis's other column does; notes."""
    values: dict[Kind, Array] = {"angle": angle_rad, "rate": rate_rad_s}
    notes = []
    for axis, kind in unrelated:
        other: Kind = "rate" if kind == "angle" else "angle"
        if (axis, other) not in unrelated and np.isfinite(values[other][:, axis]).any():
            values[kind][:, axis] = np.nan
            notes.append(
                f"{names[axis]}'s {kind}s don't follow its plan, its {other}s do: the {kind}s "
                "were left out"
            )
    return notes


def _axes(
    plan: FlightPlan,
    sensors: PlatformSensors,
    clean: CleanSamples,
    alignment: Alignment,
    fit: Fit,
    turned: Mapping[tuple[int, Kind], int],
) -> tuple[list[AxisComparison], list[str]]:
    t_s = alignment.t_s(clean.tag_s)
    scales = {(one.axis, one.kind): one for one in alignment.scales}
    axes: list[AxisComparison] = []
    notes: list[str] = []
    for motion, name, bounds, lag in zip(
        sensors.motions, plan.table.dof_names, sensors.bounds, alignment.lags_s, strict=True
    ):
        axis = motion.axis
        parts = [fit.parts().get((axis, kind), (0.0, 0.0)) for kind in get_args(Kind)]
        columns = clean.angle_rad[:, axis], clean.rate_rad_s[:, axis]
        followed = follow(motion, t_s, *columns, *parts)
        if followed is None:
            notes.append(f"there is no telemetry of {name}")
            continue
        if not motion.has_drive and lag is not None and is_late(lag):
            # A servo's delay hides in friction and swings; a body's is all there is beside wander.
            late_rad = lag.value * motion.rate_rad_s(followed.t_s)
            followed = replace(followed, left_rad=followed.left_rad + late_rad)
        wander = wander_of(followed) if not motion.has_drive else None
        kind: Kind = "angle" if followed.basis == "angles" else "rate"
        scale, sign = scales.get((axis, kind)), turned.get((axis, kind), 1)
        angle_rad = motion.angle_rad(followed.t_s) + followed.left_rad
        is_on_plan = follows(angle_rad, "angle", followed.t_s, motion) is not False
        rates = _turned(scales.get((axis, "rate")), turned) if kind == "angle" else None
        told = wander if is_on_plan else None
        swings = [one for one in oscillations(followed) if not _is_chance(one, wander, followed)]
        sticks = stick_slip(followed) if is_on_plan and motion.has_drive else []
        # Off its plan it was brought near it by whole turns, which are no motion of its own.
        exceeded, checked = limits_exceeded(followed, bounds) if is_on_plan else ([], [])
        axes.append(
            AxisComparison(
                name=name,
                followed=followed,
                lag=lag,
                basis=followed.basis,
                **vars(error_size(followed.error_rad)),
                gain=scale.gain.turned(sign) if scale and scale.gain else None,
                bias=scale.bias.turned(sign) if scale else None,
                bias_unit="arcsec" if kind == "angle" else "arcsec/s",
                rate_gain=rates.gain if rates else None,
                rate_bias_rad_s=rates.bias if rates else None,
                noise_rad=told.noise_rad if told else None,
                wander_rad=told.sigma_rad if told else None,
                wander_half_life_s=told.half_life_s if told else None,
                lag_s=lag.value if lag else None,
                lag_sigma_s=lag.sigma if lag else None,
                phases=tuple(phases(followed, plan.segments)),
                oscillations=tuple(swings[: OPTIONS.stretches_max]),
                oscillations_searched_hz=searched_hz(followed),
                stick_slip=tuple(sticks[: OPTIONS.stretches_max]),
                limits_exceeded=tuple(exceeded[: OPTIONS.stretches_max]),
                limits_checked=tuple(checked),
            )
        )
    return axes, notes + _notes_on_errors(axes)


def _turned(
    scale: ColumnScale | None, turned: Mapping[tuple[int, Kind], int]
) -> ColumnScale | None:
    if scale is None or scale.gain is None:
        return None
    sign = turned.get((scale.axis, scale.kind), 1)
    return replace(scale, gain=scale.gain.turned(sign), bias=scale.bias.turned(sign))


def _notes_on_signs(columns: Sequence[TelemetryColumn], signs: Sequence[int]) -> list[str]:
    return [
        f"{column.name} is measured the other way round: its gain is about -1, and its errors are "
        "those with its sign changed"
        for column, sign in zip(columns, signs, strict=True)
        if sign < 0
    ]


def _notes_on_errors(axes: Sequence[AxisComparison]) -> list[str]:
    """Axes off their plan, and errors beyond noise that nothing else in the answer explains."""
    on_time = [axis.followed for axis in axes if axis.lag is not None]
    jump = clock_jump(on_time) if on_time else None
    notes = [] if jump is None else [jump]
    for axis in axes:
        if axis.lag is None:
            notes.append(_no_lag(axis, "the other axis tells" if len(axes) < 3 else "others tell"))
            continue
        is_told = bool(jump or is_late(axis.lag) or axis.oscillations or axis.stick_slip)
        note = _outliers_left(axis) or _beyond_noise(axis, is_told)
        notes += [] if note is None else [note]
    return notes


def _is_chance(swing: Oscillation, wander: Wander | None, followed: Followed) -> bool:
    """Whether a wandering attitude may swing so."""
    if wander is None:
        return False
    step_s = float(np.median(np.diff(followed.t_s)))
    rows = (swing.stop_s - swing.start_s) / step_s
    return wander.explains(swing.frequency_hz, swing.amplitude_rad, rows, step_s)


def _no_lag(axis: AxisComparison, others: str) -> str:
    """Words on why no lag of the axis is told.  others: what tells the time instead."""
    size = error_size(axis.followed.left_rad)
    if size.rms_rad > OPTIONS.poor * _spread_rad(axis.followed):
        return (
            f"{axis.name} doesn't follow its plan, it is {math.degrees(size.rms_rad):.3g} deg rms "
            f"off: it has no lag_s, and {others} the clock; is it the plan that was flown, and the "
            "column of this axis?"
        )
    return (
        f"{axis.name} has no lag_s: it is not known to a second, as the plan moves the axis too "
        f"little, or it follows too loosely; {others} the clock"
    )


def _outliers_left(axis: AxisComparison) -> str | None:
    """Words on rows far from those around, where they make most of the error."""
    left_rad = axis.followed.left_rad
    far = outlier_rows(left_rad) & ~_explained(axis)
    if not far.any() or far.all():
        return None
    all_rad, others_rad = (error_size(one).rms_rad for one in (left_rad, left_rad[~far]))
    if all_rad < OPTIONS.outliers_make * others_rad or all_rad < OPTIONS.worth_telling_rad / 10.0:
        return None
    return (
        f"{int(far.sum())} of {len(far)} rows of {axis.name} ({100.0 * far.mean():.2g} %) are "
        "likely outliers that were not left out; beside gain and bias its rms is "
        f"{_ARCSEC_PER_RAD * others_rad:.3g} arcsec without them, {_ARCSEC_PER_RAD * all_rad:,.0f} "
        "with them"
    )


def _explained(axis: AxisComparison) -> Mask:
    """Rows in which the axis swings or sticks."""
    t_s = axis.followed.t_s
    rows = np.zeros(len(t_s), dtype=bool)
    stretches = [(one.start_s, one.stop_s) for one in axis.oscillations]
    stretches += [(one.start_s, one.stop_s) for one in axis.stick_slip]
    for start_s, stop_s in stretches:
        rows |= (t_s >= start_s) & (t_s <= stop_s)
    return rows


def _beyond_noise(axis: AxisComparison, is_told: bool) -> str | None:
    """Words on errors that neither gain and bias nor noise from row to row explain.

    is_told: whether the answer explains them otherwise.
    """
    left_rad = axis.followed.left_rad
    size = error_size(left_rad)
    if len(left_rad) < 4 or size.rms_rad < OPTIONS.worth_telling_rad:
        return None
    if size.rms_rad > OPTIONS.poor * _spread_rad(axis.followed):
        return (
            f"{axis.name} is {math.degrees(size.rms_rad):.3g} deg rms off, hardly on its plan: is "
            "it the plan that was flown, and the column of this axis?"
        )
    noise_rad = row_noise(left_rad)
    if is_told or size.rms_rad < OPTIONS.times_noise * noise_rad:
        return None
    return (
        f"beside gain and bias {axis.name} is {_ARCSEC_PER_RAD * size.rms_rad:,.0f} arcsec rms "
        f"off, its noise is {_ARCSEC_PER_RAD * noise_rad:.2g}: this comes and goes with the motion "
        "or in time, see phases; clock, gain and lags may be off by more than their sigmas"
    )


def _spread_rad(followed: Followed) -> float:
    """Of the planned motion."""
    return float(np.std(followed.motion.angle_rad(followed.t_s)))


def clock_jump(axes: Sequence[Followed]) -> str | None:
    """Words on a jump of the telemetry's clock, if one explains the errors of all axes."""
    if max(error_size(one.left_rad).rms_rad for one in axes) < OPTIONS.worth_telling_rad / 10.0:
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


def _rows(axes: Sequence[Followed]) -> tuple[Array, Array, Array]:
    """Times, errors and what they hang on: the clock's offset and drift, each axis's bias, gain."""
    parts = []
    for number, one in enumerate(axes):
        last = len(one.t_s) - 1
        rows = np.unique(np.linspace(0, last, OPTIONS.jump_rows).round().astype(np.intp))
        t_s = one.t_s[rows]
        slope = -one.motion.rate_rad_s(t_s)
        own = np.zeros((len(rows), 2 * len(axes)))
        own[:, 2 * number], own[:, 2 * number + 1] = 1.0, one.motion.angle_rad(t_s)
        parts.append(np.column_stack([t_s, one.left_rad[rows], slope, slope * t_s, own]))
    table = np.vstack(parts)
    return table[:, 0], table[:, 1], table[:, 2:]


def _squares(slope_matrix: Array, error_rad: Array) -> tuple[float, Array]:
    parts = np.asarray(np.linalg.lstsq(slope_matrix, error_rad, rcond=None)[0], dtype=np.float64)
    return float(np.sum((error_rad - slope_matrix @ parts) ** 2)), parts
