"""Routes of searches: posted, kept, read again in pages, removed.

The same for every resource that holds what a search found.
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, HTTPException, Query, Request, Response
from pydantic import Field
from sqlalchemy import Connection

from app.answers.job import SearchList, search_list_json
from app.answers.members import ProvenanceOut, provenance, to_json
from app.answers.opportunities import FoundWindows, whole_opportunities
from app.answers.opportunities_geojson import FeatureCollection
from app.http.blocking import in_child, read
from app.http.negotiation import (
    JSON,
    accepts_json,
    is_known_already,
    json_body,
    preferred_type,
    weak_tag,
)
from app.http.openapi.schema import REF, request_body
from app.http.query import Parameters
from app.http.routes.jobs import (
    add_removal,
    add_request,
    find_job,
    job_of,
    list_jobs,
    no_such,
)
from app.http.routes.plan_queries import ListQuery, PathId
from app.http.routes.resources import JobResource
from app.http.routes.stored_plans import EXPORT_BOUNDS, saved_as
from app.jobs.child import Bounds
from app.store import audit, jobs, results, searches
from app.store.database import Database
from app.store.ids import new_id
from app.store.jobs import NewJob
from app.store.searches import StoredWindows
from app.versions import VERSION
from app.work.searches import CSV, GEOJSON, windows_in_form

PAGE_MAX = 1000
_SUFFIXES = {GEOJSON: ".geojson", CSV: ".csv"}
FORMS = (JSON, *_SUFFIXES)
# Turning more than this of packed windows into another form would hold the interpreter for long.
_PACKED_MAX_BYTES = 100_000
_UNCHANGED = {"description": "Unchanged, as always: If-None-Match names its ETag"}


@dataclass(frozen=True, kw_only=True)
class SearchResource(JobResource):
    """One that holds what searches found.

    read: the request, which has a `name`, or InvalidRequest.  find: what a child does.
    response: of all that was found; page: of some of it.
    """

    tag: str
    summary: str
    examples: dict[str, tuple[str, dict[str, Any]]]
    read: Callable[[bytes], Any]
    find: Callable[[Any, ProvenanceOut], FoundWindows]
    bounds: Bounds
    response: type
    page: type


class WindowsQuery(Parameters):
    """Which windows."""

    limit: int = Field(
        default=100, ge=1, le=PAGE_MAX, description="The largest number of windows of this page."
    )
    cursor: int = Field(
        default=0, ge=0, le=10**9, description="`next` of the page before; 0 for the first."
    )
    target: str | None = Field(
        default=None,
        min_length=1,
        max_length=200,
        description="Only windows of the target with this id.",
    )


def search_routes(resource: SearchResource) -> APIRouter:
    """All routes of a resource."""
    router = APIRouter(tags=[resource.tag], prefix=resource.path)
    _add_post(router, resource)
    _add_list(router, resource)
    _add_one(router, resource)
    _add_windows(router, resource)
    add_request(router, resource)
    add_removal(router, resource)
    return router


def _in_all_forms(description: str) -> dict[str, Any]:
    geojson = {"schema": {"$ref": REF.format(model=FeatureCollection.__name__)}}
    csv: dict[str, Any] = {"schema": {"type": "string"}}
    return {"description": description, "content": {JSON: {}, GEOJSON: geojson, CSV: csv}}


def _add_post(router: APIRouter, resource: SearchResource) -> None:
    found_at = {"Location": {"description": "Address of the search", "schema": {"type": "string"}}}

    @router.post(
        "",
        summary=resource.summary,
        response_model=resource.response,
        responses={
            200: _in_all_forms(
                "The windows found; as GeoJSON if `Accept` asks, or as a pass table in CSV"
            )
            | {"headers": found_at}
        },
        openapi_extra=request_body(resource.request_schema, resource.examples),
    )
    async def post(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
        """Windows are found to the millisecond, with the limits that open and close each, and the
        view through it.

        The search is kept under `id`, at Location.
        """
        form = preferred_type(request, FORMS)
        begun_utc = datetime.now(UTC)
        spec = await anyio.to_thread.run_sync(resource.read, body)
        origin = provenance(begun_utc, body)
        found = await in_child(request, resource.bounds, resource.find, spec, origin)
        new = NewJob(
            id=new_id(),
            kind=resource.kind,
            name=spec.name,
            listing=resource.listing(spec),
            request=body,
            request_sha256=hashlib.sha256(body).hexdigest(),
            deadline_s=resource.bounds.deadline_s,
            key_id=getattr(request.state, "key_id", None),
        )
        content = await anyio.to_thread.run_sync(searches.packed, found.head, found.windows)
        database: Database = request.app.state.database
        await database.answer(_keep, database, new, begun_utc, content)
        headers = {"Location": f"{resource.path}/{new.id}", "Vary": "Accept"}
        answer = await _whole(request, new.id, found, form)
        return Response(answer, HTTPStatus.OK, headers | _saved(found.head, form), form)


def _saved(head: bytes, form: str) -> dict[str, str]:
    """The header that names a file after its search."""
    if form == JSON:
        return {}
    return saved_as(json.loads(head)["name"], "opportunities", _SUFFIXES[form])


def _keep(database: Database, new: NewJob, begun_utc: datetime, content: Sequence[bytes]) -> None:
    with database.writing() as connection:
        jobs.record_done(connection, new, begun_utc)
        results.store(connection, new.id, content)
        audit.record(connection, key_id=new.key_id, action=f"{new.kind}.accept", subject=new.id)


async def _whole(request: Request, search_id: str, found: FoundWindows, form: str) -> bytes:
    """All that was found."""
    if form == JSON:
        return whole_opportunities(search_id, found)
    members = {"id": search_id, **json.loads(found.head)}
    return await _in_form(request, form, found.windows, members)


async def _in_form(
    request: Request, form: str, windows: Sequence[bytes], members: Mapping[str, object]
) -> bytes:
    if sum(map(len, windows)) > _PACKED_MAX_BYTES:
        return await in_child(request, EXPORT_BOUNDS, windows_in_form, form, windows, members)
    return windows_in_form(form, windows, members)


def _add_list(router: APIRouter, resource: SearchResource) -> None:
    @router.get(
        "",
        summary="List searches",
        response_model=SearchList,
        dependencies=[Depends(accepts_json)],
    )
    async def get_searches(request: Request, query: Annotated[ListQuery, Query()]) -> Response:
        """The latest come first."""
        jobs_and_one = await list_jobs(request, resource, query)
        return Response(search_list_json(jobs_and_one, query.limit), media_type=JSON)


def _add_one(router: APIRouter, resource: SearchResource) -> None:
    @router.get(
        "/{id}",
        summary="Get a search",
        response_model=resource.response,
        responses={
            200: _in_all_forms("The answer to its POST; in another form if `Accept` asks"),
            304: _UNCHANGED,
            404: no_such(resource),
        },
    )
    async def get_search(request: Request, search_id: PathId) -> Response:
        """A search never changes."""
        form = preferred_type(request, FORMS)
        headers = _immutable(search_id, form)
        if is_known_already(request, headers["ETag"]):
            await find_job(request, resource, search_id)
            return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
        search = await _find(request, resource, search_id)
        found = FoundWindows(search.head, search.windows)
        answer = await _whole(request, search_id, found, form)
        return Response(answer, HTTPStatus.OK, headers | _saved(found.head, form), form)


def _add_windows(router: APIRouter, resource: SearchResource) -> None:
    @router.get(
        "/{id}/windows",
        summary="List windows of a search",
        response_model=resource.page,
        responses={
            200: _in_all_forms("A page of the windows; in another form if `Accept` asks")
            | {
                "headers": {
                    "Link": {
                        "description": 'Of the next page, `rel="next"`; missing on the last',
                        "schema": {"type": "string"},
                    }
                }
            },
            304: _UNCHANGED,
            404: no_such(resource),
        },
    )
    async def get_windows(
        request: Request, search_id: PathId, query: Annotated[WindowsQuery, Query()]
    ) -> Response:
        """They follow the order of the request's targets, those of each target in order of time."""
        form = preferred_type(request, FORMS)
        headers = _immutable(search_id, form, query)
        if is_known_already(request, headers["ETag"]):
            await find_job(request, resource, search_id)
            return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
        stop = query.cursor + query.limit
        if query.target is None:
            search = await _find(request, resource, search_id, query.cursor, stop)
            shown, count = search.windows, search.window_count
        else:
            begins = b'{"target":' + to_json(query.target) + b","
            search = await _find(request, resource, search_id)
            windows = [window for window in search.windows if window.startswith(begins)]
            shown, count = windows[query.cursor : stop], len(windows)
        after = stop if stop < count else None
        if after is not None:
            url = request.url.include_query_params(cursor=after)
            headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'
        if form == JSON:
            body = b"".join([b'{"windows":[', b",".join(shown), b'],"next":', to_json(after), b"}"])
            return Response(body, HTTPStatus.OK, headers, form)
        headers |= _saved(search.head, form)
        answer = await _in_form(request, form, shown, {"next": after})
        return Response(answer, HTTPStatus.OK, headers, form)


async def _find(
    request: Request,
    resource: SearchResource,
    search_id: str,
    first: int = 0,
    stop: int | None = None,
) -> StoredWindows:
    """With these windows; raises 404."""

    def reading(connection: Connection) -> StoredWindows | None:
        job_of(connection, resource, search_id)
        return searches.get(connection, search_id, first, stop)

    search = await read(request, reading)
    if search is None:  # no job of this kind is without
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return search


def _immutable(search_id: str, form: str, page: WindowsQuery | None = None) -> dict[str, str]:
    """Headers of all that was found, or of a page of it."""
    which = "" if page is None else f"-{hashlib.sha256(to_json(page)).hexdigest()[:32]}"
    tag = weak_tag(f"{search_id}-{form.rsplit('/')[-1]}{which}-{VERSION}")
    return {"Cache-Control": "private, no-cache", "Vary": "Accept", "ETag": tag}
