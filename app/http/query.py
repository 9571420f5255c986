"""Query parameters: each one known, given once, written as documented."""

import re
from collections import Counter
from typing import Any
from urllib.parse import unquote_to_bytes

from fastapi import Request
from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator
from pydantic_core import PydanticKnownError

from app.requests.plain_text import require_plain
from planner.base.errors import FieldError, InvalidRequest

_WHOLE = re.compile(r"-?[0-9]{1,18}", re.ASCII)
_NUMBER = re.compile(r"-?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


class Parameters(BaseModel):
    """Of one route; a misspelled one is refused, not ignored, and so is one half understood."""

    model_config = ConfigDict(extra="forbid")

    @field_validator("*", mode="before")
    @classmethod
    def _require_documented_form(cls, value: object, info: ValidationInfo) -> object:
        if isinstance(value, str) and info.field_name is not None:
            annotation = cls.model_fields[info.field_name].annotation
            if annotation is int and not _WHOLE.fullmatch(value):
                raise PydanticKnownError("int_parsing")
            if annotation in (float, float | None) and not _NUMBER.fullmatch(value):
                raise PydanticKnownError("float_parsing")
            if annotation is bool and value not in ("true", "false"):
                raise PydanticKnownError("bool_parsing")
            require_plain(value)
        return value


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
