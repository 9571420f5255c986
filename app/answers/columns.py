"""Columns of an answer: lists with a value for each row, converted from arrays."""

import math
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from app.answers.members import DECIMALS
from planner.base.arrays import Array
from planner.world.frames.iers import RAD_PER_ARCSEC

Answer = TypeVar("Answer")

# By the end of a member's name: that of ours, the factor to it, the decimals told.
_UNITS = (
    ("gimbal_deg", "gimbal_rad", math.degrees(1.0), DECIMALS),
    ("_deg_s3", "_rad_s3", math.degrees(1.0), DECIMALS),
    ("_deg_s2", "_rad_s2", math.degrees(1.0), DECIMALS),
    ("_deg_s", "_rad_s", math.degrees(1.0), DECIMALS),
    ("_deg", "_rad", math.degrees(1.0), 6),  # 0.1 m on the ground
    ("_arcsec", "_rad", 1.0 / RAD_PER_ARCSEC, 4),
    ("_m", "_m", 1.0, 3),
    ("_share", "_share", 1.0, 6),
)
_CYCLE_DEG = 360.0


def columns_of(
    kind: type[Answer], value: object, unknown_rows: int = 0, **members: object
) -> Answer:
    """A dataclass of an answer, its columns those that a value has as arrays (n, ...).

    `x_deg` is `x_rad` in degrees, `x_arcsec` in arcsec; NaN becomes null, and so do so many rows
    before the first.  members: those that are no columns.
    """
    for field in fields(kind):  # type: ignore[arg-type]
        if field.name not in members:
            members[field.name] = _column(value, field.name, unknown_rows)
    return kind(**members)


def numbers(value_by_row: Array, factor: float, decimals: int, unknown_rows: int = 0) -> list[Any]:
    """Rounded; NaN, which JSON writes as null, in the rows that aren't known."""
    told = np.round(value_by_row * factor, decimals) + 0.0  # no -0.0
    if unknown_rows:
        told = np.concatenate([np.full((unknown_rows, *told.shape[1:]), np.nan), told])
    column: list[Any] = told.tolist()
    return column


def _column(value: object, name: str, unknown_rows: int) -> list[Any]:
    for told, ours, factor, decimals in _UNITS:
        if name.endswith(told):
            values = getattr(value, name.removesuffix(told) + ours)
            column = numbers(values, factor, decimals, unknown_rows)
            return [_in_cycle(x) for x in column] if name.startswith("azimuth") else column
    known: list[Any] = getattr(value, name).tolist()
    return [None] * unknown_rows + known


def _in_cycle(azimuth_deg: float) -> float:
    """What rounds to a whole turn is north."""
    return 0.0 if azimuth_deg == _CYCLE_DEG else azimuth_deg
