"""About when telemetry begins, and in which unit it is: tried out against the plan."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.columns import RAD_BY_UNIT, AngleUnit, Kind, TelemetryColumn
from planner.inflight.telemetry.motion import PlannedMotion

OFFSET_MAX_S = 120.0


@dataclass(frozen=True, kw_only=True)
class ColumnSearchOptions:
    """How the offset of a clock is sought, and which column fits which axis."""

    # well within what a fit finds from there: axes take seconds to change their rate
    step_s: float = 0.4
    rows: int = 400  # of each column, evenly
    fits: float = 0.25  # of what the motion would be off by if it weren't it
    as_good: float = 0.02  # misfits that the step between offsets makes of columns that fit
    clearly: float = 0.2  # of the named unit's misfit, for another to be believed instead


OPTIONS = ColumnSearchOptions()

STILL = {"angle": np.radians(0.05), "rate": np.radians(0.005)}  # less motion tells nothing
_TURN_RAD = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Tried:
    """A column in one unit: its misfit as a share of its motion at each offset tried, (k,)."""

    misfit_share: Array

    @property
    def least(self) -> float:
        return float(self.misfit_share.min())


def offsets_s() -> Array:
    """Those tried; the telemetry's clock ahead where positive."""
    count = round(OFFSET_MAX_S / OPTIONS.step_s)
    return np.asarray(np.arange(-count, count + 1) * OPTIONS.step_s, dtype=np.float64)


def in_units(
    columns: Sequence[TelemetryColumn], tag_s: Array, motions: Sequence[PlannedMotion]
) -> tuple[list[TelemetryColumn], float]:
    """Every column with its unit told, and the offset that suits them all; refuses where not.

    tag_s: (n,), the telemetry's clock less the table's epoch.
    """
    tried = [_try_units(column, tag_s, motions[column.meaning.axis]) for column in columns]
    told = [_told_by_itself(column, units) for column, units in zip(columns, tried, strict=True)]
    known = [column for column in told if column is not None]
    for place, column in enumerate(told):
        if column is None:
            told[place] = _told_by_others(columns[place], known)
    sure = [column for column in told if column is not None]
    # Those that fit at some offset say which: an axis that isn't on its plan at none.
    total = np.zeros(len(offsets_s()))
    for column, units in zip(sure, tried, strict=True):
        one = units[column.meaning.unit]
        total = total + one.misfit_share / (one.least + OPTIONS.as_good)
    # Of equals, as in a steady track, the least offset.
    best = np.flatnonzero(total <= total.min() * (1.0 + 1e-9) + 1e-12)
    return sure, float(min(offsets_s()[best], key=abs))


def _told_by_itself(
    column: TelemetryColumn, tried: dict[AngleUnit | None, Tried]
) -> TelemetryColumn | None:
    named = column.meaning.unit
    ranked = sorted((one.least, unit) for unit, one in tried.items() if unit is not None)
    (least, best), (second, _) = ranked[:2]
    if named is not None:
        # What hardly moves in a unit fits it where the plan rests.
        moves = np.nanstd(column.value) * RAD_BY_UNIT[best] / column.meaning.per_s
        is_wrong = least < min(OPTIONS.fits, OPTIONS.clearly * tried[named].least)
        is_wrong = is_wrong and bool(moves > STILL[column.meaning.kind])
        return _as(column, best) if is_wrong else column
    return _as(column, best) if least < min(OPTIONS.fits, 0.5 * second) else None


def _told_by_others(column: TelemetryColumn, known: list[TelemetryColumn]) -> TelemetryColumn:
    alike = [other for other in known if other.meaning.kind == column.meaning.kind]
    if not alike:
        raise InvalidInput(
            f"the unit of {column.name[:40]} can't be told from its name or from the plan, which "
            "hardly moves that axis or moves it otherwise; end its name in _deg, _rad, _arcmin or "
            "_arcsec, of a rate in _deg_s",
            field=f"samples.{column.name[:40]}",
        )
    return _as(column, alike[0].meaning.unit)


def _as(column: TelemetryColumn, unit: AngleUnit | None) -> TelemetryColumn:
    return replace(column, meaning=replace(column.meaning, unit=unit), unit_from="fit")


def misfit_share(value_rad: Array, kind: Kind, tag_s: Array, motion: PlannedMotion) -> float:
    """The least misfit of angles or rates, (n,), to a motion, as a share of it."""
    [least] = (one.least for one in _tried(value_rad, kind, tag_s, motion, (1.0,)))
    return least


def _try_units(
    column: TelemetryColumn, tag_s: Array, motion: PlannedMotion
) -> dict[AngleUnit | None, Tried]:
    value, scales_rad = column.value / column.meaning.per_s, tuple(RAD_BY_UNIT.values())
    tried = _tried(value, column.meaning.kind, tag_s, motion, scales_rad)
    return dict(zip(RAD_BY_UNIT, tried, strict=True))


def _tried(
    value: Array, kind: Kind, tag_s: Array, motion: PlannedMotion, scales_rad: Sequence[float]
) -> list[Tried]:
    """By scale that the value is multiplied with."""
    rows = np.flatnonzero(np.isfinite(value) & np.isfinite(tag_s))
    inside = (tag_s[rows] > -OFFSET_MAX_S) & (tag_s[rows] < motion.stop_s + OFFSET_MAX_S)
    rows = rows[inside]
    if not len(rows):
        return [Tried(np.ones(len(offsets_s())))] * len(scales_rad)
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, OPTIONS.rows).round().astype(np.intp))]
    t_s = tag_s[rows] - offsets_s()[:, None]
    planned = _planned(motion, kind, t_s)
    is_within = motion.is_within(t_s)
    room = max(float(np.std(_planned(motion, kind, tag_s[rows]))), float(STILL[kind]))
    scaled = (value[rows] * scale_rad for scale_rad in scales_rad)
    return [
        Tried(_misfit(one if kind == "rate" else _near(one, planned), planned, is_within, room))
        for one in scaled
    ]


def _planned(motion: PlannedMotion, kind: Kind, t_s: Array) -> Array:
    """Straight lines between rows do here."""
    columns = motion.table.angle_rad if kind == "angle" else motion.table.rate_rad_s
    return np.interp(t_s, motion.table.t_s, columns[:, motion.axis])


def _near(angle_rad: Array, planned_rad: Array) -> Array:
    """By whole turns."""
    return np.asarray(angle_rad + _TURN_RAD * np.round((planned_rad - angle_rad) / _TURN_RAD))


def _misfit(value: Array, planned_value: Array, is_within: Mask, scale: float) -> Array:
    off = np.minimum(np.abs(value - planned_value) / scale, 1.0)
    return np.asarray(np.where(is_within, off, 0.5).mean(axis=-1))
