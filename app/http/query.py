"""Query parameters, each given once, and none where none is known."""

from collections import Counter
from typing import Any
from urllib.parse import unquote_to_bytes

from fastapi import Request

from planner.base.errors import FieldError, InvalidRequest


async def require_sound_query(request: Request) -> None:
    """Refuse what is given twice, and whatever is given to a route that takes nothing."""
    try:
        unquote_to_bytes(request.scope["query_string"]).decode()
    except UnicodeDecodeError:
        detail = "must be UTF-8 text, its other characters written as %XX"
        raise InvalidRequest(FieldError(field="query", detail=detail)) from None
    times = Counter(name for name, _ in request.query_params.multi_items())
    route: Any = request.scope["route"]
    errors = [
        FieldError(field=f"query.{name}", detail=f"is given {count} times; send it once")
        for name, count in times.items()
        if count > 1
    ]
    whole = route.dependant
    if not any(one.query_params for one in (whole, *whole.dependencies)):
        detail = "is not known here; remove it or correct its name"
        errors += [FieldError(field=f"query.{name}", detail=detail) for name in times]
    if errors:
        raise InvalidRequest(*errors)
