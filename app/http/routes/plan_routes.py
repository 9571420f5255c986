"""A resource that holds plans: posted, found, listed, seen, followed and removed."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from http import HTTPStatus
from inspect import cleandoc
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Request, Response
from sqlalchemy import Connection

from app.answers.job import JobResponse, job_json, list_class
from app.answers.members import PlanHead, ProvenanceOut, whole_answer
from app.http.blocking import EXPORT_BOUNDS, answer_in_child, database_of, in_child, read
from app.http.negotiation import (
    JSON,
    ONLY_JSON,
    format_of,
    json_body,
    preferred_type,
    revalidated,
    saved_as,
)
from app.http.openapi.schema import json_body_of
from app.http.routes.job_routes import JobResource, answer_unmade, tag_for_good, tag_of
from app.http.routes.parameters import (
    IdempotencyKey,
    PathId,
    PostQuery,
    Prefer,
    TableQuery,
    ViewQuery,
    read_query,
    with_formats,
)
from app.http.waiting import WAIT_S, patience, wait_for_end
from app.jobs.refusals import Conflict
from app.store import jobs, plans
from app.store.database import Database
from app.store.job import Job
from app.store.plans import StoredPlan
from app.work.plan import TableAlone, stored_table_file
from app.work.view import DRAWN, AskedView, PlanViewResponse, stored_plan_view
from planner.base.errors import Refusal
from planner.output.export import EXPORTERS
from planner.output.view import VIEW_EXPORTERS

# Turning more than this of a packed table into JSON would hold the interpreter for long.
_PACKED_MAX_BYTES = 200_000
_JSON_FORMAT = "json"
# Formats an Accept header can ask for beside JSON.
_FORMAT_BY_MEDIA_TYPE = {
    exporter.media_type: name for name, exporter in EXPORTERS.items() if exporter.media_type != JSON
}
SEEN_AS = VIEW_EXPORTERS | DRAWN
_TITLES = {name: exporter.title for name, exporter in EXPORTERS.items()}
_VIEW_TITLES = {_JSON_FORMAT: "columns over time"}
_VIEW_TITLES |= {name: exporter.title for name, exporter in SEEN_AS.items()}
_VIEW_MEDIA_TYPES = {_JSON_FORMAT: JSON}
_VIEW_MEDIA_TYPES |= {name: exporter.media_type for name, exporter in SEEN_AS.items()}
_TABLE_TOLD = "The table by itself in this format"
_read_post = read_query(with_formats(PostQuery, _TABLE_TOLD, _TITLES))
_read_table = read_query(with_formats(TableQuery, _TABLE_TOLD, _TITLES))
_read_view = read_query(with_formats(ViewQuery, "The view in this format", _VIEW_TITLES))
PLAN_LIST = list_class("PlanList", "plans", "Plans")


@dataclass(frozen=True, kw_only=True)
class PlanResource(JobResource):
    """One that holds plans.

    dry_run: the answer that says whether it flies; done in a child.  table_json: a stored table
    as the answer holds it.  document: the name of what a stored plan holds of the answer beside it.
    file_stem: of files whose plan has no name.
    lacks: whether a request, in bytes, may lack what only the store can tell; fill_in: with that.
    """

    singular: str = "plan"
    plural: str = "plans"
    list_response: type = PLAN_LIST
    about_list: str = (
        "The latest come first; plans that wait or run, were refused or cancelled are included."
    )
    what: str
    about: str
    dry_run: Callable[[Any, ProvenanceOut], bytes]
    dry_run_response: type
    table_json: Callable[[bytes], bytes]
    document: str = "document"
    file_stem: str
    lacks: Callable[[bytes], bool] = lambda _: False
    fill_in: Callable[[Database, bytes], bytes] = lambda _, body: body

    def routes(self) -> APIRouter:
        router = APIRouter(tags=[self.tag], prefix=self.path)
        self._add_post(router)
        self.add_list(router)
        self._add_one(router)
        self._add_table(router)
        self._add_view(router)
        self.add_request(router)
        self.add_delete(router)
        self.add_events(router)
        return router

    def _add_post(self, router: APIRouter) -> None:
        @router.post(
            "",
            summary=f"Plan {self.what}",
            description=cleandoc(self.about),
            status_code=HTTPStatus.CREATED,
            response_model=self.response | TableAlone,
            responses={
                200: {
                    "model": self.dry_run_response,
                    "description": "`dry_run`: a summary of the plan that would be made",
                },
                201: {
                    "description": "The plan; or its table by itself, as `format` or Accept asks",
                    "content": {media_type: {} for media_type in _FORMAT_BY_MEDIA_TYPE},
                },
                202: {
                    "model": JobResponse,
                    "description": "Accepted; the plan will be at Location",
                },
                409: {
                    "description": "Cancelled while it was waited for, or `revises` names no plan "
                    "made"
                },
            },
            openapi_extra=json_body_of(self.requests, self.examples),
        )
        async def post(
            request: Request,
            body: Annotated[bytes, Depends(json_body)],
            query: Annotated[PostQuery, Depends(_read_post)],
            key: IdempotencyKey,
            prefer: Prefer = None,
        ) -> Response:
            format_name = _format(request, query)
            database = database_of(request)
            if self.lacks(body):
                body = await database.answer(self.fill_in, database, body)
            if query.dry_run:
                bounds, read_request = self.bounds(request), self.requests.read
                return await answer_in_child(request, body, read_request, bounds, self.dry_run)
            spec = await anyio.to_thread.run_sync(self.requests.read, body)
            accept = partial(self.accept, request, spec, body, key, revises=query.revises)
            job = await database.answer(accept)
            waits = patience(prefer, WAIT_S)
            headers = self.headers_of_post(job, waits)
            plan = await wait_for_end(request, job.id, waits.wait_s)
            if plan is None:
                job, plan = await self._find(request, job.id)
                if unmade := answer_unmade(request, job, waits, headers, job_json(job)):
                    return unmade
                assert plan is not None
            if format_name is None:
                answer = await self._whole_json(request, plan)
                return Response(answer, HTTPStatus.CREATED, headers, JSON)
            status = HTTPStatus.CREATED
            return await self._table_answer(request, plan, format_name, status, headers)

    def _add_one(self, router: APIRouter) -> None:
        @router.get(
            "/{id}",
            summary="Get a plan",
            response_model=self.response | JobResponse,
            dependencies=ONLY_JSON,
        )
        async def get_plan(request: Request, plan_id: PathId) -> Response:
            """The answer is the state of the work until the plan is made, then the plan, which
            never changes."""
            job, plan = await self._find(request, plan_id)
            state = job_json(job)
            headers = revalidated(request, tag_for_good(plan.id) if plan else tag_of(state))
            answer = await self._whole_json(request, plan) if plan else state
            return Response(answer, headers=headers, media_type=JSON)

    def _add_table(self, router: APIRouter) -> None:
        @router.get(
            "/{id}/table",
            summary="Get the table of a plan",
            response_class=Response,
            responses={
                200: {
                    "description": "The table; as JSON the member `table` of the plan",
                    "content": {media: {} for media in (JSON, *_FORMAT_BY_MEDIA_TYPE)},
                },
                409: {"description": "The plan has no table, or none yet"},
                422: {"description": "A table that failed verification is in the whole plan only"},
            },
        )
        async def get_table(
            request: Request,
            plan_id: PathId,
            query: Annotated[TableQuery, Depends(_read_table)],
        ) -> Response:
            """The table comes in the format that `format` or the Accept header names."""
            format_name = _format(request, query)
            plan = await self._find_made(request, plan_id, "there is no table")
            tag = tag_for_good(plan.id, format_name or "table")
            status, headers = HTTPStatus.OK, revalidated(request, tag)
            return await self._table_answer(request, plan, format_name, status, headers)

    def _add_view(self, router: APIRouter) -> None:
        @router.get(
            "/{id}/view",
            summary="View a plan as columns over time, map or plot",
            response_model=PlanViewResponse,
            responses={
                200: {
                    "description": "The columns; or a file, as `format` or Accept asks",
                    "content": {media: {} for media in _VIEW_MEDIA_TYPES.values() if media != JSON},
                },
                409: {"description": "The plan was not made, or not yet"},
                422: {
                    "description": "`step_s` fits neither the table nor an answer; or, but for "
                    "JSON, the plan's verification failed"
                },
            },
        )
        async def get_view(
            request: Request, plan_id: PathId, query: Annotated[ViewQuery, Depends(_read_view)]
        ) -> Response:
            """The view is computed from the table and the request of any kept plan.

            Columns have a number for each row and their unit in the name; null stands where nothing
            is defined.
            """
            name = query.format or format_of(request, _VIEW_MEDIA_TYPES)
            plan = await self._find_made(request, plan_id, "there is nothing to see yet")
            tag = tag_for_good(plan.id, f"view-{name}-{query.step_s}-{query.pixel_arcsec}")
            headers = revalidated(request, tag)
            asked = AskedView(
                plan_id=plan.id,
                verified=plan.state == "done",
                format_name=None if name == _JSON_FORMAT else name,
                step_s=query.step_s,
                pixel_arcsec=query.pixel_arcsec,
                created_utc=plan.planned_utc,
            )
            content = await _view(request, plan, asked)
            if name != _JSON_FORMAT:
                suffix, media_type = SEEN_AS[name].suffix, _VIEW_MEDIA_TYPES[name]
                headers |= saved_as(plan.name, self.file_stem, suffix, media_type)
            return Response(content, HTTPStatus.OK, headers, _VIEW_MEDIA_TYPES[name])

    async def _find(self, request: Request, plan_id: str) -> tuple[Job, StoredPlan | None]:
        """A job of a resource, with its plan where there is one; raises 404."""

        def reading(connection: Connection) -> tuple[Job, StoredPlan | None]:
            job = self.job_of(connection, plan_id)
            is_made = job.state in ("done", "failed")
            return job, plans.get(connection, job) if is_made else None

        return await read(request, reading)

    async def _find_made(self, request: Request, plan_id: str, without: str) -> StoredPlan:
        """A plan; raises 404, and Conflict where it isn't made, which begins with `without`."""
        job, plan = await self._find(request, plan_id)
        if plan is None:
            raise Conflict(
                f"{without}: the plan's state is {job.state}; GET {self.path}/{job.id} tells more"
            )
        return plan

    async def _whole_json(self, request: Request, plan: StoredPlan) -> bytes:
        if len(plan.table_columns) > _PACKED_MAX_BYTES:
            table = await in_child(request, EXPORT_BOUNDS, self.table_json, plan.table_columns)
        else:
            table = await anyio.to_thread.run_sync(self.table_json, plan.table_columns)
        head = PlanHead(**{name: getattr(plan, name) for name in PlanHead.__dataclass_fields__})
        return whole_answer(head, getattr(plan, self.document), table)

    async def _table_answer(
        self,
        request: Request,
        plan: StoredPlan,
        format_name: str | None,
        status: HTTPStatus,
        headers: dict[str, str],
    ) -> Response:
        """The table by itself, without a format as the whole answer holds it.

        Raises Unverified, OutsideCoverage.
        """
        if format_name is None:
            table = await in_child(request, EXPORT_BOUNDS, self.table_json, plan.table_columns)
            return Response(table, status, headers, JSON)
        exporter = EXPORTERS[format_name]
        body = await read(request, lambda connection: jobs.request_of(connection, plan.id))
        content = await in_child(
            request,
            EXPORT_BOUNDS,
            stored_table_file,
            body or b"",
            plan.table_columns,
            format_name,
            plan.planned_utc,
        )
        headers |= saved_as(plan.name, self.file_stem, exporter.suffix)
        return Response(content, status, headers, exporter.media_type)


def _format(request: Request, query: TableQuery) -> str | None:
    """The format asked for, None for JSON; raises 406."""
    preferred = preferred_type(request, (JSON, *_FORMAT_BY_MEDIA_TYPE))
    return query.format or _FORMAT_BY_MEDIA_TYPE.get(preferred)


async def _view(request: Request, plan: StoredPlan, asked: AskedView) -> bytes:
    """Raises a refusal of what was asked with the parameter's name."""
    body = await read(request, lambda connection: jobs.request_of(connection, plan.id))
    try:
        return await in_child(
            request, EXPORT_BOUNDS, stored_plan_view, body or b"", plan.table_columns, asked
        )
    except Refusal as refusal:
        if refusal.field == "step_s":
            refusal.field = "query.step_s"
        raise
