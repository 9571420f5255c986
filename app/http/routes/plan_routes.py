"""Routes of plans: posted, found, listed, followed and removed.

The same for every resource that holds plans.
"""

import hashlib
from dataclasses import replace
from http import HTTPStatus
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Header, Query, Request, Response
from pydantic import BaseModel

from app.answers.job import JobResponse, PlanList, job_json, list_json
from app.answers.ranges import NotNegative
from app.http.blocking import answer_in_child
from app.http.negotiation import (
    JSON,
    accepts_json,
    is_known_already,
    json_body,
    preferred_type,
    weak_tag,
)
from app.http.openapi.schema import request_body
from app.http.problems import problem_answer
from app.http.routes.jobs import (
    PREFER,
    accept_job,
    add_delete,
    add_events,
    add_request,
    list_jobs,
    no_such,
)
from app.http.routes.plan_queries import (
    ListQuery,
    PathId,
    PlanListQuery,
    PostQuery,
    TableQuery,
    idempotency_key,
    with_table_formats,
)
from app.http.routes.resources import PlanResource
from app.http.routes.stored_plans import (
    REVALIDATE,
    UNCHANGED,
    find,
    immutable_tag,
    not_modified,
    table_answer,
    whole_json,
)
from app.http.routes.views import add_view
from app.http.waiting import WAIT_S, patience, wait_for_end
from app.jobs.child import Bounds
from app.jobs.kinds import JOB_KINDS
from app.jobs.refusals import Conflict
from app.store import jobs
from app.store.database import Database
from app.store.jobs import Job
from planner.base.errors import InvalidInput


def plan_routes(resource: PlanResource) -> APIRouter:
    """All routes of a resource."""
    router = APIRouter(tags=[resource.tag], prefix=resource.path)
    _add_post(router, resource)
    _add_list(router, resource)
    _add_one(router, resource)
    _add_table(router, resource)
    add_view(router, resource)
    add_request(router, resource)
    add_delete(router, resource)
    add_events(router, resource)
    return router


def _add_post(router: APIRouter, resource: PlanResource) -> None:
    query_model = with_table_formats(PostQuery, resource)

    async def post(
        request: Request,
        body: Annotated[bytes, Depends(json_body)],
        query: Annotated[PostQuery, Query()],
        key: Annotated[str | None, Depends(idempotency_key)],
        prefer: Annotated[str | None, Header(description=PREFER)] = None,
    ) -> Response:
        form = _form(request, resource, query)
        database: Database = request.app.state.database
        body = await database.answer(resource.fill_in, database, body)
        if query.dry_run:
            bounds = _dry_run_bounds(request, resource)
            return await answer_in_child(request, body, resource.read, bounds, resource.dry_run)
        spec = await anyio.to_thread.run_sync(resource.read, body)
        job = await database.answer(_accept_plan, request, resource, spec, body, query.revises, key)
        waits = patience(prefer, WAIT_S)
        plan = await wait_for_end(request, job.id, waits.wait_s)
        headers = {
            "Location": f"{resource.path}/{job.id}",
            "Vary": "Accept, Prefer",
            **waits.headers,
        }
        if plan is None:
            job, plan = await find(request, resource, job.id)
            if job.is_open or waits.is_none:  # though it may be done by now
                return Response(job_json(job), HTTPStatus.ACCEPTED, headers, JSON)
            if job.problem is not None:
                return problem_answer(request, job.problem, headers)
            if plan is None:
                raise Conflict("the plan was cancelled while it was waited for; ask again")
        if form is not None:
            return await table_answer(request, resource, plan, form, HTTPStatus.CREATED, headers)
        answer = await whole_json(request, resource, plan)
        return Response(answer, HTTPStatus.CREATED, headers, JSON)

    post.__doc__ = resource.about
    post.__annotations__["query"] = Annotated[query_model, Query()]
    router.post(
        "",
        summary=f"Plan {resource.what}",
        status_code=HTTPStatus.CREATED,
        response_model=(
            resource.response | TableAlone if "json" in resource.exporters else resource.response
        ),
        responses=_answers_to_post(resource),
        openapi_extra=request_body(resource.request_schema, resource.examples),
    )(post)


class TableAlone(BaseModel, extra="allow"):
    """The table by itself, as `format=json` asks: a list per column, and what they mean.

    name: of the plan, as its request gives it.
    epoch: of row 0; UTC.
    step_s: from row to row.
    t_s: of each row, since the epoch.
    description: frames, units and the interpolation.
    """

    name: str
    epoch: str
    step_s: NotNegative
    t_s: list[NotNegative]
    description: dict[str, Any]


def _dry_run_bounds(request: Request, resource: PlanResource) -> Bounds:
    """Those of the plan itself."""
    bounds = JOB_KINDS[resource.kind].bounds
    deadline_s = min(bounds.deadline_s, request.app.state.settings.job_deadline_s)
    return replace(bounds, deadline_s=deadline_s)


def _answers_to_post(resource: PlanResource) -> dict[int | str, dict[str, Any]]:
    location = {"Location": {"description": "Address of the plan", "schema": {"type": "string"}}}
    return {
        200: {
            "model": resource.dry_run_response,
            "description": "`dry_run`: a summary of the plan that would be made",
        },
        201: {
            "description": "The plan; or its table by itself, as `format` or Accept asks",
            "content": {media_type: {} for media_type in resource.format_by_media_type},
            "headers": location,
        },
        202: {
            "model": JobResponse,
            "description": "Accepted; the plan will be at Location",
            "headers": location,
        },
        409: {"description": "Cancelled while it was waited for, or `revises` names no plan made"},
    }


def _form(request: Request, resource: PlanResource, query: TableQuery) -> str | None:
    """The format asked for, None for JSON; raises 406."""
    by_media_type = resource.format_by_media_type
    return query.format or by_media_type.get(preferred_type(request, (JSON, *by_media_type)))


def _accept_plan(
    request: Request,
    resource: PlanResource,
    spec: Any,  # noqa: ANN401 (what the resource reads)
    body: bytes,
    revises: str | None,
    key: str | None,
) -> Job:
    """The job for a request, new or known by its key; raises KeyReused, QueueFull."""
    if revises is not None:
        _require_made(request.app.state.database, resource, revises)
    return accept_job(request, resource, spec, body, key, {}, revises=revises)


def _require_made(database: Database, resource: PlanResource, plan_id: str) -> None:
    with database.reading() as connection:
        job = jobs.get(connection, plan_id)
    if job is None or job.kind != resource.kind:
        raise InvalidInput(
            f"there is no plan {plan_id}; GET {resource.path} lists them", field="query.revises"
        )
    if job.state not in ("done", "failed") or job.problem is not None:
        raise Conflict(
            f"the plan to revise was not made: its state is {job.state}", field="query.revises"
        )


def _add_list(router: APIRouter, resource: PlanResource) -> None:
    async def get_plans(request: Request, query: Annotated[ListQuery, Query()]) -> Response:
        """The latest come first; plans that wait or run, were refused or cancelled are included."""
        campaign_id = query.campaign if isinstance(query, PlanListQuery) else None
        jobs_and_one = await list_jobs(request, resource, query, campaign_id)
        return Response(list_json(jobs_and_one, query.limit), media_type=JSON)

    query_model = PlanListQuery if resource.in_campaigns else ListQuery
    get_plans.__annotations__["query"] = Annotated[query_model, Query()]
    router.get(
        "",
        summary="List plans",
        response_model=PlanList,
        dependencies=[Depends(accepts_json)],
    )(get_plans)


def _add_one(router: APIRouter, resource: PlanResource) -> None:
    @router.get(
        "/{id}",
        summary="Get a plan",
        response_model=resource.response | JobResponse,
        responses={304: UNCHANGED, 404: no_such(resource)},
        dependencies=[Depends(accepts_json)],
    )
    async def get_plan(request: Request, plan_id: PathId) -> Response:
        """The answer is the state of the work until the plan is made, then the plan, which never
        changes."""
        job, plan = await find(request, resource, plan_id)
        state = job_json(job)
        tag = immutable_tag(plan) if plan else weak_tag(hashlib.sha256(state).hexdigest()[:32])
        if is_known_already(request, tag):
            return not_modified(tag)
        answer = await whole_json(request, resource, plan) if plan else state
        return Response(answer, HTTPStatus.OK, REVALIDATE | {"ETag": tag}, JSON)


def _add_table(router: APIRouter, resource: PlanResource) -> None:
    query_model = with_table_formats(TableQuery, resource)

    async def get_table(
        request: Request, plan_id: PathId, query: Annotated[TableQuery, Query()]
    ) -> Response:
        """The table comes in the format that `format` or the Accept header names."""
        form = _form(request, resource, query)
        job, plan = await find(request, resource, plan_id)
        if plan is None:
            raise Conflict(
                f"there is no table: the plan's state is {job.state}; GET "
                f"{resource.path}/{job.id} tells more"
            )
        tag = immutable_tag(plan, form or "table")
        if is_known_already(request, tag):
            return not_modified(tag)
        headers = REVALIDATE | {"ETag": tag}
        return await table_answer(request, resource, plan, form, HTTPStatus.OK, headers)

    get_table.__annotations__["query"] = Annotated[query_model, Query()]
    router.get(
        "/{id}/table",
        summary="Get the table of a plan",
        response_class=Response,
        responses={
            200: {
                "description": "The table; as JSON the member `table` of the plan",
                "content": {media: {} for media in (JSON, *resource.format_by_media_type)},
            },
            304: UNCHANGED,
            404: no_such(resource),
            409: {"description": "The plan has no table, or none yet"},
            422: {"description": "A table that failed verification is in the whole plan only"},
        },
    )(get_table)
