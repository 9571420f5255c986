"""Declares a value so that it is checked once, where it is born."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, dataclass_transform, get_args

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

_IS_KEPT = ContextVar("is_kept", default=False)
_PYDANTIC_CONFIG = {"extra": "forbid", "allow_inf_nan": False, "strict": True}


@dataclasses.dataclass(frozen=True)
class Within:
    """The closed range of a number, in its annotation; of each number of a list or mapping.

    `@spec` refuses what lies outside, and the JSON schema states the range.
    """

    least: float
    greatest: float

    def __str__(self) -> str:
        return f"{_exact(self.least)}..{_exact(self.greatest)}"

    def __get_pydantic_json_schema__(
        self, core_schema: object, handler: Callable[[object], dict[str, Any]]
    ) -> dict[str, Any]:
        return handler(core_schema) | {"minimum": self.least, "maximum": self.greatest}


@dataclasses.dataclass(frozen=True)
class About:
    """What every field of a type is, in the type's annotation; a class's docstring goes before."""

    text: str


# Of a unit vector; wider, so that one not yet divided by its norm is told that.
UnitPart = Annotated[float, Within(-10.0, 10.0)]
# Of a vector of any length whose direction counts.
VectorPart = Annotated[float, Within(-1e6, 1e6)]
LENGTH_MIN = 1e-3  # squares of much smaller ones round to zero, or to few digits


@contextmanager
def as_kept() -> Iterator[None]:
    """Values made inside were accepted before, maybe by a version that let more in.

    So neither their ranges nor what their classes require is asked again.
    """
    token = _IS_KEPT.set(True)
    try:
        yield
    finally:
        _IS_KEPT.reset(token)


def is_kept() -> bool:
    """Whether what is made now is `as_kept`."""
    return _IS_KEPT.get()


@dataclass_transform(frozen_default=True, kw_only_default=True)
def spec(cls: type[T]) -> type[T]:
    """A frozen, keyword-only dataclass of finite numbers within their ranges and aware times.

    The class's `__post_init__`, its own or inherited, runs after these checks and raises
    `ValueError` with the value and the way out; `as_kept` lets it pass what it doesn't.
    `__pydantic_config__` makes pydantic, which only `app` imports, refuse unknown fields, NaN and
    lax conversions.
    """
    own_check = getattr(cls, "__post_init__", None)
    names: list[str] = []
    ranges: list[tuple[str, Within]] = []

    def __post_init__(self: DataclassInstance) -> None:  # noqa: N807 (dataclasses calls it by this name)
        _require_finite_and_aware(self, names)
        if not is_kept():
            for name, within in ranges:
                _require(name, getattr(self, name), within)
        if own_check is not None:
            try:
                own_check(self)  # which may complete it, too, and does so first
            except ValueError:
                if not is_kept():
                    raise

    cls.__post_init__ = __post_init__  # type: ignore[attr-defined]
    cls.__pydantic_config__ = _PYDANTIC_CONFIG  # type: ignore[attr-defined]
    made = dataclasses.dataclass(frozen=True, kw_only=True)(cls)
    for field in dataclasses.fields(made):  # type: ignore[arg-type]  # a dataclass since one line
        found = _ranges(field.type)
        if len(found) > 1:
            raise TypeError(f"{cls.__name__}.{field.name} states more than one range")
        names.append(field.name)
        ranges.extend((field.name, within) for within in found)
    return made


def require_within(checked: object, *ranges: tuple[str, float, float]) -> None:
    """Refuse the first field outside its closed range, where that hangs on other fields.

    Fields that hold None are not given.
    """
    for name, low, high in ranges:
        _require(name, getattr(checked, name), Within(low, high))


def _require_finite_and_aware(checked: DataclassInstance, names: list[str]) -> None:
    for name in names:
        value = getattr(checked, name)
        if isinstance(value, float):
            if not math.isfinite(value):
                raise ValueError(f"{name} must be a finite number, not {value}")
            continue
        for moment in value if isinstance(value, tuple) else (value,):
            if isinstance(moment, datetime) and moment.utcoffset() is None:
                raise ValueError(
                    f"{name} ({moment.isoformat()}) has no UTC offset; append Z if it is UTC"
                )


def _ranges(annotation: object) -> set[Within]:
    """Those anywhere in a field's type."""
    found = {part for part in get_args(annotation) if isinstance(part, Within)}
    return found.union(*map(_ranges, get_args(annotation)))


def _require(name: str, value: object, within: Within) -> None:
    if isinstance(value, Mapping):
        for key, part in value.items():
            _require(f"{name}.{key}", part, within)
    elif isinstance(value, tuple):
        for index, part in enumerate(value):
            _require(f"{name}.{index}", part, within)
    elif isinstance(value, int | float) and not within.least <= value <= within.greatest:
        raise ValueError(f"{name} must lie in {within}, not {value}")


def _exact(value: float) -> str:
    """The shortest text that tells it exactly."""
    return short if float(short := f"{value:g}") == value else repr(value)
