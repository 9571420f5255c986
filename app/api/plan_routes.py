"""How are plans asked for, found, listed, followed and removed over HTTP?

The same for every resource that holds plans.
"""

import hashlib
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from pydantic import TypeAdapter

from app.api.event_stream import EVENT_EXAMPLE, EVENT_STREAM, last_seq, told
from app.api.job_response import JobResponse, PlanList, job_json, list_json
from app.api.negotiation import JSON, accepts_json, is_known_already, json_body, preferred
from app.api.plan_queries import (
    ListQuery,
    PlanId,
    PostQuery,
    TableQuery,
    idempotency_key,
    last_event_id,
    with_formats,
)
from app.api.plan_resource import PlanResource
from app.api.provenance import provenance
from app.api.stored_plans import Found, find, immutable_tag, table_answer, whole_json
from app.api.waiting import Patience, patience, wait_for_end
from app.errors import problem_answer
from app.jobs.dispatcher import Dispatcher
from app.jobs.refusals import Conflict, KeyReused
from app.openapi import request_body
from app.store import audit, jobs
from app.store.database import Database
from app.store.ids import new_id
from app.store.jobs import Job, NewJob
from planner.errors import InvalidInput

CANCEL_WAIT_S = 5.0
_VARY = {"Vary": "Accept, Prefer"}
_REVALIDATE = {"Cache-Control": "private, no-cache", "Vary": "Accept"}


def plan_routes(resource: PlanResource) -> APIRouter:
    """All routes of a resource."""
    router = APIRouter(tags=[resource.tag], prefix=resource.path)
    _add_post(router, resource)
    _add_list(router, resource)
    _add_one(router, resource)
    _add_table(router, resource)
    _add_events(router, resource)
    return router


def _add_post(router: APIRouter, resource: PlanResource) -> None:
    query_model = with_formats(PostQuery, resource)

    async def post(
        request: Request,
        body: Annotated[bytes, Depends(json_body)],
        query: Annotated[PostQuery, Query()],
        key: Annotated[str | None, Depends(idempotency_key)],
        prefer: Annotated[str | None, Header(description=_PREFER)] = None,
    ) -> Response:
        form = _form(request, resource, query)
        asked = await anyio.to_thread.run_sync(resource.read, body)
        if query.dry_run:
            return Response(_dry_run(resource, asked, body), media_type=JSON)
        job = await anyio.to_thread.run_sync(
            _accepted, request, resource, asked.name, body, query, key
        )
        waits = patience(prefer)
        await wait_for_end(request, job.id, waits.wait_s)
        found = await find(request, resource, job.id)
        return await _posted(request, resource, found, form, waits)

    post.__doc__ = resource.about
    post.__annotations__["query"] = Annotated[query_model, Query()]
    router.post(
        "",
        summary=f"Plan {resource.what}",
        status_code=HTTPStatus.CREATED,
        response_model=resource.response,
        responses=_answers_to_post(resource),
        openapi_extra=request_body(resource.request_schema, resource.examples),
    )(post)


_PREFER = (
    "`wait=N`: answer 202 when the plan isn't made within N seconds (30 unless said, at most 60); "
    "`respond-async`: answer 202 at once."
)


def _answers_to_post(resource: PlanResource) -> dict[int | str, dict[str, Any]]:
    location = {"Location": {"description": "Where the plan is", "schema": {"type": "string"}}}
    return {
        200: {"model": resource.dry_run_response, "description": "`dry_run`: the request is sound"},
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
    return query.format or by_media_type.get(preferred(request, (JSON, *by_media_type)))


def _dry_run(resource: PlanResource, asked: Any, body: bytes) -> bytes:  # noqa: ANN401 (resource's)
    made = provenance(hashlib.sha256(body).hexdigest(), datetime.now(UTC))
    answer = resource.dry_run(asked, made)
    return TypeAdapter[object](resource.dry_run_response).dump_json(answer)


def _accepted(
    request: Request,
    resource: PlanResource,
    name: str,
    body: bytes,
    query: PostQuery,
    key: str | None,
) -> Job:
    """The job for a request, new or known by its key; raises KeyReused, QueueFull."""
    state = request.app.state
    dispatcher: Dispatcher = state.dispatcher
    key_id = getattr(request.state, "key_id", None)
    kind = resource.kind
    if query.revises is not None:
        _require_made(state.database, resource, query.revises)
    new = NewJob(
        id=new_id(),
        kind=kind.name,
        name=name,
        request=body,
        request_sha256=hashlib.sha256(body).hexdigest(),
        deadline_s=min(kind.bounds.deadline_s, state.settings.job_deadline_s),
        options={} if query.revises is None else {"revises": query.revises},
        key_id=key_id,
        idempotency=None if key is None else _digest(key_id or "", kind.name, key),
    )
    job = dispatcher.submit(new)
    if (job.request_sha256, job.options) != (new.request_sha256, new.options):
        raise KeyReused(
            "this Idempotency-Key came with another request before; send a new key with a new "
            "request",
            field="header.Idempotency-Key",
        )
    return job


def _digest(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _require_made(database: Database, resource: PlanResource, plan_id: str) -> None:
    with database.reading() as connection:
        job = jobs.get(connection, plan_id)
    if job is None or job.kind != resource.kind.name:
        raise InvalidInput(
            f"there is no plan {plan_id}; GET {resource.path} lists them", field="query.revises"
        )
    if job.state not in ("done", "failed") or job.problem is not None:
        raise Conflict(
            f"the plan to revise was not made: its state is {job.state}", field="query.revises"
        )


async def _posted(
    request: Request, resource: PlanResource, found: Found, form: str | None, waits: Patience
) -> Response:
    job = found.job
    headers = _VARY | {"Location": f"{resource.path}/{job.id}"}
    if waits.applied is not None:
        headers["Preference-Applied"] = waits.applied
    if job.is_open:
        return Response(job_json(job), HTTPStatus.ACCEPTED, headers, JSON)
    if job.problem is not None:
        return problem_answer(request, job.problem, headers)
    if found.plan is None:
        raise Conflict("the plan was cancelled while it was waited for; ask again")
    if form is not None:
        return await table_answer(request, resource, found, form, HTTPStatus.CREATED, headers)
    answer = await whole_json(request, resource, found.plan)
    return Response(answer, HTTPStatus.CREATED, headers, JSON)


def _add_list(router: APIRouter, resource: PlanResource) -> None:
    @router.get(
        "",
        summary="Which plans are there?",
        response_model=PlanList,
        dependencies=[Depends(accepts_json)],
    )
    async def get_plans(request: Request, query: Annotated[ListQuery, Query()]) -> Response:
        """The latest first, those that wait, run, were refused or cancelled included."""
        database: Database = request.app.state.database

        def read() -> list[Job]:
            with database.reading() as connection:
                return jobs.latest(
                    connection,
                    resource.kind.name,
                    query.limit + 1,
                    before=query.cursor,
                    state=query.state,
                    name=query.name,
                )

        found = await anyio.to_thread.run_sync(read)
        return Response(list_json(found, query.limit), media_type=JSON)


def _add_one(router: APIRouter, resource: PlanResource) -> None:
    @router.get(
        "/{plan_id}",
        summary="A plan, or where the work on it stands",
        response_model=resource.response | JobResponse,
        responses={304: _UNCHANGED, 404: _NO_SUCH},
        dependencies=[Depends(accepts_json)],
    )
    async def get_plan(request: Request, plan_id: PlanId) -> Response:
        """The answer to its POST once it is made; it never changes after that."""
        found = await find(request, resource, plan_id)
        if found.plan is not None:
            tag = immutable_tag(found.plan)
            if is_known_already(request, tag):
                return _unchanged(tag)
            answer = await whole_json(request, resource, found.plan)
        else:
            answer = job_json(found.job)
            tag = f'"{hashlib.sha256(answer).hexdigest()[:32]}"'
            if is_known_already(request, tag):
                return _unchanged(tag)
        return Response(answer, HTTPStatus.OK, _REVALIDATE | {"ETag": tag}, JSON)

    @router.delete(
        "/{plan_id}",
        summary="Cancel a plan, or delete one that is finished",
        response_model=JobResponse,
        responses={
            200: {"description": "What waited or ran has ended; `state` tells how"},
            202: {"model": JobResponse, "description": "It will end soon, elsewhere"},
            204: {"description": "Deleted; nothing but the audit trail remembers it"},
            404: _NO_SUCH,
        },
        dependencies=[Depends(accepts_json)],
    )
    async def delete_plan(request: Request, plan_id: PlanId) -> Response:
        """A solve that runs is killed; its processor is free within a second."""
        found = await find(request, resource, plan_id)
        key_id = getattr(request.state, "key_id", None)
        if not found.job.is_open:
            await anyio.to_thread.run_sync(_remove, request, found.job, key_id)
            return Response(status_code=HTTPStatus.NO_CONTENT)
        dispatcher: Dispatcher = request.app.state.dispatcher
        await anyio.to_thread.run_sync(dispatcher.cancel, plan_id, key_id)
        await wait_for_end(request, plan_id, CANCEL_WAIT_S)
        job = (await find(request, resource, plan_id)).job
        status = HTTPStatus.ACCEPTED if job.is_open else HTTPStatus.OK
        return Response(job_json(job), status, media_type=JSON)


_UNCHANGED = {"description": "If-None-Match names what the plan still is"}
_NO_SUCH = {"description": "There is no such plan"}


def _unchanged(tag: str) -> Response:
    return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=_REVALIDATE | {"ETag": tag})


def _remove(request: Request, job: Job, key_id: str | None) -> None:
    database: Database = request.app.state.database
    with database.writing() as connection:
        if jobs.remove(connection, job.id):
            audit.record(connection, key_id=key_id, action=f"{job.kind}.delete", subject=job.id)


def _add_table(router: APIRouter, resource: PlanResource) -> None:
    query_model = with_formats(TableQuery, resource)

    async def get_table(
        request: Request, plan_id: PlanId, query: Annotated[TableQuery, Query()]
    ) -> Response:
        """In the format `format` names or the Accept header asks for."""
        form = _form(request, resource, query)
        found = await find(request, resource, plan_id)
        headers = dict(_REVALIDATE)
        if found.plan is not None:
            headers["ETag"] = immutable_tag(found.plan, form or "table")
            if is_known_already(request, headers["ETag"]):
                return _unchanged(headers["ETag"])
        return await table_answer(request, resource, found, form, HTTPStatus.OK, headers)

    get_table.__annotations__["query"] = Annotated[query_model, Query()]
    router.get(
        "/{plan_id}/table",
        summary="The table of a plan by itself",
        response_class=Response,
        responses={
            200: {
                "description": "As JSON the `table` of the plan",
                "content": {media: {} for media in (JSON, *resource.format_by_media_type)},
            },
            304: _UNCHANGED,
            404: _NO_SUCH,
            409: {"description": "There is no table, or not yet"},
            422: {"description": "A table the judge rejects is in the whole plan only"},
        },
    )(get_table)


def _add_events(router: APIRouter, resource: PlanResource) -> None:
    @router.get(
        "/{plan_id}/events",
        summary="What happens to a plan, as it happens",
        response_class=StreamingResponse,
        responses={
            200: {
                "description": "Server-sent events `state` and `progress`, until the plan is made",
                "content": {EVENT_STREAM: {"example": EVENT_EXAMPLE}},
            },
            204: {"description": "Nothing comes after Last-Event-ID: don't reconnect"},
            404: _NO_SUCH,
        },
    )
    async def get_events(
        request: Request, plan_id: PlanId, seq: Annotated[int, Depends(last_event_id)]
    ) -> Response:
        """`data` is JSON: `at`, and `state` with `problem`, or `stage`, `done` and `of`."""
        preferred(request, (EVENT_STREAM,))
        found = await find(request, resource, plan_id)
        if not found.job.is_open and seq >= await anyio.to_thread.run_sync(
            last_seq, request.app.state.database, plan_id
        ):
            return Response(status_code=HTTPStatus.NO_CONTENT)
        return StreamingResponse(
            told(request, plan_id, seq),
            media_type=EVENT_STREAM,
            headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
        )
