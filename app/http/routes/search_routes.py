"""Routes of searches: posted, kept, read again in pages, removed.

The same for every resource that holds what a search found.
"""

import hashlib
import json
import zlib
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated, Any, NamedTuple, Self

import anyio.to_thread
from fastapi import APIRouter, Depends, HTTPException, Request, Response
from fastapi.responses import StreamingResponse
from pydantic import AfterValidator, Field, create_model, model_validator
from sqlalchemy import Connection

from app.answers.job import list_class
from app.answers.members import provenance
from app.answers.opportunities_geojson import FeatureCollection
from app.http.blocking import in_child, read
from app.http.negotiation import (
    ONLY_JSON,
    is_known_already,
    json_body,
    not_modified,
    preferred_type,
    revalidated,
    saved_as,
)
from app.http.openapi.schema import REF, json_body_of
from app.http.query import Parameters
from app.http.routes.job_routes import (
    add_list,
    add_request,
    answer_removal,
    find_job,
    job_of,
    new_job,
    tag_for_good,
)
from app.http.routes.parameters import Asked, PathId, read_query
from app.http.routes.resources import JobResource
from app.jobs.child import Bounds
from app.store import audit, jobs, results
from app.store.database import Database
from app.store.jobs import NewJob
from app.store.packed import unzip
from app.work.searches import (
    CSV,
    GEOJSON,
    JSON,
    PAGE_WINDOWS,
    PROBABILITY,
    REASONS,
    VIEW,
    FoundSearch,
    Page,
    WindowsAsked,
    closed,
    find_windows,
    members_of,
    opened,
    read_windows,
    search_json,
)
from planner.base.errors import InvalidInput

PAGE_MAX = 10_000
PROBABLE_MAX = 500  # windows whose probability one request may ask for: three seconds
STREAMED = 2000  # windows that are told of at a time where all are asked for
SEARCH_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)
_SUFFIXES = {GEOJSON: ".geojson", CSV: ".csv"}
FORMS = (JSON, *_SUFFIXES)

SEARCH_LIST = list_class("SearchList", "opportunities", "Searches for opportunities")


@dataclass(frozen=True, kw_only=True)
class SearchResource(JobResource):
    """One that holds what searches found.

    windows_response: of some of what was found.  included: what `include` may ask for.
    """

    singular: str = "search for opportunities"
    plural: str = "searches"
    list_response: type = SEARCH_LIST
    summary: str
    windows_response: type
    included: tuple[str, ...]


class FirstWindowsQuery(Parameters):
    """What to tell of the first windows."""

    limit: int = Field(
        default=PAGE_WINDOWS,
        ge=1,
        le=PAGE_MAX,
        description="The largest number of windows of JSON's page; at most 500 with `probability`.",
    )
    include: str = ""

    @model_validator(mode="after")
    def _require_few(self) -> Self:
        if PROBABILITY in self.include.split(",") and self.limit > PROBABLE_MAX:
            raise InvalidInput(
                f"must be at most {PROBABLE_MAX} with include={PROBABILITY}; ask for the rest by "
                "`cursor`",
                field="query.limit",
            )
        return self

    def asked(self, media_type: str) -> WindowsAsked:
        """As the work is told; the other forms are of what is seen."""
        pages = {name: getattr(self, name) for name in ("cursor", "target") if hasattr(self, name)}
        include = frozenset(self.include.split(",")) - {""}
        if media_type == JSON:
            return WindowsAsked(limit=self.limit, include=include, **pages)
        return WindowsAsked(
            media_type=media_type,
            limit=self.limit if pages else STREAMED,
            include=(include | {VIEW}) - {PROBABILITY},
            **pages,
        )


class WindowsQuery(FirstWindowsQuery):
    """Which windows, and what to tell of them."""

    cursor: int = Field(
        default=0, ge=0, le=10**9, description="`next` of the page before; 0 for the first."
    )
    target: str | None = Field(
        default=None,
        min_length=1,
        max_length=200,
        description="Only windows of the target with this id.",
    )


_TEXTS = {
    VIEW: "the greatest elevation, what is seen at the closest approach and through the window, "
    "the target's place and sky",
    PROBABILITY: "that the target stays in the frame",
    REASONS: "the causes that leave targets without windows",
}


def _including(query: type[Asked], names: Sequence[str]) -> Callable[[Asked], Awaitable[Asked]]:
    """A dependency: these parameters, `include` of these names."""

    def require_known(text: str) -> str:
        if text and not set(text.split(",")) <= set(names):
            raise ValueError(f"must be one or more of {', '.join(names)}, with commas between")
        return text

    told = "; ".join(f"`{name}` {_TEXTS[name]}" for name in names)
    field = Field(
        default="",
        description="What is told beyond edges and session, with commas between: "
        f"{told}. GeoJSON and CSV always tell of the view, and of no probability.",
        examples=[",".join(names)],
    )
    return read_query(
        create_model(
            query.__name__,
            __base__=query,
            __doc__=query.__doc__,
            include=(Annotated[str, AfterValidator(require_known)], field),
        )
    )


def search_routes(resource: SearchResource) -> APIRouter:
    """All routes of a resource."""
    router = APIRouter(tags=[resource.tag], prefix=resource.path)
    _add_post(router, resource)
    add_list(router, resource)
    _add_one(router, resource)
    _add_windows(router, resource)
    add_request(router, resource)
    _add_delete(router, resource)
    return router


def _in_all_forms(description: str) -> dict[str, Any]:
    geojson = {"schema": {"$ref": REF.format(model=FeatureCollection.__name__)}}
    csv: dict[str, Any] = {"schema": {"type": "string"}}
    return {"description": description, "content": {JSON: {}, GEOJSON: geojson, CSV: csv}}


def _add_post(router: APIRouter, resource: SearchResource) -> None:
    @router.post(
        "",
        summary=resource.summary,
        response_model=resource.response,
        responses={
            200: _in_all_forms(
                "What was found, and the first windows; all of them as GeoJSON or as a pass table "
                "in CSV if `Accept` asks"
            )
        },
        openapi_extra=json_body_of(resource.requests, resource.examples),
    )
    async def post(
        request: Request,
        body: Annotated[bytes, Depends(json_body)],
        query: Annotated[
            FirstWindowsQuery, Depends(_including(FirstWindowsQuery, resource.included))
        ],
    ) -> Response:
        """Windows are found to the millisecond, with the limits that open and close each.

        The search is kept under `id`, at Location; windows come in pages.
        """
        media_type = preferred_type(request, FORMS)
        begun_utc = datetime.now(UTC)
        spec = await anyio.to_thread.run_sync(resource.requests.read, body)
        origin, asked = provenance(begun_utc, body), query.asked(media_type)
        found, page = await in_child(
            request, SEARCH_BOUNDS, find_windows, resource.kind, spec, origin, asked
        )
        new = new_job(request, resource, spec, body, deadline_s=SEARCH_BOUNDS.deadline_s)
        database: Database = request.app.state.database
        await database.answer(_keep, database, new, begun_utc, found)
        headers = {"Location": f"{resource.path}/{new.id}", "Vary": "Accept"}
        whole = _Whole(resource, new.id, body, found, asked)
        return _first_answer(request, whole, page, headers)


class _Whole(NamedTuple):
    """All that was found, and what is asked of it.  body: the search's request."""

    resource: SearchResource
    search_id: str
    body: bytes
    found: FoundSearch
    asked: WindowsAsked

    async def page(self, request: Request, cursor: int) -> Page:
        """Told in a child."""
        asked = replace(self.asked, cursor=cursor)
        edges, kind = self.found.edges, self.resource.kind
        return await in_child(request, SEARCH_BOUNDS, read_windows, kind, self.body, edges, asked)


def _first_answer(
    request: Request, whole: _Whole, page: Page, headers: Mapping[str, str]
) -> Response:
    """Of JSON the first page, of others all as it is told."""
    media_type = whole.asked.media_type
    if media_type == JSON:
        answer = search_json(whole.search_id, whole.found, page)
        return Response(answer, HTTPStatus.OK, headers, JSON)
    members = members_of(whole.search_id, whole.found.head)

    async def parts() -> AsyncIterator[bytes]:
        told = page
        yield opened(media_type, members, page.reasons) + told.windows
        while told.next is not None:
            told = await whole.page(request, told.next)
            yield (b"" if media_type == CSV else b",") + told.windows
        yield closed(media_type, None)

    headers = {**headers, **_saved(whole.found.head, media_type)}
    return StreamingResponse(parts(), HTTPStatus.OK, headers, media_type)


def _saved(head: bytes, media_type: str) -> dict[str, str]:
    """The header that names a file after its search."""
    if media_type == JSON:
        return {}
    return saved_as(json.loads(head)["name"], "opportunities", _SUFFIXES[media_type])


def _keep(database: Database, new: NewJob, begun_utc: datetime, found: FoundSearch) -> None:
    with database.writing() as connection:
        jobs.record_done(connection, new, begun_utc)
        results.store(connection, new.id, [zlib.compress(found.head), found.edges])
        audit.record(connection, key_id=new.key_id, action=f"{new.kind}.accept", subject=new.id)


def _add_one(router: APIRouter, resource: SearchResource) -> None:
    @router.get(
        "/{id}",
        summary="Get a search",
        response_model=resource.response,
        responses={
            200: _in_all_forms(
                "As the answer to its POST; all windows in another form if `Accept` asks"
            )
        },
    )
    async def get_search(
        request: Request,
        search_id: PathId,
        query: Annotated[
            FirstWindowsQuery, Depends(_including(FirstWindowsQuery, resource.included))
        ],
    ) -> Response:
        """A search never changes."""
        asked = query.asked(preferred_type(request, FORMS))
        tag = _tag(search_id, asked)
        if is_known_already(request, tag):
            await find_job(request, resource, search_id)
            return not_modified(tag)
        whole = await _find(request, resource, search_id, asked)
        return _first_answer(request, whole, await whole.page(request, 0), revalidated(tag))


def _add_windows(router: APIRouter, resource: SearchResource) -> None:
    @router.get(
        "/{id}/windows",
        summary="List windows of a search",
        response_model=resource.windows_response,
        responses={
            200: _in_all_forms("A page of the windows; in another form if `Accept` asks")
            | {
                "headers": {
                    "Link": {
                        "description": 'Of the next page, `rel="next"`; missing on the last',
                        "schema": {"type": "string"},
                    }
                }
            }
        },
    )
    async def get_windows(
        request: Request,
        search_id: PathId,
        query: Annotated[WindowsQuery, Depends(_including(WindowsQuery, resource.included))],
    ) -> Response:
        """They follow the order of the request's targets, those of each target in order of time."""
        asked = query.asked(media_type := preferred_type(request, FORMS))
        tag = _tag(search_id, asked)
        if is_known_already(request, tag):
            await find_job(request, resource, search_id)
            return not_modified(tag)
        whole = await _find(request, resource, search_id, asked)
        page = await whole.page(request, asked.cursor)
        headers = revalidated(tag) | _saved(whole.found.head, media_type)
        if page.next is not None:
            url = request.url.include_query_params(cursor=page.next)
            headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'
        answer = opened(media_type, [], page.reasons) + page.windows
        answer += closed(media_type, page.next)
        return Response(answer, HTTPStatus.OK, headers, media_type)


def _add_delete(router: APIRouter, resource: SearchResource) -> None:
    @router.delete(
        "/{id}",
        summary=f"Delete a {resource.singular}",
        status_code=HTTPStatus.NO_CONTENT,
        response_class=Response,
        dependencies=ONLY_JSON,
    )
    async def delete(request: Request, search_id: PathId) -> Response:
        """Only the audit log remembers a search that was deleted."""
        job = await find_job(request, resource, search_id)
        return await answer_removal(request, resource, job)


async def _find(
    request: Request, resource: SearchResource, search_id: str, asked: WindowsAsked
) -> _Whole:
    """As it is kept; raises 404."""

    def reading(connection: Connection) -> _Whole | None:
        job_of(connection, resource, search_id)
        body = jobs.request_of(connection, search_id)
        content = results.get(connection, search_id)
        if body is None or not content:
            return None
        found = FoundSearch(unzip(content[0]), content[1])
        return _Whole(resource, search_id, body, found, asked)

    whole = await read(request, reading)
    if whole is None:  # no job of this kind is without
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return whole


def _tag(search_id: str, asked: WindowsAsked) -> str:
    """Of a page of what was found."""
    told = [asked.media_type, asked.cursor, asked.limit, asked.target, sorted(asked.include)]
    which = hashlib.sha256(json.dumps(told).encode()).hexdigest()[:32]
    return tag_for_good(search_id, which)
