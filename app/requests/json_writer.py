"""Writes a `@spec` value as the JSON that its `JsonReader` reads."""

import dataclasses
from collections.abc import Mapping
from datetime import datetime
from typing import Any, Literal, get_args, get_origin, get_type_hints

from planner.world.frames.time_scales import utc_text


def json_fields(value: object, words: Mapping[str, Any] = {}) -> dict[str, Any]:
    """Its fields by name: those that aren't as by default, and the kind by which it is told apart.

    words: of fields that are to stay as they were sent, since they may be said in several ways:
    a platform by its name, an orbit as a file's content.
    """
    assert dataclasses.is_dataclass(value)
    kinds = get_type_hints(type(value))
    written = {}
    for field in dataclasses.fields(value):
        given = getattr(value, field.name)
        if field.name in words:
            written[field.name] = words[field.name]
        elif _is_kind(kinds[field.name]) or given != _default(field):
            written[field.name] = _plain(given)
    return written


def _is_kind(annotation: object) -> bool:
    return get_origin(annotation) is Literal and len(get_args(annotation)) == 1


def _default(field: "dataclasses.Field[Any]") -> object:
    made = field.default_factory
    return field.default if made is dataclasses.MISSING else made()


def _plain(value: object) -> object:
    if dataclasses.is_dataclass(value):
        return json_fields(value)
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return utc_text(value, 6) if isinstance(value, datetime) else value
