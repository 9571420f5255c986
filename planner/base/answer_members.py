"""Answers' members as classes of the domain hold them: units, ranges and names outside.

A class under `@answer` is a frozen dataclass that answers hold as it is: its fields are members,
its docstring is their text.  The type of a field says how it is written, and by which unit the
member's name ends:

    away_min_rad: HalfTurn | None    away_min_deg, rounded; 0 to 180 in the schema
    max_rad: Arcsec                  max_arcsec
    at_utc: Utc                      at, as text to the millisecond (frames.time_scales)
    number: Count                    number, as it is; 0 or more in the schema
    t_s: Internal[float]               not at all

A property is a member, too, after the fields of its class, if its type is one of these (`Text` and
`Signed` are for that).  Every number needs one, for its range; other types are written as pydantic
writes them, classes under `@answer` by this rule again, one that is a number with its error
(`scaled`) in the member's unit.  An array is an `Annotated[Array, Member(...)]`, written as lists.

The service imports these classes at its start: their modules load no solver.  Only `app` imports
pydantic, which asks types for their `__get_pydantic_core_schema__`.
"""

import dataclasses
import inspect
import math
import re
from collections.abc import Callable, Iterator
from typing import (
    Annotated,
    Any,
    TypeVar,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array

T = TypeVar("T")
Schema = dict[str, Any]
_DEG = math.degrees(1.0)
# The unit that a field's name ends with, that of the member's, the factor to it.
_UNITS = {
    "": ("", "", 1.0),
    "deg": ("_rad", "_deg", _DEG),
    "deg2": ("_rad2", "_deg2", _DEG**2),
    "arcsec": ("_rad", "_arcsec", _DEG * 3600.0),
    "km": ("_m", "_km", 1e-3),
    "utc": ("_utc", "", 1.0),
}
_TYPES = {"f": "float", "i": "int", "b": "bool"}  # of arrays, by NumPy's kind
_INTERNAL = "internal"


@dataclasses.dataclass(frozen=True)
class Member:
    """unit: one of `_UNITS`.  least, greatest: of the number written; any of either sign without.

    decimals: that it is rounded to; None for as many as it has.  axes: of an array.  gaps: that NaN
    is among its numbers, written as null.  called: the member's name, where not by its unit.
    """

    unit: str = ""
    least: float | None = None
    greatest: float | None = None
    decimals: int | None = None
    axes: int = 1
    gaps: bool = False
    called: str = ""

    def name(self, ours: str) -> str:
        """The member's, of a field's name."""
        end, member_end, _ = _UNITS[self.unit]
        return self.called or (re.sub(f"{end}(?=_|$)", member_end, ours) if end else ours)

    def __get_pydantic_core_schema__(
        self, source: object, handler: Callable[[object], Schema]
    ) -> Schema:
        if source is int or source is float:
            number = self._schema(source.__name__)
            differs = self.unit or self.decimals is not None
            return written(self._number, number) if differs else number
        if (scalar := _scalar_of(source)) is not None:
            lists = self._schema(_TYPES[np.dtype(scalar).kind])
            if self.gaps:
                lists = {"type": "nullable", "schema": lists}
            for _ in range(self.axes):
                lists = {"type": "list", "items_schema": lists}
            return written(self._lists, lists)
        if hasattr(source, "scaled"):
            factor = _UNITS[self.unit][2]
            return written(lambda found: found.scaled(factor, self.decimals), handler(source))
        return handler(source)

    def _schema(self, kind: str) -> Schema:
        if kind == "bool":
            return {"type": kind}
        told: Schema = {"minimum": self.least, "maximum": self.greatest}
        told = {name: end for name, end in told.items() if end is not None}
        told = told or {"x-range": "any, of either sign"}
        return {"type": kind, "metadata": {"pydantic_js_updates": told}}  # made, not validated

    def _number(self, value: float) -> float:
        converted = value * _UNITS[self.unit][2]
        return converted if self.decimals is None else round(converted, self.decimals) + 0.0

    def _lists(self, values: NDArray[Any]) -> list[Any]:
        if self.unit:
            values = values * _UNITS[self.unit][2]
        if self.decimals is not None:
            values = np.round(values, self.decimals) + 0.0  # no -0.0
            if self.greatest == 360.0:
                values = values % 360.0  # what rounds to a whole turn is north
        lists: list[Any] = values.tolist()
        return lists


def _scalar_of(source: object) -> Any:  # noqa: ANN401 (a scalar type of NumPy)
    """What an array's type holds, None of other types; `NDArray` is a type of its own since 2.5."""
    origin, parts = get_origin(source), get_args(source)
    if origin is NDArray:
        return parts[0]
    return get_args(parts[1])[0] if origin is np.ndarray else None


Internal = Annotated[T, _INTERNAL]
Text = Annotated[str, Member()]
Count = Annotated[int, Member(least=0)]
Signed = Annotated[float, Member()]
NotNegative = Annotated[float, Member(least=0.0)]
Share = Annotated[float, Member(least=0.0, greatest=1.0)]
# 1e-9 deg is 4 microarcsec, 1/25,000 of what a table promises.
Angle = Annotated[float, Member("deg", decimals=9)]
AngleSize = Annotated[float, Member("deg", 0.0, decimals=9)]
HalfTurn = Annotated[float, Member("deg", 0.0, 180.0, decimals=9)]
Elevation = Annotated[float, Member("deg", -90.0, 90.0, decimals=9)]
Arcsec = Annotated[float, Member("arcsec", 0.0, decimals=9)]
Km = Annotated[float, Member("km", 0.0, decimals=9)]

# In degrees already, or of a unit vector; told as they are.
TurnDeg = Annotated[float, Member(least=0.0, greatest=360.0)]
HalfTurnDeg = Annotated[float, Member(least=0.0, greatest=180.0)]
ElevationDeg = Annotated[float, Member(least=-90.0, greatest=90.0)]
ElevationOrLimbDeg = Annotated[float, Member(least=-90.0, greatest=180.0)]
LongitudeDeg = Annotated[float, Member(least=-180.0, greatest=180.0)]
DirectionPart = Annotated[float, Member(least=-1.0, greatest=1.0)]

# Columns, an entry a row; null where nothing is known.  1e-6 deg is 0.1 m on the ground.
Latitudes = Annotated[Array, Member("deg", -90.0, 90.0, decimals=6, gaps=True)]
Longitudes = Annotated[Array, Member("deg", -180.0, 180.0, decimals=6, gaps=True)]
Angles = Annotated[Array, Member("deg", decimals=6, gaps=True)]
HalfTurns = Annotated[Array, Member("deg", 0.0, 180.0, decimals=6, gaps=True)]
Lengths = Annotated[Array, Member(least=0.0, decimals=3, gaps=True)]
Heights = Annotated[Array, Member(decimals=3, gaps=True)]
Motions = Annotated[Array, Member("deg", decimals=9)]
Times = Annotated[Array, Member(least=0.0)]


@dataclass_transform(frozen_default=True, kw_only_default=True)
def answer(cls: type[T]) -> type[T]:
    """A frozen, keyword-only dataclass that answers hold as it is."""
    cls.__get_pydantic_core_schema__ = classmethod(_core_schema)  # type: ignore[attr-defined]
    return dataclasses.dataclass(frozen=True, kw_only=True)(cls)


def member_names(kind: type) -> dict[str, str]:
    """A class's members in answers by the names of its fields; none where it isn't an `@answer`."""
    if not (dataclasses.is_dataclass(kind) and hasattr(kind, "__get_pydantic_core_schema__")):
        return {}
    return {name: _mark(hint).name(name) for name, hint in _members(kind).items()}


def _core_schema(cls: type, source: object, handler: Any) -> Schema:  # noqa: ANN401 (pydantic's)
    members, names = _members(cls), member_names(cls)
    return {
        "type": "dataclass",
        "cls": cls,
        "ref": f"{cls.__module__}.{cls.__qualname__}:{id(cls)}",
        "fields": [*members],
        "schema": {
            "type": "dataclass-args",
            "dataclass_name": cls.__name__,
            "fields": [
                {
                    "type": "dataclass-field",
                    "name": name,
                    "schema": handler.generate_schema(hint),
                    "validation_alias": names[name],  # that of the schema, as FastAPI asks for it
                    "serialization_alias": names[name],
                }
                for name, hint in members.items()
            ],
        },
    }


def _members(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    names = [
        field.name
        for field in dataclasses.fields(kind)
        if _INTERNAL not in getattr(hints[field.name], "__metadata__", ())
    ]
    members: dict[str, Any] = {}
    for owner in reversed(kind.__mro__):
        declared = inspect.get_annotations(owner)
        members |= {name: hints[name] for name in names if name in declared}
        for name, one in vars(owner).items():
            if isinstance(one, property):
                hint = get_type_hints(one.fget, include_extras=True)["return"]
                if any(_marks(hint)):
                    members[name] = hint
    return members


def _mark(hint: object) -> Member:
    return next(_marks(hint), Member())


def _marks(hint: object) -> Iterator[Member]:
    """Those anywhere in a type."""
    for part in get_args(hint):
        if isinstance(part, Member):
            yield part
        else:
            yield from _marks(part)


def written(function: Callable[[Any], Any], schema: Schema) -> Schema:
    """The schema of what a function makes of a value for an answer."""
    writer = {"type": "function-plain", "function": function, "return_schema": schema}
    return schema | {"serialization": writer}
