"""How is a value declared so that it is checked once, where it is born?"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, TypeVar, dataclass_transform

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

_PYDANTIC_CONFIG = {"extra": "forbid", "allow_inf_nan": False, "strict": True}


@dataclass_transform(frozen_default=True, kw_only_default=True)
def spec(cls: type[T]) -> type[T]:
    """A frozen, keyword-only dataclass whose numbers are finite.

    The class's own `__post_init__` runs after the finiteness check and raises
    `ValueError` with the value and the way out.  `__pydantic_config__` makes pydantic,
    which only `app` imports, refuse unknown fields, NaN and lax conversions.
    """
    own_check = cls.__dict__.get("__post_init__")

    def __post_init__(self: DataclassInstance) -> None:  # noqa: N807 (dataclasses calls it by this name)
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f"{field.name} must be a finite number, not {value}")
        if own_check is not None:
            own_check(self)

    cls.__post_init__ = __post_init__  # type: ignore[attr-defined]
    cls.__pydantic_config__ = _PYDANTIC_CONFIG  # type: ignore[attr-defined]
    return dataclasses.dataclass(frozen=True, kw_only=True)(cls)


def require_within(checked: object, *ranges: tuple[str, float, float]) -> None:
    """Refuse the first field outside its closed range; fields that hold None are not given."""
    for name, low, high in ranges:
        value = getattr(checked, name)
        if value is not None and not low <= value <= high:
            raise ValueError(f"{name} must lie in {low:g}..{high:g}, not {value}")
