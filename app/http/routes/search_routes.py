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

from app.answers.job import list_class
from app.answers.members import ProvenanceOut, provenance, to_json
from app.answers.opportunities import FoundWindows, whole_opportunities
from app.answers.opportunities_geojson import FeatureCollection
from app.http.blocking import EXPORT_BOUNDS, in_child, read
from app.http.negotiation import (
    JSON,
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
from app.http.routes.parameters import PathId
from app.http.routes.resources import JobResource
from app.jobs.child import Bounds
from app.store import audit, jobs, results, searches
from app.store.database import Database
from app.store.jobs import NewJob
from app.store.searches import StoredWindows
from app.work.searches import CSV, GEOJSON, windows_in_form

PAGE_MAX = 1000
SEARCH_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)
_SUFFIXES = {GEOJSON: ".geojson", CSV: ".csv"}
FORMS = (JSON, *_SUFFIXES)
# Turning more than this of packed windows into another form would hold the interpreter for long.
_PACKED_MAX_BYTES = 100_000

SEARCH_LIST = list_class("SearchList", "opportunities", "Searches for opportunities")


@dataclass(frozen=True, kw_only=True)
class SearchResource(JobResource):
    """One that holds what searches found.

    find: what a child does.  windows_response: of some of what was found.
    """

    singular: str = "search for opportunities"
    plural: str = "searches"
    list_response: type = SEARCH_LIST
    summary: str
    find: Callable[[Any, ProvenanceOut], FoundWindows]
    bounds: Bounds = SEARCH_BOUNDS
    windows_response: type


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
                "The windows found; as GeoJSON if `Accept` asks, or as a pass table in CSV"
            )
        },
        openapi_extra=json_body_of(resource.requests, resource.examples),
    )
    async def post(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
        """Windows are found to the millisecond, with the limits that open and close each, and the
        view through it.

        The search is kept under `id`, at Location.
        """
        media_type = preferred_type(request, FORMS)
        begun_utc = datetime.now(UTC)
        spec = await anyio.to_thread.run_sync(resource.requests.read, body)
        origin = provenance(begun_utc, body)
        found = await in_child(request, resource.bounds, resource.find, spec, origin)
        deadline_s = resource.bounds.deadline_s
        new = new_job(request, resource, spec, body, deadline_s=deadline_s)
        content = await anyio.to_thread.run_sync(searches.packed, found.head, found.windows)
        database: Database = request.app.state.database
        await database.answer(_keep, database, new, begun_utc, content)
        headers = {"Location": f"{resource.path}/{new.id}", "Vary": "Accept"}
        answer = await _whole(request, new.id, found, media_type)
        return Response(answer, HTTPStatus.OK, headers | _saved(found.head, media_type), media_type)


def _saved(head: bytes, media_type: str) -> dict[str, str]:
    """The header that names a file after its search."""
    if media_type == JSON:
        return {}
    return saved_as(json.loads(head)["name"], "opportunities", _SUFFIXES[media_type])


def _keep(database: Database, new: NewJob, begun_utc: datetime, content: Sequence[bytes]) -> None:
    with database.writing() as connection:
        jobs.record_done(connection, new, begun_utc)
        results.store(connection, new.id, content)
        audit.record(connection, key_id=new.key_id, action=f"{new.kind}.accept", subject=new.id)


async def _whole(request: Request, search_id: str, found: FoundWindows, media_type: str) -> bytes:
    """All that was found."""
    if media_type == JSON:
        return whole_opportunities(search_id, found)
    members = {"id": search_id, **json.loads(found.head)}
    return await _in_form(request, media_type, found.windows, members)


async def _in_form(
    request: Request, media_type: str, windows: Sequence[bytes], members: Mapping[str, object]
) -> bytes:
    if sum(map(len, windows)) > _PACKED_MAX_BYTES:
        return await in_child(request, EXPORT_BOUNDS, windows_in_form, media_type, windows, members)
    return windows_in_form(media_type, windows, members)


def _add_one(router: APIRouter, resource: SearchResource) -> None:
    @router.get(
        "/{id}",
        summary="Get a search",
        response_model=resource.response,
        responses={200: _in_all_forms("The answer to its POST; in another form if `Accept` asks")},
    )
    async def get_search(request: Request, search_id: PathId) -> Response:
        """A search never changes."""
        media_type = preferred_type(request, FORMS)
        tag = _tag(search_id, media_type)
        if is_known_already(request, tag):
            await find_job(request, resource, search_id)
            return not_modified(tag)
        search = await _find(request, resource, search_id)
        found = FoundWindows(search.head, search.windows)
        answer = await _whole(request, search_id, found, media_type)
        headers = revalidated(tag) | _saved(found.head, media_type)
        return Response(answer, HTTPStatus.OK, headers, media_type)


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
        request: Request, search_id: PathId, query: Annotated[WindowsQuery, Query()]
    ) -> Response:
        """They follow the order of the request's targets, those of each target in order of time."""
        media_type = preferred_type(request, FORMS)
        tag = _tag(search_id, media_type, query)
        if is_known_already(request, tag):
            await find_job(request, resource, search_id)
            return not_modified(tag)
        stop = query.cursor + query.limit
        if query.target is None:
            search = await _find(request, resource, search_id, query.cursor, stop)
            shown, count = search.windows, search.window_count
        else:
            begins = b'{"target":' + to_json(query.target) + b","
            search = await _find(request, resource, search_id)
            windows = [window for window in search.windows if window.startswith(begins)]
            shown, count = windows[query.cursor : stop], len(windows)
        headers = revalidated(tag)
        after = stop if stop < count else None
        if after is not None:
            url = request.url.include_query_params(cursor=after)
            headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'
        if media_type == JSON:
            body = b"".join([b'{"windows":[', b",".join(shown), b'],"next":', to_json(after), b"}"])
            return Response(body, HTTPStatus.OK, headers, media_type)
        headers |= _saved(search.head, media_type)
        answer = await _in_form(request, media_type, shown, {"next": after})
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


def _tag(search_id: str, media_type: str, page: WindowsQuery | None = None) -> str:
    """Of all that was found, or of a page of it."""
    which = "" if page is None else f"-{hashlib.sha256(to_json(page)).hexdigest()[:32]}"
    return tag_for_good(search_id, f"{media_type.rsplit('/')[-1]}{which}")
