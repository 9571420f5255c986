"""Telemetry beside its plan, from the rows as they came to what they say: the story of the room."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.alignment import (
    OPTIONS as ALIGNMENT_OPTIONS,
)
from planner.inflight.telemetry.alignment import (
    Alignment,
    ClockEstimate,
)
from planner.inflight.telemetry.cleaning import order
from planner.inflight.telemetry.clock import tell_clock
from planner.inflight.telemetry.columns import RAD_BY_UNIT, Kind, TelemetryColumn
from planner.inflight.telemetry.exceeded import Exceeded, Limit, limits_exceeded
from planner.inflight.telemetry.following import (
    ErrorSize,
    Followed,
    PhaseErrors,
    error_size,
    follow,
    gap_starts,
    phases,
)
from planner.inflight.telemetry.motion import PlannedMotion
from planner.inflight.telemetry.oscillations import Oscillation, oscillations, searched_hz
from planner.inflight.telemetry.residual_diagnostics import (
    alternating,
    beyond_noise,
    clock_jump,
    no_lag,
    other_scale,
    outliers_left,
)
from planner.inflight.telemetry.samples import SAMPLES_MIN, CleanSamples, Dropped, Samples
from planner.inflight.telemetry.search import OFFSET_MAX_S, in_units
from planner.inflight.telemetry.stale_and_fill_values import leave_out_stale_and_fill_values
from planner.inflight.telemetry.stick_slip import StickSlip, stick_slip
from planner.inflight.telemetry.unrelated_columns import follows, require_followed
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.plan import FlightPlan

_TURN_RAD = 2.0 * np.pi
GAPS_MAX = 200
_TAG_MAX_S, _VALUE_MAX = 1e10, 1e9


@dataclass(frozen=True, kw_only=True, eq=False)
class AxisComparison:
    """What one axis did.  lag_s: see `Alignment.lags_s`.  oscillations_searched_hz: lowest and
    highest frequency; None where the samples are too few."""

    name: str
    followed: Followed
    error: ErrorSize
    lag_s: ClockEstimate | None
    phases: tuple[PhaseErrors, ...]
    oscillations: tuple[Oscillation, ...]
    oscillations_searched_hz: tuple[float, float] | None
    stick_slip: tuple[StickSlip, ...]
    limits_exceeded: tuple[Exceeded, ...]
    limits_checked: tuple[Limit, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """gaps_s: (start, stop) after the table's epoch, of all axes.  wrapped: angles brought within
    half a turn of the plan."""

    plan: FlightPlan
    samples: CleanSamples
    columns: tuple[TelemetryColumn, ...]
    ignored: tuple[str, ...]
    alignment: Alignment
    axes: tuple[AxisComparison, ...]
    step_s: float
    gaps_s: tuple[tuple[float, float], ...]
    wrapped: int
    notes: tuple[str, ...]


def compare(plan: FlightPlan, samples: Samples) -> Comparison:
    """Raises InvalidInput for telemetry that tells nothing of the plan."""
    table, platform = plan.table, plan.scenario.platform
    names = platform.axis_names
    motions = [PlannedMotion(table, axis) for axis in range(len(names))]
    valid = [replace(column, value=_valid(column.value, _VALUE_MAX)) for column in samples.columns]
    columns = [column for column in valid if np.isfinite(column.value).any()]
    empty = [column.name for column in valid if column not in columns]
    if not columns:
        raise InvalidInput("no column holds a number", field="samples")
    tag_s = _valid(samples.t_s, _TAG_MAX_S) + elapsed_s(samples.epoch_utc, table.epoch_utc)
    _require_some(tag_s, plan)
    columns, start_s = in_units(columns, tag_s, motions)
    angle_rad, rate_rad_s, wrapped = _in_radians(columns, tag_s - start_s, motions)
    ordered = order(tag_s, np.hstack([angle_rad, rate_rad_s]))
    row, dropped = ordered.row, ordered.dropped
    values: dict[Kind, Array] = {"angle": angle_rad[row], "rate": rate_rad_s[row]}
    notes_unmeasured = leave_out_stale_and_fill_values(
        values, tag_s[row] - start_s, motions, names, dropped
    )
    angle_rad[row], rate_rad_s[row] = values["angle"], values["rate"]
    row = row[np.isfinite(np.hstack([angle_rad[row], rate_rad_s[row]])).any(axis=1)]
    clock = tell_clock(tag_s[row], angle_rad[row], rate_rad_s[row], motions, start_s)
    alignment, bad = clock.alignment, clock.is_spike
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
        read=len(samples.t_s),
        dropped={reason: count for reason, count in sorted(dropped.items()) if count},
        reordered=ordered.reordered,
    )
    axes, notes = _axes(plan, clean, alignment, motions)
    scale = other_scale(alignment.offset_s.value, table.epoch_utc)
    notes += [] if scale is None else [scale]
    own_s = t_s[kept]
    gaps_s = [(float(own_s[k - 1]), float(own_s[k])) for k in gap_starts(own_s)[1:]]
    return Comparison(
        plan=plan,
        samples=clean,
        columns=tuple(columns),
        ignored=(*samples.ignored, *empty),
        alignment=alignment,
        axes=tuple(axes),
        step_s=float(np.median(np.diff(own_s))),
        gaps_s=tuple(gaps_s[:GAPS_MAX]),
        wrapped=wrapped,
        notes=(
            *samples.notes,
            *(f"{name} holds no number" for name in empty),
            *_notes_on_units(samples, columns),
            *notes_unmeasured,
            *ordered.notes,
            *notes_unrelated,
            *notes,
        ),
    )


def _valid(value: Array, bound: float) -> Array:
    """NaN for what no sensor and no clock tells."""
    return np.where(np.abs(value) < bound, value, np.nan)


def _require_some(tag_s: Array, plan: FlightPlan) -> None:
    table = plan.table
    known = tag_s[np.isfinite(tag_s)]
    if not len(known):
        raise InvalidInput(
            f"no row has a time tag that can be read: seconds in t_s, or UTC such as "
            f"{utc_text(table.epoch_utc)} in utc",
            field="samples.t_s",
        )
    stop_s = float(table.t_s[-1])
    if known.max() < -OFFSET_MAX_S or known.min() > stop_s + OFFSET_MAX_S:
        first, last = (
            utc_text(shifted_utc(table.epoch_utc, float(np.clip(t, -1e9, 1e9))))
            for t in (known.min(), known.max())
        )
        raise InvalidInput(
            f"the samples run from {first} to {last}, the plan from {utc_text(table.epoch_utc)} "
            f"to {utc_text(shifted_utc(table.epoch_utc, stop_s))}: give the epoch that t_s counts "
            f"from, or the plan that was flown; offsets up to {OFFSET_MAX_S:g} s are found",
            field="samples.epoch",
        )


def _require_enough(kept: int, dropped: Counter[Dropped], plan: FlightPlan) -> None:
    if kept < SAMPLES_MIN:
        lost = ", ".join(f"{count} {reason}" for reason, count in dropped.items() if count)
        raise InvalidInput(
            f"{kept} rows are left ({lost or 'none was dropped'}); a comparison needs "
            f"{SAMPLES_MIN} within the plan, which runs from {utc_text(plan.table.epoch_utc)} for "
            f"{plan.table.t_s[-1]:g} s",
            field="samples",
        )


def _in_radians(
    columns: Sequence[TelemetryColumn], t_s: Array, motions: Sequence[PlannedMotion]
) -> tuple[Array, Array, int]:
    """Angles within half a turn of the plan's, rates, (n, 2) each; how many were brought there."""
    angle_rad = np.full((len(t_s), len(motions)), np.nan)
    rate_rad_s = np.full_like(angle_rad, np.nan)
    wrapped = 0
    for column in columns:
        meaning = column.meaning
        assert meaning.unit is not None
        value = column.value * RAD_BY_UNIT[meaning.unit]
        if meaning.kind == "rate":
            rate_rad_s[:, meaning.axis] = value / meaning.per_s
            continue
        off_rad = motions[meaning.axis].angle_rad(np.nan_to_num(t_s)) - value
        turns = np.round(np.nan_to_num(off_rad / _TURN_RAD))
        wrapped += int(np.sum(turns != 0.0))
        angle_rad[:, meaning.axis] = value + _TURN_RAD * turns
    return angle_rad, rate_rad_s, wrapped


def _leave_out_unrelated(
    angle_rad: Array,
    rate_rad_s: Array,
    unrelated: Sequence[tuple[int, Kind]],
    names: Sequence[str],
) -> list[str]:
    """Sets columns that don't follow to NaN, (n, 2), where the axis's other column does; notes."""
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
    clean: CleanSamples,
    alignment: Alignment,
    motions: Sequence[PlannedMotion],
) -> tuple[list[AxisComparison], list[str]]:
    platform = plan.scenario.platform
    t_s = alignment.t_s(clean.tag_s)
    axes: list[AxisComparison] = []
    notes: list[str] = []
    for motion, name, limits, lag_s in zip(
        motions, platform.axis_names, platform.axis_limits, alignment.lags_s, strict=True
    ):
        columns = clean.angle_rad[:, motion.axis], clean.rate_rad_s[:, motion.axis]
        followed = follow(motion, t_s, *columns)
        if followed is None:
            notes.append(f"there is no telemetry of {name}")
            continue
        error = error_size(followed.error_rad)
        exceeded, checked = limits_exceeded(followed, limits)
        angle_rad = motion.angle_rad(followed.t_s) + followed.error_rad
        creeps = follows(angle_rad, "angle", followed.t_s, motion) is not False
        axes.append(
            AxisComparison(
                name=name,
                followed=followed,
                error=error,
                lag_s=lag_s,
                phases=tuple(phases(followed, plan.segments)),
                oscillations=tuple(oscillations(followed)),
                oscillations_searched_hz=searched_hz(followed),
                stick_slip=tuple(stick_slip(followed)) if creeps else (),
                limits_exceeded=tuple(exceeded),
                limits_checked=tuple(checked),
            )
        )
    return axes, notes + _notes_on_errors(axes)


def _notes_on_errors(axes: Sequence[AxisComparison]) -> list[str]:
    """Axes off their plan, and errors beyond noise that nothing else in the answer explains."""
    on_time = [axis.followed for axis in axes if axis.lag_s is not None]
    jump = clock_jump(on_time) if on_time else None
    notes = [] if jump is None else [jump]
    for axis in axes:
        lag_s = axis.lag_s
        if lag_s is None:
            notes.append(no_lag(axis.name, axis.followed))
            continue
        is_late = lag_s.value > ALIGNMENT_OPTIONS.late_sigma * lag_s.sigma
        is_told = bool(jump or is_late or axis.oscillations or axis.stick_slip)
        note = (
            outliers_left(axis.name, axis.followed)
            or alternating(axis.name, axis.followed)
            or beyond_noise(axis.name, axis.followed, is_told)
        )
        notes += [] if note is None else [note]
    return notes


def _notes_on_units(samples: Samples, columns: Sequence[TelemetryColumn]) -> list[str]:
    named = {column.name: column.meaning.unit for column in samples.columns}
    return [
        f"{column.name} fits the plan in {column.meaning.unit} and was read so"
        + (f", not in {named[column.name]} as its name says" if named[column.name] else "")
        for column in columns
        if column.unit_from == "fit"
    ]
