"""Routes of jobs, for any resource: accepted, followed, cancelled, deleted."""

import hashlib
from collections.abc import Mapping
from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Depends, HTTPException, Request, Response
from fastapi.responses import StreamingResponse
from sqlalchemy import Connection

from app.answers.job import JobResponse, job_json
from app.http.blocking import read
from app.http.event_stream import EVENT_STREAM, last_seq, stream_events
from app.http.negotiation import JSON, accepts_json, is_known_already, preferred_type, weak_tag
from app.http.openapi.schema import REF
from app.http.routes.plan_queries import ListQuery, PathId, last_event_id
from app.http.routes.resources import JobResource
from app.http.waiting import wait_for_end
from app.jobs.dispatcher import Dispatcher
from app.jobs.kinds import JOB_KINDS
from app.jobs.refusals import KeyReused
from app.store import audit, jobs
from app.store.database import Database
from app.store.ids import new_id
from app.store.jobs import Job, NewJob

CANCEL_WAIT_S = 5.0
PREFER = (
    "`wait=N`: answer 202 when it isn't done within N seconds (30 by default, at most 60); "
    "`respond-async`, `wait=0`: answer 202 at once."
)


def no_such(resource: JobResource) -> dict[str, Any]:
    """The answer to an id of nothing, documented."""
    return {"description": f"There is no such {resource.singular}"}


def accept_job(
    request: Request,
    resource: JobResource,
    spec: Any,  # noqa: ANN401 (what the kind reads)
    body: bytes,
    key: str | None,
    options: Mapping[str, Any],
    plan_id: str | None = None,
    revises: str | None = None,
) -> Job:
    """The job for a request, new or known by its key; raises KeyReused, QueueFull.

    plan_id: of the plan it is about.  revises: of the plan it replaces.
    """
    state, kind = request.app.state, JOB_KINDS[resource.kind]
    dispatcher: Dispatcher = state.dispatcher
    key_id = getattr(request.state, "key_id", None)
    new = NewJob(
        id=new_id(),
        kind=kind.name,
        name=spec.name,
        listing=resource.listing(spec),
        request=body,
        request_sha256=hashlib.sha256(body).hexdigest(),
        deadline_s=min(kind.bounds.deadline_s, state.settings.job_deadline_s),
        options=options,
        key_id=key_id,
        plan_id=plan_id,
        revises=revises,
        idempotency=None if key is None else _digest(key_id or "", kind.name, key),
    )
    job = dispatcher.submit(new, spec)
    if any(getattr(job, name) != getattr(new, name) for name in _ASKED):
        raise KeyReused(
            "this Idempotency-Key came with another request before; send a new key with a new "
            "request",
            field="header.Idempotency-Key",
        )
    return job


# What is asked again with a key must be the same.
_ASKED = ("request_sha256", "options", "revises")


def _digest(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


async def find_job(request: Request, resource: JobResource, job_id: str) -> Job:
    """Raises 404."""
    return await read(request, lambda connection: job_of(connection, resource, job_id))


def job_of(connection: Connection, resource: JobResource, job_id: str) -> Job:
    """The job that makes one of them; raises 404."""
    job = jobs.get(connection, job_id)
    if job is None or job.kind != resource.kind:
        raise _not_found(resource)
    return job


def _not_found(resource: JobResource) -> HTTPException:
    return HTTPException(
        HTTPStatus.NOT_FOUND,
        f"there is no {resource.singular} with this id; GET {resource.path} lists them",
    )


async def list_jobs(
    request: Request, resource: JobResource, query: ListQuery, campaign_id: str | None = None
) -> list[Job]:
    """Those the query asks for and one more, the latest first; a campaign's passes by its id."""
    return await read(
        request,
        lambda connection: jobs.latest(
            connection,
            resource.kind,
            query.limit + 1,  # to know whether more come after
            before=query.cursor,
            parent_id=campaign_id,
            list_filter=query.list_filter(),
        ),
    )


def add_request(router: APIRouter, resource: JobResource) -> None:
    """GET what one of them was asked for by."""

    @router.get(
        "/{id}/request",
        summary=f"Get the request for a {resource.singular}",
        response_class=Response,
        responses={
            200: {
                "description": "The request byte for byte; a POST takes it as it stands",
                "content": {JSON: {"schema": {"$ref": REF.format(model=resource.request_schema)}}},
            },
            304: {"description": "Unchanged, as always: If-None-Match names its ETag"},
            404: no_such(resource),
        },
        dependencies=[Depends(accepts_json)],
        name=f"get_{resource.singular}_request",
    )
    async def get_request(request: Request, job_id: PathId) -> Response:
        """Requests are kept as they were sent; those for passes are written by their campaign."""
        job = await find_job(request, resource, job_id)
        tag = weak_tag(job.request_sha256)
        headers = {"Cache-Control": "private, no-cache", "ETag": tag}
        if is_known_already(request, tag):
            return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
        body = await read(request, lambda connection: jobs.request_of(connection, job_id))
        if body is None:
            raise _not_found(resource)  # removed just now
        return Response(body, headers=headers, media_type=JSON)


def add_delete(router: APIRouter, resource: JobResource) -> None:
    """DELETE one of them: cancel or forget."""

    async def delete(request: Request, job_id: PathId) -> Response:
        """Cancels work that waits or runs, whose processor is free within a second; deletes what
        is finished."""
        job = await find_job(request, resource, job_id)
        key_id = getattr(request.state, "key_id", None)
        database: Database = request.app.state.database
        if not job.is_open:
            if not await database.answer(_remove, database, job, key_id):
                raise _not_found(resource)  # another removed it just now
            return Response(status_code=HTTPStatus.NO_CONTENT)
        dispatcher: Dispatcher = request.app.state.dispatcher
        await database.answer(dispatcher.cancel, job_id, key_id)
        await wait_for_end(request, job_id, CANCEL_WAIT_S)
        job = await find_job(request, resource, job_id)
        status = HTTPStatus.ACCEPTED if job.is_open else HTTPStatus.OK
        return Response(job_json(job), status, media_type=JSON)

    router.delete(
        "/{id}",
        summary=f"Cancel or delete a {resource.singular}",
        response_model=JobResponse,
        responses={
            200: {"description": "The work has ended; `state` says how"},
            202: {"model": JobResponse, "description": "The work will end soon, here or elsewhere"},
            204: {"description": "Deleted; only the audit log remembers it"},
            404: no_such(resource),
        },
        dependencies=[Depends(accepts_json)],
        name=f"delete_{resource.singular}",
    )(delete)


def add_removal(router: APIRouter, resource: JobResource) -> None:
    """DELETE one of what is never at work."""

    async def delete(request: Request, job_id: PathId) -> Response:
        """Only the audit log remembers a search that was deleted."""
        job = await find_job(request, resource, job_id)
        key_id = getattr(request.state, "key_id", None)
        database: Database = request.app.state.database
        if not await database.answer(_remove, database, job, key_id):
            raise _not_found(resource)  # another removed it just now
        return Response(status_code=HTTPStatus.NO_CONTENT)

    router.delete(
        "/{id}",
        summary=f"Delete a {resource.singular}",
        status_code=HTTPStatus.NO_CONTENT,
        response_class=Response,
        responses={404: no_such(resource)},
        dependencies=[Depends(accepts_json)],
        name=f"delete_{resource.singular}",
    )(delete)


def _remove(database: Database, job: Job, key_id: str | None) -> bool:
    with database.writing() as connection:
        gone = jobs.remove(connection, job.id)
        if gone:
            audit.record(connection, key_id=key_id, action=f"{job.kind}.delete", subject=job.id)
    return gone


def add_events(router: APIRouter, resource: JobResource) -> None:
    """GET what happens to one of them."""

    @router.get(
        "/{id}/events",
        summary=f"Stream a {resource.singular}'s events",
        response_class=StreamingResponse,
        responses={
            200: {
                "description": "Server-sent events `state` and `progress`, until it has ended",
                "content": {EVENT_STREAM: {}},
            },
            204: {"description": "Nothing comes after Last-Event-ID: don't reconnect"},
            404: no_such(resource),
        },
    )
    async def get_events(
        request: Request, job_id: PathId, seq: Annotated[int, Depends(last_event_id)]
    ) -> Response:
        """`data` is JSON: `at`, and `state` with `problem`, or `stage`, `done`, `of` and `percent`.

        `percent` is a share of the usual time; it is null where that isn't known.
        """
        preferred_type(request, (EVENT_STREAM,))
        job = await find_job(request, resource, job_id)
        if not job.is_open and seq >= await last_seq(request, job_id):
            return Response(status_code=HTTPStatus.NO_CONTENT)
        return StreamingResponse(
            stream_events(request, job_id, seq),
            media_type=EVENT_STREAM,
            headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
        )
