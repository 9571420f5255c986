"""JSON members read as the fields of a dataclass, by their types."""

import json
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from datetime import datetime
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

T = TypeVar("T")
Members = Mapping[str, Any]

# What reading JSON of another shape raises: of no JSON, too deep, or with other types in it.
MISREAD = (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)
_FORMS = {
    "id": re.compile(r"[0-9A-Za-z-]{1,100}"),  # such as is put into an address
    "state": re.compile("queued|running|done|refused|failed|cancelled"),
}


class ParsedAnswer(dict[str, Any]):
    """The members of a JSON object, with the text that holds them; raises one of MISREAD."""

    def __init__(self, text: bytes) -> None:
        super().__init__(object_of(json.loads(text)))
        self.text = text


def read(kind: type[T], members: Members) -> T:
    """The value of its JSON; a field `members` is given all of it; raises one of MISREAD.

    A field with a default takes it where the member is missing or null.
    """
    values: dict[str, Any] = {}
    plain: type = kind
    for name, (hint, is_needed) in _fields(plain).items():
        if name == "members":
            values[name] = members
        elif is_needed or members.get(name) is not None:
            values[name] = _value(hint, members[name])
            if name in _FORMS and not _FORMS[name].fullmatch(values[name]):
                raise ValueError
    return kind(**values)


def read_list(kind: type[T], members: Members, name: str) -> list[T]:
    """The objects of one of its members; raises one of MISREAD."""
    if not isinstance(members[name], list):
        raise TypeError
    return [read(kind, object_of(one)) for one in members[name]]


def object_of(value: object) -> Members:
    """Raises TypeError for anything else that JSON holds."""
    if not isinstance(value, dict):
        raise TypeError
    return value


@cache
def _fields(kind: type) -> dict[str, tuple[Any, bool]]:
    """Types by name, and whether there is no default."""
    hints = get_type_hints(kind)
    return {
        one.name: (hints[one.name], one.default is one.default_factory)  # both MISSING
        for one in fields(kind)
        if one.init
    }


def _value(hint: Any, value: Any) -> Any:  # noqa: ANN401 (whatever JSON holds)
    kinds = get_args(hint)
    origin = get_origin(hint)
    if origin in (Union, UnionType):
        if value is None and NoneType in kinds:
            return None
        [hint, *others] = [one for one in kinds if one is not NoneType]
        is_read = not others or (is_dataclass(hint) and isinstance(value, dict))
        return _value(hint, value) if is_read else _plain((hint, *others), value)
    if origin is tuple:
        if not isinstance(value, list):
            raise TypeError
        return tuple(_value(kinds[0], one) for one in value)
    if hasattr(hint, "of_json"):
        return hint.of_json(object_of(value))
    if isinstance(hint, type) and is_dataclass(hint):
        return read(hint, object_of(value))
    if hint is datetime:
        return datetime.fromisoformat(value)
    if origin is Mapping:
        return {name: _value(kinds[1], one) for name, one in object_of(value).items()}
    return value if hint is Any else _plain((hint,), value)


def _plain(kinds: tuple[Any, ...], value: Any) -> Any:  # noqa: ANN401 (whatever JSON holds)
    if float in kinds and int not in kinds and type(value) is int:
        return float(value)
    if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
        raise TypeError
    return value
