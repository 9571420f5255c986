"""Query parameters of the resources that hold plans; a misspelled one is refused."""

from collections.abc import Mapping
from typing import Annotated, TypeVar

from fastapi import Header, Path
from pydantic import AfterValidator, Field, create_model

from app.http.query import Parameters
from app.http.routes.resources import PlanResource
from app.store.ids import JobState, is_id
from app.store.list_filter import ListFilter
from planner.base.errors import InvalidInput
from planner.world.frames.time_scales import utc_from_text
from planner.world.platforms import PIXELS_ARCSEC

LIST_MAX = 200
_KEY_CHARACTERS_MAX = 255


def _id(text: str) -> str:
    if not is_id(text):
        raise ValueError("must be the id of a plan, such as an answer names it")
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

    def list_filter(self) -> ListFilter:
        """What the store looks for."""
        return ListFilter(
            state=self.state,
            name=self.name,
            target=self.target,
            text=self.text,
            begins_before_utc=None if self.before is None else utc_from_text(self.before),
            ends_after_utc=None if self.after is None else utc_from_text(self.after),
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


class PlanViewQuery(ViewQuery):
    """How closely to look at a plan, and in which format to show it."""

    pixel_arcsec: float | None = Field(
        default=None,
        ge=PIXELS_ARCSEC[0],
        le=PIXELS_ARCSEC[1],
        allow_inf_nan=False,
        description="Angle that a pixel covers, for the ground samples of JSON and NetCDF; "
        "unless given, that of the platform's camera.",
    )


Formatted = TypeVar("Formatted", bound=TableQuery)


class PostQuery(TableQuery):
    """How to plan."""

    dry_run: bool = Field(
        default=False, description="Only check whether it can be flown; nothing is kept."
    )
    revises: PlanId | None = Field(
        default=None,
        description="The plan this one replaces: it becomes the next revision, the old one stays.",
    )


def with_formats(
    query: type[Formatted], text: str, title_by_name: Mapping[str, str]
) -> type[Formatted]:
    """The same parameters, `format` one of these; text: what it chooses."""
    names = list(title_by_name)

    def require_registered(name: str) -> str:
        if name not in names:
            raise ValueError(f"must be one of {', '.join(names)}")
        return name

    titles = "; ".join(f"`{name}` {title}" for name, title in title_by_name.items())
    field = Field(
        default=None,
        description=f"{text}, whatever the Accept header says: {titles}",
        json_schema_extra={"enum": [*names]},
    )
    return create_model(
        query.__name__,
        __base__=query,
        __doc__=query.__doc__,
        format=(Annotated[str, AfterValidator(require_registered)] | None, field),
    )


def with_table_formats(query: type[Formatted], resource: PlanResource) -> type[Formatted]:
    """The same parameters, `format` one of those of a resource's tables."""
    titles = {name: exporter.title for name, exporter in resource.exporters.items()}
    return with_formats(query, "The table by itself in this format", titles)


async def idempotency_key(
    key: Annotated[
        str | None,
        Header(
            alias="Idempotency-Key",
            description="The same key and request again get the same plan, not another one.",
        ),
    ] = None,
) -> str | None:
    """The header, when it is one."""
    if key is not None and not (0 < len(key) <= _KEY_CHARACTERS_MAX and key.isprintable()):
        raise InvalidInput(
            f"must have 1 to {_KEY_CHARACTERS_MAX} printable characters",
            field="header.Idempotency-Key",
        )
    return key


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
