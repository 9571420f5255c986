"""Routes of jobs, for any resource: accepted, waited for, listed, followed, cancelled, deleted."""

import hashlib
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import replace
from http import HTTPStatus
from types import MappingProxyType
from typing import Annotated, Any

from fastapi import APIRouter, Depends, HTTPException, Request, Response
from fastapi.responses import StreamingResponse
from sqlalchemy import Connection

from app.answers.job import JobResponse, job_json, list_json
from app.http.blocking import read
from app.http.negotiation import (
    EVENT_STREAM,
    JSON,
    ONLY_JSON,
    is_known_already,
    not_modified,
    preferred_type,
    revalidated,
    saved_as,
    weak_tag,
)
from app.http.openapi.schema import schema_of
from app.http.problems import problem_answer
from app.http.routes.parameters import ListQuery, PathId, last_event_id, read_query
from app.http.routes.resources import JobResource
from app.http.waiting import Patience, last_seq, patience, stream_events, wait_for_end
from app.ids import new_id
from app.jobs.child import Bounds
from app.jobs.dispatcher import Dispatcher
from app.jobs.kinds import JOB_KINDS
from app.jobs.refusals import Conflict, KeyReused
from app.store import audit, jobs
from app.store.database import Database
from app.store.job import Job
from app.store.jobs import NewJob
from app.versions import VERSION
from planner.base.errors import InvalidInput

CANCEL_WAIT_S = 5.0

# A job and the answer, in JSON, that tells of it as it stands; raises 404.
FindAnswer = Callable[[Request, str], Awaitable[tuple[Job, bytes]]]
# Of a job the file in a media type; raises Conflict where there is none yet.
WriteFile = Callable[[Request, Job, str], Awaitable[bytes]]


def new_job(
    request: Request,
    resource: JobResource,
    spec: Any,  # noqa: ANN401 (what the kind reads)
    body: bytes,
    **members: Any,  # noqa: ANN401 (of NewJob)
) -> NewJob:
    """A job for this request, which was read as `spec`."""
    return NewJob(
        id=new_id(),
        kind=resource.kind,
        name=spec.name,
        listing=resource.listing(spec),
        request=body,
        request_sha256=hashlib.sha256(body).hexdigest(),
        key_id=key_id_of(request),
        **members,
    )


def key_id_of(request: Request) -> str | None:
    """Id of the API key that a request came with."""
    key_id: str | None = getattr(request.state, "key_id", None)
    return key_id


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
    """The job for a request, new or known by its key; raises Conflict, KeyReused, QueueFull.

    plan_id: of the plan it is about.  revises: of the plan it replaces.
    """
    dispatcher: Dispatcher = request.app.state.dispatcher
    if revises is not None:
        _require_made(request.app.state.database, resource, revises)
    asked_by = "\0".join((key_id_of(request) or "", resource.kind, key or ""))
    new = new_job(
        request,
        resource,
        spec,
        body,
        deadline_s=bounds_of(request, resource).deadline_s,
        options=options,
        plan_id=plan_id,
        revises=revises,
        idempotency=None if key is None else hashlib.sha256(asked_by.encode()).hexdigest(),
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


def bounds_of(request: Request, resource: JobResource) -> Bounds:
    """Of the work on one, as the operator has them."""
    bounds = JOB_KINDS[resource.kind].bounds
    most_s = request.app.state.settings.job_deadline_s
    return replace(bounds, deadline_s=min(bounds.deadline_s, most_s))


def _require_made(database: Database, resource: JobResource, plan_id: str) -> None:
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


async def answer_to_post(
    request: Request,
    resource: JobResource,
    job: Job,
    prefer: str | None,
    wait_s: float,
    find: FindAnswer,
) -> Response:
    """201 with what was made while the client waited, 202 with how far it is, or its problem.

    wait_s: unless the client prefers another time.
    """
    waits = patience(prefer, wait_s)
    await wait_for_end(request, job.id, waits.wait_s)
    job, answer = await find(request, job.id)
    headers = headers_of_post(resource, job, waits)
    unmade = answer_unmade(request, job, waits, headers, answer)
    return unmade or Response(answer, HTTPStatus.CREATED, headers, JSON)


def headers_of_post(resource: JobResource, job: Job, waits: Patience) -> dict[str, str]:
    """Where the job's result will be, and which wish was followed."""
    location = f"{resource.path}/{job.id}"
    return {"Location": location, "Vary": "Accept, Prefer", **waits.headers}


def answer_unmade(
    request: Request, job: Job, waits: Patience, headers: Mapping[str, str], answer: bytes
) -> Response | None:
    """202 with the answer, or the problem of a job; None where it is done.

    Raises Conflict where it was cancelled while the client waited.
    """
    if job.is_open or waits.answers_at_once:  # though it may be done by now
        return Response(answer, HTTPStatus.ACCEPTED, headers, JSON)
    if job.problem is not None:
        return problem_answer(request, job.problem, headers)
    if job.state == "cancelled":
        raise Conflict("it was cancelled while it was waited for; ask again")
    return None


async def find_job(request: Request, resource: JobResource, job_id: str) -> Job:
    """Raises 404."""
    return await read(request, lambda connection: job_of(connection, resource, job_id))


def job_of(connection: Connection, resource: JobResource, job_id: str) -> Job:
    """The job that makes one of them; raises 404."""
    job = jobs.get(connection, job_id)
    if job is None or (job.kind != resource.kind and job.kind not in resource.also):
        raise _not_found(resource)
    return job


def _not_found(resource: JobResource) -> HTTPException:
    return HTTPException(
        HTTPStatus.NOT_FOUND,
        f"there is no {resource.singular} with this id; GET {resource.path} lists them",
    )


def add_list(router: APIRouter, resource: JobResource) -> None:
    """GET those there are, a page at a time."""

    @router.get(
        "",
        summary=f"List {resource.plural}",
        description=resource.about_list,
        response_model=resource.list_response,
        dependencies=ONLY_JSON,
    )
    async def get_list(
        request: Request, query: Annotated[ListQuery, Depends(read_query(resource.list_query))]
    ) -> Response:
        return await answer_list(request, resource, query)


async def answer_list(
    request: Request, resource: JobResource, query: ListQuery, plan_id: str | None = None
) -> Response:
    """Those the query asks for, the latest first; of one plan by its id."""
    jobs_and_one = await read(
        request,
        lambda connection: jobs.latest(
            connection,
            resource.kind,
            query.limit + 1,  # to know whether more come after
            before=query.cursor,
            parent_id=getattr(query, "campaign", None),
            plan_id=plan_id,
            list_filter=query.list_filter(),
        ),
    )
    answer = list_json(resource.list_response, jobs_and_one, query.limit)
    return Response(answer, media_type=JSON)


def add_one(
    router: APIRouter,
    resource: JobResource,
    find: FindAnswer,
    *,
    summary: str,
    about: str,
    suffixes: Mapping[str, str] = MappingProxyType({}),
    write_file: WriteFile | None = None,
) -> None:
    """GET how far one of them is; suffixes: of the files that Accept may ask for, by media type."""
    forms = (JSON, *suffixes)

    @router.get(
        "/{id}",
        summary=summary,
        description=about,
        response_model=resource.response,
        responses={200: {"content": {form: {} for form in forms}}},
    )
    async def get_one(request: Request, job_id: PathId) -> Response:
        media_type = preferred_type(request, forms)
        job, answer = await find(request, job_id)
        tag = tag_of(answer + media_type.encode())
        if is_known_already(request, tag):
            return not_modified(tag)
        headers = revalidated(tag)
        if write_file is not None and media_type != JSON:
            answer = await write_file(request, job, media_type)
            headers |= saved_as(job.name, resource.singular, suffixes[media_type])
        return Response(answer, headers=headers, media_type=media_type)


def tag_of(answer: bytes) -> str:
    """The ETag of what may change."""
    return weak_tag(hashlib.sha256(answer).hexdigest()[:32])


def tag_for_good(job_id: str, which: str = "json") -> str:
    """The ETag of what never changes, unless by another version of the program that writes it."""
    return weak_tag(f"{job_id}-{which}-{VERSION}")


def add_request(router: APIRouter, resource: JobResource) -> None:
    """GET what one of them was asked for by."""

    @router.get(
        "/{id}/request",
        summary=f"Get the request for a {resource.singular}",
        response_class=Response,
        responses={
            200: {
                "description": "The request byte for byte; a POST takes it as it stands",
                "content": {JSON: {"schema": schema_of(resource.requests)}},
            }
        },
        dependencies=ONLY_JSON,
    )
    async def get_request(request: Request, job_id: PathId) -> Response:
        """Requests are kept as they were sent; those for passes are written by their campaign."""
        job = await find_job(request, resource, job_id)
        tag = weak_tag(job.request_sha256)
        if is_known_already(request, tag):
            return not_modified(tag)
        body = await read(request, lambda connection: jobs.request_of(connection, job_id))
        if body is None:
            raise _not_found(resource)  # removed just now
        return Response(body, headers=revalidated(tag), media_type=JSON)


def add_delete(router: APIRouter, resource: JobResource) -> None:
    """DELETE one of them: cancel or forget."""

    @router.delete(
        "/{id}",
        summary=f"Cancel or delete a {resource.singular}",
        response_model=JobResponse,
        responses={
            200: {"description": "The work has ended; `state` says how"},
            202: {"model": JobResponse, "description": "The work will end soon, here or elsewhere"},
            204: {"description": "Deleted; only the audit log remembers it"},
        },
        dependencies=ONLY_JSON,
    )
    async def delete(request: Request, job_id: PathId) -> Response:
        """Cancels work that waits or runs, whose processor is free within a second; deletes what
        is finished."""
        job = await find_job(request, resource, job_id)
        if not job.is_open:
            return await answer_removal(request, resource, job)
        dispatcher: Dispatcher = request.app.state.dispatcher
        database: Database = request.app.state.database
        await database.answer(dispatcher.cancel, job_id, key_id_of(request))
        await wait_for_end(request, job_id, CANCEL_WAIT_S)
        job = await find_job(request, resource, job_id)
        status = HTTPStatus.ACCEPTED if job.is_open else HTTPStatus.OK
        return Response(job_json(job), status, media_type=JSON)


async def answer_removal(request: Request, resource: JobResource, job: Job) -> Response:
    """204, once nothing but the audit log remembers a job that has ended."""
    database: Database = request.app.state.database
    key_id = key_id_of(request)

    def remove() -> bool:
        with database.writing() as connection:
            gone = jobs.remove(connection, job.id)
            if gone:
                audit.record(connection, key_id=key_id, action=f"{job.kind}.delete", subject=job.id)
        return gone

    if not await database.answer(remove):
        raise _not_found(resource)  # another removed it just now
    return Response(status_code=HTTPStatus.NO_CONTENT)


def add_events(router: APIRouter, resource: JobResource) -> None:
    """GET what happens to one of them."""

    @router.get(
        "/{id}/events",
        summary=f"Stream the events of a {resource.singular}",
        response_class=StreamingResponse,
        responses={
            200: {
                "description": "Server-sent events `state` and `progress`, until it has ended",
                "content": {EVENT_STREAM: {}},
            },
            204: {"description": "Nothing comes after Last-Event-ID: don't reconnect"},
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
