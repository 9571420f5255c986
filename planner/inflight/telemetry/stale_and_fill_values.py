"""Values that are no measurement.

Rows that repeat the value before while the plan moves on, as of telemetry sampled faster than its
sensor, and one value in place of those that are missing.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask
from planner.inflight.telemetry.columns import Kind
from planner.inflight.telemetry.motion import PlannedMotion
from planner.inflight.telemetry.noise import sensor_step
from planner.inflight.telemetry.samples import Dropped


@dataclass(frozen=True, kw_only=True)
class StaleValueOptions:
    """Which values were never measured: repeated ones, and fills."""

    same_min: float = 0.2  # of the rows in which the plan moves by more than the sensor's steps
    runs_min: int = 10  # fewer are an axis that stood
    steps_clear: float = 2.0  # of the sensor, by which the plan must move
    fill_rows_min: int = 10  # fewer are outliers
    fill_min: float = 0.02  # as a share of all rows
    fills_max: int = 3  # values
    fill_far: float = 5.0  # times farther from the plan than nine in ten of the others


OPTIONS = StaleValueOptions()


def leave_out_stale_and_fill_values(
    values: dict[Kind, Array],
    t_s: Array,
    motions: Sequence[PlannedMotion],
    names: Sequence[str],
    dropped: Counter[Dropped],
) -> list[str]:
    """Sets them to NaN and counts the rows that are left without a value; notes.

    values: (n, 2) each, in order of t_s, (n,), which is about the plan's time.
    """
    notes = []
    had_value = np.zeros(len(t_s), dtype=bool)
    any_held = np.zeros(len(t_s), dtype=bool)
    for kind, value in values.items():
        had_value |= np.isfinite(value).any(axis=1)
        for motion, name in zip(motions, names, strict=True):
            own = value[:, motion.axis]
            planned_value = motion.angle_rad(t_s) if kind == "angle" else motion.rate_rad_s(t_s)
            filled = filled_rows(own, planned_value)
            if filled.any():
                notes.append(
                    f"{int(filled.sum())} {kind}s of {name} are one value far from the plan, as "
                    "it stands for those that are missing, and were left out"
                )
            held = held_rows(np.where(filled, np.nan, own), planned_value)
            if held.any():
                notes.append(
                    f"{int(held.sum())} {kind}s of {name} repeat the row before while the plan "
                    "moves on: the sensor gives its values less often than rows come, and only "
                    "the first of each was used"
                )
            own[filled | held] = np.nan
            any_held |= held
    has_value = np.isfinite(np.hstack([*values.values()])).any(axis=1)
    dropped["held"] += int(np.sum(any_held & ~has_value))
    dropped["no_value"] += int(np.sum(had_value & ~any_held & ~has_value))
    return notes


def held_rows(value: Array, planned_value: Array) -> Mask:
    """Rows of a column whose value is an earlier row's, (n,); none where values don't come so.

    value: (n,) in order of time, NaN where there is none.  planned_value: of the same rows.
    """
    held = np.zeros(len(value), dtype=bool)
    own = np.flatnonzero(np.isfinite(value))
    steps = np.abs(np.diff(value[own]))
    is_same = steps == 0.0
    if not is_same.any():
        return held
    # An encoder's values stay the same, too, while the plan moves by less than its step.
    is_clear = np.abs(np.diff(planned_value[own])) > OPTIONS.steps_clear * sensor_step(value[own])
    stays = is_same & is_clear
    runs = int(np.sum(np.diff(stays.astype(np.int8), prepend=0) == 1))
    if runs >= OPTIONS.runs_min and stays.sum() > OPTIONS.same_min * is_clear.sum():
        held[own[1:][is_same]] = True
    return held


def filled_rows(value: Array, planned_value: Array) -> Mask:
    """Rows that hold one value far from the plan, again and again, (n,).  value, planned_value: see
    `held_rows`."""
    filled = np.zeros(len(value), dtype=bool)
    for _ in range(OPTIONS.fills_max):
        own = np.flatnonzero(np.isfinite(value) & ~filled)
        if len(own) < 2 * OPTIONS.fill_rows_min:
            break
        values, counts = np.unique(value[own], return_counts=True)
        is_it = value[own] == values[int(np.argmax(counts))]
        runs = int(np.sum(np.diff(is_it.astype(np.int8), prepend=0) == 1))
        if (
            is_it.all()
            or runs < 3
            or is_it.sum() < max(OPTIONS.fill_rows_min, OPTIONS.fill_min * len(own))
        ):
            break
        off = np.abs(value[own] - planned_value[own])
        if np.median(off[is_it]) < OPTIONS.fill_far * np.percentile(off[~is_it], 90.0):
            break
        filled[own[is_it]] = True
    return filled
