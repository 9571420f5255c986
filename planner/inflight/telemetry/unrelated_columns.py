"""Refusal of unrelated columns: telemetry that holds nothing of the plan's motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.alignment import Alignment
from planner.inflight.telemetry.columns import RAD_BY_UNIT, Kind, TelemetryColumn
from planner.inflight.telemetry.motion import PlannedMotion
from planner.inflight.telemetry.samples import SAMPLES_MIN
from planner.inflight.telemetry.search import OFFSET_MAX_S, STILL, misfit_share
from planner.world.frames.time_scales import utc_text


@dataclass(frozen=True, kw_only=True)
class UnrelatedColumnOptions:
    """When a column is told not to be of its axis."""

    blocks: int = 40  # whose medians noise and outliers hardly move
    unrelated_share: float = 0.3  # of the motion's spread: what is off by more isn't on its plan
    # share of rows outside the plan: with more a constant isn't free, since part of its motion
    # may be met by chance
    outside_max: float = 0.3
    drift_max: float = 0.02  # a share of time; what gains more is no clock
    fits: float = 0.1  # of the motion: clearly another axis's, or turned the other way


OPTIONS = UnrelatedColumnOptions()


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
        follows(_in_radians(column), column.meaning.kind, t_s, motions[column.meaning.axis])
        for column in columns
    ]
    if any(told) and abs(offset_s) > OFFSET_MAX_S:
        raise InvalidInput(
            f"the telemetry's clock is {abs(offset_s):.1f} s "
            f"{'ahead of' if offset_s > 0.0 else 'behind'} the plan's, which begins at "
            f"{utc_text(motions[0].table.epoch_utc)}; up to {OFFSET_MAX_S:g} s are told: give the "
            "epoch that t_s counts from",
            field="samples.epoch",
        )
    gain = alignment.drift.value
    if any(told) and abs(gain) > OPTIONS.drift_max:
        raise InvalidInput(
            f"the samples fit the plan only by a clock that gains {100.0 * gain:+.2g} % of time, "
            "and no clock does: they are in another unit, of axes that stopped, of another plan, "
            "or their time tags jump; send a part of them, or the unit in the column's name",
            field="samples",
        )
    is_lost = abs(offset_s) > OFFSET_MAX_S
    if any(told) or not (is_lost or False in told):
        return
    names = ", ".join(column.name[:40] for column in columns)
    raise InvalidInput(
        f"{names} hold nothing of the plan's motion{_why(columns, tag_s, motions)}; send the "
        "measured angles or rates of the flight, each under its axis's name, and the id of the "
        f"plan that was flown, with t_s from samples.epoch; clocks up to {OFFSET_MAX_S:g} s off "
        "are found",
        field=f"samples.{columns[0].name[:40]}" if len(columns) == 1 else "samples",
    )


def follows(value: Array, kind: Kind, t_s: Array, motion: PlannedMotion) -> bool | None:
    """Whether angles or rates, (n,), are off by little of the motion's spread, but for a constant;
    None where the plan doesn't move the axis meanwhile, or too few rows are left to tell.
    """
    is_within = motion.is_within(t_s)
    rows = np.flatnonzero(np.isfinite(value) & is_within)
    if len(rows) < SAMPLES_MIN:
        return None
    planned = (motion.angle_rad if kind == "angle" else motion.rate_rad_s)(t_s[rows])
    off = value[rows] - planned
    if kind == "angle":
        off = off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))
    planned, off = (_medians(one) for one in (planned, off))
    spread = float(np.std(planned))
    if spread < STILL[kind]:
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
    for change, words in (
        ((True, 1.0), "each fits the other axis: their names are swapped"),
        ((False, -1.0), "each fits with its sign changed: it is measured the other way round"),
        ((True, -1.0), "each fits the other axis with its sign changed"),
    ):
        is_swapped, sign = change
        if all(
            misfit_share(
                sign * _in_radians(column),
                column.meaning.kind,
                tag_s,
                motions[(column.meaning.axis + is_swapped) % len(motions)],
            )
            < OPTIONS.fits
            for column in columns
        ):
            return f", but {words}"
    return ""


def _in_radians(column: TelemetryColumn) -> Array:
    assert column.meaning.unit is not None
    return column.value * RAD_BY_UNIT[column.meaning.unit] / column.meaning.per_s
