"""A resource that holds what searches found: posted, kept, read again in pages, removed."""

import hashlib
import json
import zlib
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated, Any, NamedTuple

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import StreamingResponse
from pydantic import Field
from sqlalchemy import Connection

from app.answers.job import list_class
from app.answers.members import provenance
from app.http.blocking import database_of, in_child, read, where_solved
from app.http.negotiation import ONLY_JSON, json_body, preferred_type, revalidated, saved_as
from app.http.openapi.schema import REF, json_body_of
from app.http.routes.job_routes import JobResource, tag_for_good
from app.http.routes.parameters import Parameters, PathId
from app.jobs.child import Bounds
from app.jobs.worker_process import Task
from app.store import audit, jobs, results
from app.store.packed import unzip
from app.work.searches import (
    CSV,
    GEOJSON,
    JSON,
    PROBABILITY,
    VIEW,
    FeatureCollection,
    FoundSearch,
    Page,
    WindowsAsked,
    closed,
    find_windows,
    opened,
    read_windows,
)
from planner.base.errors import InvalidInput

PAGE_WINDOWS, PAGE_MAX = 100, 10_000
PROBABLE_MAX = 500  # windows whose probability one request may ask for: three seconds
STREAMED = 2000  # windows that are told of at a time where all are asked for
SEARCH_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)
_SUFFIXES = {GEOJSON: ".geojson", CSV: ".csv"}
FORMS = (JSON, *_SUFFIXES)

SEARCH_LIST = list_class("SearchList", "opportunities", "Searches for opportunities")


class WindowsQuery(Parameters):
    """Which windows, and what to tell of them.

    limit: the largest number of windows of this page: 100 unless given, of GeoJSON and CSV all
    there are. At most 500 with `probability`.
    cursor: `next` of the page before; 0 for the first.
    target: only windows of the target with this id.
    include: members of windows beyond edges and session, with commas between: `view` the greatest
    elevation, the sight at the closest approach and through the window, the target's place and sky;
    of a platform's windows also `probability` that the target stays in the frame, and `reasons`
    that leave targets without windows. GeoJSON and CSV always have the view, and no probability.
    """

    limit: int | None = Field(default=None, ge=1, le=PAGE_MAX)
    cursor: int = Field(default=0, ge=0, le=10**9)
    target: str | None = Field(default=None, min_length=1, max_length=200)
    include: str = Field(default="", max_length=100, examples=["view,reasons"])


_LINK = {
    "Link": {
        "description": 'Of the next page, `rel="next"`; missing on the last',
        "schema": {"type": "string"},
    }
}


def _in_all_forms(description: str) -> dict[str, Any]:
    geojson = {"schema": {"$ref": REF.format(model=FeatureCollection.__name__)}}
    csv: dict[str, Any] = {"schema": {"type": "string"}}
    return {"description": description, "content": {JSON: {}, GEOJSON: geojson, CSV: csv}}


@dataclass(frozen=True, kw_only=True)
class SearchResource(JobResource):
    """One that holds what searches found.

    included: what `include` may ask for.
    """

    singular: str = "search for opportunities"
    plural: str = "searches"
    list_response: type = SEARCH_LIST
    summary: str
    included: tuple[str, ...]

    def asked(self, request: Request, query: WindowsQuery) -> WindowsAsked:
        """As the work is told; raises InvalidInput, 406.  Other forms are of what is seen."""
        names = set(filter(None, query.include.split(",")))
        media_type = preferred_type(request, FORMS)
        if not names <= set(self.included) or query.include.endswith(","):
            raise InvalidInput(
                f"must be one or more of {', '.join(self.included)}, with commas between, not "
                f"{query.include!r}",
                field="query.include",
            )
        if media_type != JSON:
            names = (names | {VIEW}) - {PROBABILITY}
        limit = query.limit or (PAGE_WINDOWS if media_type == JSON else STREAMED)
        if PROBABILITY in names and limit > PROBABLE_MAX:
            raise InvalidInput(
                f"must be at most {PROBABLE_MAX} with include={PROBABILITY}; ask for the rest by "
                "`cursor`",
                field="query.limit",
            )
        return WindowsAsked(
            media_type=media_type,
            cursor=query.cursor,
            limit=limit,
            target=query.target,
            include=frozenset(names),
        )

    def routes(self) -> APIRouter:
        router = APIRouter(tags=[self.tag], prefix=self.path)
        self._add_post(router)
        self.add_list(router)
        self._add_one(router)
        self.add_request(router)
        self._add_delete(router)
        return router

    def _add_post(self, router: APIRouter) -> None:
        @router.post(
            "",
            summary=self.summary,
            response_model=self.response,
            responses={
                200: _in_all_forms(
                    "The search and its first windows; all as GeoJSON or as a pass table in CSV if "
                    "`Accept` asks"
                )
                | {"headers": _LINK}
            },
            openapi_extra=json_body_of(self.requests, self.examples),
        )
        async def post(
            request: Request,
            body: Annotated[bytes, Depends(json_body)],
            query: Annotated[WindowsQuery, Query()],
        ) -> Response:
            """Windows are found to the millisecond, with the limits that open and close each.

            The search is kept under `id`, at Location; windows come in pages.
            """
            asked = self.asked(request, query)
            spec = await anyio.to_thread.run_sync(self.requests.read, body)
            whole, page = await self.find_and_keep(request, spec, body, asked)
            at = f"{self.path}/{whole.search_id}"
            return _answer(request, whole, page, {"Location": at, "Vary": "Accept"}, query)

    async def find_and_keep(
        self,
        request: Request,
        spec: Any,  # noqa: ANN401 (what the resource reads)
        body: bytes,
        asked: WindowsAsked,
    ) -> tuple["Whole", Page]:
        """All windows, kept, and the page asked for; spec: the body as it was read."""
        begun_utc = datetime.now(UTC)
        origin = provenance(begun_utc, body)
        new = self.new_job(request, spec, body, deadline_s=SEARCH_BOUNDS.deadline_s)
        task = Task(
            job_id=new.id, bounds=SEARCH_BOUNDS, work=find_windows, arguments=(spec, origin, asked)
        )
        found, page = await where_solved(request, task)
        database = database_of(request)

        def keep() -> None:
            with database.writing() as connection:
                jobs.record_done(connection, new, begun_utc)
                results.store(connection, new.id, [zlib.compress(found.head), found.edges])
                action = f"{new.kind}.accept"
                audit.record(connection, key_id=new.key_id, action=action, subject=new.id)

        await database.answer(keep)
        return Whole(self, new.id, body, found, asked), page

    def _add_one(self, router: APIRouter) -> None:
        @router.get(
            "/{id}",
            summary="Get a search",
            response_model=self.response,
            responses={
                200: _in_all_forms("A page of its windows; in another form if `Accept` asks")
                | {"headers": _LINK}
            },
        )
        async def get_search(
            request: Request, search_id: PathId, query: Annotated[WindowsQuery, Query()]
        ) -> Response:
            """A search never changes. Windows follow the order of the request's targets, those of
            each target the order of time.
            """
            asked = self.asked(request, query)
            told = [asked.media_type, *vars(query).values()]
            tag = tag_for_good(
                search_id, hashlib.sha256(json.dumps(told).encode()).hexdigest()[:32]
            )
            await self.find_job(request, search_id)
            headers = revalidated(request, tag)
            whole = await self.find_kept(request, search_id, asked)
            page = await whole.page(request, asked.cursor)
            return _answer(request, whole, page, headers, query)

    def _add_delete(self, router: APIRouter) -> None:
        @router.delete(
            "/{id}",
            summary=f"Delete a {self.singular}",
            status_code=HTTPStatus.NO_CONTENT,
            response_class=Response,
            dependencies=ONLY_JSON,
        )
        async def delete(request: Request, search_id: PathId) -> Response:
            """Only the audit log remembers a search that was deleted."""
            job = await self.find_job(request, search_id)
            return await self.answer_removal(request, job)

    async def find_kept(self, request: Request, search_id: str, asked: WindowsAsked) -> "Whole":
        """As it is kept; raises 404."""

        def reading(connection: Connection) -> Whole:
            self.job_of(connection, search_id)
            body = jobs.request_of(connection, search_id)
            content = results.get(connection, search_id)
            assert body is not None
            assert content  # no job of this kind is without
            found = FoundSearch(unzip(content[0]), content[1])
            return Whole(self, search_id, body, found, asked)

        return await read(request, reading)


class Whole(NamedTuple):
    """All that was found, and what is asked of it.  body: the search's request."""

    resource: SearchResource
    search_id: str
    body: bytes
    found: FoundSearch
    asked: WindowsAsked

    async def page(self, request: Request, cursor: int) -> Page:
        asked = replace(self.asked, cursor=cursor)
        edges = self.found.edges
        return await in_child(request, SEARCH_BOUNDS, read_windows, self.body, edges, asked)


def _answer(
    request: Request, whole: Whole, page: Page, headers: dict[str, str], query: WindowsQuery
) -> Response:
    """A page, or without a limit, in other forms than JSON, all as it is told."""
    media_type, search_id, (head, _) = whole.asked.media_type, whole.search_id, whole.found
    begin = opened(media_type, search_id, head, page.reasons) + page.windows
    if media_type != JSON:
        name, suffix = json.loads(head)["name"], _SUFFIXES[media_type]
        headers |= saved_as(name, "opportunities", suffix)
    if media_type == JSON or query.limit is not None:
        if page.next is not None:
            path = f"{whole.resource.path}/{search_id}"
            url = request.url.include_query_params(cursor=page.next)
            headers["Link"] = f'<{path}?{url.query}>; rel="next"'
        content = begin + closed(media_type, page.next)
        return Response(content, HTTPStatus.OK, headers, media_type)

    async def parts() -> AsyncIterator[bytes]:
        yield begin
        after = page.next
        while after is not None:
            told = await whole.page(request, after)
            yield (b"" if media_type == CSV else b",") + told.windows
            after = told.next
        yield closed(media_type, None)

    return StreamingResponse(parts(), HTTPStatus.OK, headers, media_type)
