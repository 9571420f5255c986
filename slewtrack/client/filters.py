"""The filters of a service's lists."""

from collections.abc import Mapping
from datetime import datetime
from typing import TypedDict


class Filters(TypedDict, total=False):
    """Each left out or None lets everything through.

    state: queued, running, done, refused, failed or cancelled.
    name: is a part of the name.  target: of a target's.  text: of the name, platform's or a
    target's.
    after: those that end after this time; before: those that begin before it.  Both are of what
    was asked for, not of when it came: UTC text or an aware datetime.
    campaign: id of one, whose passes are listed; plans of the platform only.
    """

    state: str | None
    name: str | None
    target: str | None
    text: str | None
    after: datetime | str | None
    before: datetime | str | None
    campaign: str | None


def query_of(filters: Mapping[str, object]) -> dict[str, str]:
    """As the service takes them; raises ValueError for a time without its zone."""
    return {name: _text(name, value) for name, value in filters.items() if value is not None}


def _text(name: str, value: object) -> str:
    if not isinstance(value, datetime):
        return str(value)
    if value.utcoffset() is None:
        raise ValueError(f"{name} must be an aware datetime, as datetime(..., tzinfo=UTC) is")
    return value.isoformat()
