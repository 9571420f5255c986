"""Parameters and headers of the resources that jobs make; a misspelled parameter is refused."""

import re
from collections.abc import Awaitable, Callable, Mapping
from typing import Annotated, Any, TypeVar

from fastapi import Depends, Header, Path, Query
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationInfo,
    create_model,
    field_validator,
)
from pydantic_core import PydanticKnownError

from app.http.openapi.fields import entries
from app.ids import JobState, is_id
from app.requests.plain_text import require_plain
from planner.base.errors import InvalidInput
from planner.world.frames.time_scales import utc_from_text
from planner.world.platforms import PIXELS_ARCSEC

_WHOLE = re.compile(r"-?[0-9]{1,18}", re.ASCII)
_NUMBER = re.compile(r"-?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


class Parameters(BaseModel):
    """Of one route; a misspelled one is refused, not ignored, and so is one half understood.

    Their texts stand in their class's docstring, as those of requests' fields.
    """

    model_config = ConfigDict(extra="forbid")

    def __init_subclass__(cls, **_: Any) -> None:  # noqa: ANN401 (pydantic's)
        own = cls.__annotations__
        for names, text in entries(cls, own):
            for name in names:
                own[name] = Annotated[own[name], Field(description=text)]

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


Asked = TypeVar("Asked", bound=Parameters)

LIST_MAX = 200
_KEY_CHARACTERS_MAX = 255


def _id(text: str) -> str:
    if not is_id(text):
        raise ValueError("must be an id, as an answer names it")
    return text


PlanId = Annotated[str, AfterValidator(_id)]
PathId = Annotated[
    PlanId, Path(alias="id", description="Its id, as the answer that made it gives it.")
]


def _time(text: str) -> str:
    utc_from_text(text)
    return text


QueryTime = Annotated[
    str,
    AfterValidator(_time),
    Field(json_schema_extra={"format": "date-time"}, examples=["2015-02-27T17:00:00Z"]),
]


class ListQuery(Parameters):
    """Which plans to list.

    limit: the largest number to list.
    cursor: `next` of the list before.
    state: only those in this state.
    name: only those with this in the name.
    target: only those with this in a target's name, id or words; case doesn't matter.
    text: only those with this in the name, the platform's name or a target's; case doesn't matter.
    after: only those that end after this time: their `stop`, not when they were made.
    before: only those that begin before this time: their `start`, not when they were made. With
    `after`: all that lie in between, in part or in whole.
    """

    limit: int = Field(default=50, ge=1, le=LIST_MAX)
    cursor: PlanId | None = None
    state: JobState | None = None
    name: str | None = Field(default=None, min_length=1, max_length=200)
    target: str | None = Field(default=None, min_length=1, max_length=200)
    text: str | None = Field(default=None, min_length=1, max_length=200)
    after: QueryTime | None = None
    before: QueryTime | None = None


class PlanListQuery(ListQuery):
    """Which plans to list, where campaigns make some.

    campaign: list only the passes of this campaign; without it, no passes are listed.
    """

    campaign: PlanId | None = None


class TableQuery(Parameters):
    """In which format to hand a table out."""

    format: str | None = None


class ViewQuery(TableQuery):
    """How closely to look at a plan, and in which format to show it.

    step_s: time between rows of JSON and NetCDF, a multiple of 0.2 s; unless given, the least that
    shows at most 1,000 rows.
    pixel_arcsec: angle that a pixel covers, for the ground samples of JSON and NetCDF; unless
    given, that of the platform's camera.
    """

    step_s: float | None = Field(default=None, gt=0.0, allow_inf_nan=False)
    pixel_arcsec: float | None = Field(
        default=None, ge=PIXELS_ARCSEC[0], le=PIXELS_ARCSEC[1], allow_inf_nan=False
    )


class PostQuery(TableQuery):
    """How to plan.

    dry_run: only check whether it can be flown; nothing is kept.
    revises: the plan this one replaces: it becomes the next revision, the old one stays.
    """

    dry_run: bool = False
    revises: PlanId | None = None


def read_query(model: type[Asked]) -> Callable[[Asked], Awaitable[Asked]]:
    """A dependency: the parameters of a query, read as this model has them."""

    async def query(asked: Annotated[model, Query()]) -> Asked:  # type: ignore[valid-type]
        return asked

    return query


def with_formats(query: type[TableQuery], text: str, titles: Mapping[str, str]) -> type[TableQuery]:
    """The same parameters, `format` one of those that have a title; text: what it chooses."""

    def require_registered(name: str) -> str:
        if name not in titles:
            raise ValueError(f"must be one of {', '.join(titles)}")
        return name

    told = "; ".join(f"`{name}` {title}" for name, title in titles.items())
    field = Field(
        default=None,
        description=f"{text}, whatever the Accept header says: {told}",
        json_schema_extra={"enum": [*titles]},
    )
    return create_model(
        query.__name__,
        __base__=query,
        __doc__=query.__doc__,
        format=(Annotated[str, AfterValidator(require_registered)] | None, field),
    )


Prefer = Annotated[
    str | None,
    Header(
        description="`wait=N`: answer 202 when it isn't done within N seconds (30 by default, at "
        "most 60); `respond-async`, `wait=0`: answer 202 at once."
    ),
]


async def idempotency_key(
    key: Annotated[
        str | None,
        Header(
            alias="Idempotency-Key",
            description="The same key and request again get the same plan, not another one.",
        ),
    ] = None,
) -> str | None:
    if key is not None and not (0 < len(key) <= _KEY_CHARACTERS_MAX and key.isprintable()):
        raise InvalidInput(
            f"must have 1 to {_KEY_CHARACTERS_MAX} printable characters",
            field="header.Idempotency-Key",
        )
    return key


IdempotencyKey = Annotated[str | None, Depends(idempotency_key)]


def last_event_id(
    seq: Annotated[
        str | None,
        Header(alias="Last-Event-ID", description="Only what comes after this event."),
    ] = None,
) -> int:
    """The header's number; 0 without one."""
    if seq is None or seq == "":
        return 0
    if not (seq.isascii() and seq.isdecimal() and len(seq) <= 9):
        raise InvalidInput("must be the id of an event", field="header.Last-Event-ID")
    return int(seq)
