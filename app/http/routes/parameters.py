"""Parameters and headers of the resources that jobs make; a misspelled parameter is refused."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Annotated, TypeVar

from fastapi import Depends, Header, Path, Query
from pydantic import AfterValidator, Field, create_model

from app.http.query import Parameters
from app.ids import JobState, is_id
from planner.base.errors import InvalidInput
from planner.world.frames.time_scales import utc_from_text
from planner.world.platforms import PIXELS_ARCSEC

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
    """Which plans to list."""

    limit: int = Field(default=50, ge=1, le=LIST_MAX, description="The largest number to list.")
    cursor: PlanId | None = Field(default=None, description="`next` of the list before.")
    state: JobState | None = Field(default=None, description="Only those in this state.")
    name: str | None = Field(
        default=None, min_length=1, max_length=200, description="Only those with this in the name."
    )
    target: str | None = Field(
        default=None,
        min_length=1,
        max_length=200,
        description="Only those with this in a target's name, id or words; case doesn't matter.",
    )
    text: str | None = Field(
        default=None,
        min_length=1,
        max_length=200,
        description="Only those with this in the name, the platform's name or a target's; case "
        "doesn't matter.",
    )
    after: QueryTime | None = Field(
        default=None,
        description="Only those that end after this time: their `stop`, not when they were made.",
    )
    before: QueryTime | None = Field(
        default=None,
        description="Only those that begin before this time: their `start`, not when they were "
        "made. With `after`: all that lie in between, in part or in whole.",
    )


class PlanListQuery(ListQuery):
    """Which plans to list, where campaigns make some."""

    campaign: PlanId | None = Field(
        default=None,
        description="List only the passes of this campaign; without it, no passes are listed.",
    )


class TableQuery(Parameters):
    """In which format to hand a table out."""

    format: str | None = None


class ViewQuery(TableQuery):
    """How closely to look at a plan, and in which format to show it."""

    step_s: float | None = Field(
        default=None,
        gt=0.0,
        allow_inf_nan=False,
        description="Time between rows of JSON and NetCDF, a multiple of 0.2 s; unless given, the "
        "least that shows at most 1,000 rows.",
    )
    pixel_arcsec: float | None = Field(
        default=None,
        ge=PIXELS_ARCSEC[0],
        le=PIXELS_ARCSEC[1],
        allow_inf_nan=False,
        description="Angle that a pixel covers, for the ground samples of JSON and NetCDF; "
        "unless given, that of the platform's camera.",
    )


class PostQuery(TableQuery):
    """How to plan."""

    dry_run: bool = Field(
        default=False, description="Only check whether it can be flown; nothing is kept."
    )
    revises: PlanId | None = Field(
        default=None,
        description="The plan this one replaces: it becomes the next revision, the old one stays.",
    )


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
