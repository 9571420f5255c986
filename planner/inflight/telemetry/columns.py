"""Telemetry columns by their names: an axis's angle or rate, and its unit."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from planner.base.arrays import Array

Kind = Literal["angle", "rate"]
AngleUnit = Literal["deg", "rad", "mrad", "arcmin", "arcsec"]
UnitFrom = Literal["name", "fit", "unit row"]

RAD_BY_UNIT: dict[AngleUnit, float] = {
    "deg": math.radians(1.0),
    "rad": 1.0,
    "mrad": 1e-3,
    "arcmin": math.radians(1.0 / 60.0),
    "arcsec": math.radians(1.0 / 3600.0),
}
_UNIT_WORDS: dict[str, AngleUnit] = {
    **dict.fromkeys(("deg", "degs", "degree", "degrees", "dps"), "deg"),
    **dict.fromkeys(("rad", "rads", "radian", "radians"), "rad"),
    **dict.fromkeys(("mrad", "mrads"), "mrad"),
    **dict.fromkeys(("arcmin", "arcmins", "amin", "arcminutes"), "arcmin"),
    **dict.fromkeys(("arcsec", "arcsecs", "asec", "arcseconds"), "arcsec"),
}
_PER_S = {"s": 1.0, "sec": 1.0, "second": 1.0, "dps": 1.0, "min": 60.0, "h": 3600.0, "hr": 3600.0}
_RATE_WORDS = {"rate", "rates", "dot", "gyro", "speed", "velocity", "omega", "vel", "dps"}
# Not measured motion: what was commanded, what was made of it, derivatives of higher order.
_OTHER_WORDS = {
    *("cmd", "command", "commanded", "ref", "reference", "target", "plan", "planned", "setpoint"),
    *("error", "err", "residual", "sigma", "std", "noise", "flag", "status", "quality", "current"),
    *("s2", "acc", "accel", "acceleration", "jerk", "temperature", "temp", "torque", "volt"),
}
_SIGNS = {"°": " deg ", "º": " deg ", "″": " arcsec ", "′": " arcmin ", '"': " ", "'": " "}


@dataclass(frozen=True, kw_only=True)
class ColumnMeaning:
    """axis: its number.  unit: None where the name says none.  per_s: seconds a rate is per."""

    axis: int
    kind: Kind
    unit: AngleUnit | None
    per_s: float = 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class TelemetryColumn:
    """Values as they were sent, (n,), NaN where there is none; in the meaning's unit."""

    name: str
    meaning: ColumnMeaning
    value: Array
    unit_from: UnitFrom = "name"


def words_of(name: str) -> list[str]:
    """Lower-case words of a header, its signs of units written out."""
    for sign, word in _SIGNS.items():
        name = name.replace(sign, word)
    return re.findall(r"[^\W_]+", name.lower())


def meaning_of(name: str, axis_names: Sequence[str]) -> ColumnMeaning | None:
    """None where it is no axis's measured angle or rate."""
    words = words_of(name)
    for axis, axis_name in enumerate(axis_names):
        own = words_of(axis_name)
        for first in range(len(words) - len(own) + 1):
            if own and words[first : first + len(own)] == own:
                return _meaning(axis, words[:first] + words[first + len(own) :])
    return None


def unit_of(text: str) -> tuple[AngleUnit | None, float | None]:
    """The unit that words hold, and the seconds it is per; None where they say neither."""
    words = words_of(text)
    unit = next((_UNIT_WORDS[word] for word in words if word in _UNIT_WORDS), None)
    per_s = next((_PER_S[word] for word in words if word in _PER_S), None)
    return unit, per_s


def _meaning(axis: int, words: list[str]) -> ColumnMeaning | None:
    if _OTHER_WORDS & {*words}:
        return None
    unit, per_s = unit_of(" ".join(words))
    is_rate = bool(_RATE_WORDS & {*words}) or (unit is not None and per_s is not None)
    return ColumnMeaning(
        axis=axis,
        kind="rate" if is_rate else "angle",
        unit=unit,
        per_s=(per_s or 1.0) if is_rate else 1.0,
    )
