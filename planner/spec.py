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
