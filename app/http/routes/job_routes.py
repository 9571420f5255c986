"""The resources that jobs make, and their routes.

Work is accepted, waited for, listed, followed, cancelled, deleted: for any resource alike.
"""

import hashlib
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, replace
from http import HTTPStatus
from types import MappingProxyType
from typing import Annotated, Any

from fastapi import APIRouter, Depends, HTTPException, Request, Response
from fastapi.responses import StreamingResponse
from sqlalchemy import Connection

from app.answers.job import JobResponse, job_json, list_json
from app.http.blocking import database_of, read
from app.http.negotiation import (
    EVENT_STREAM,
    JSON,
    ONLY_JSON,
    preferred_type,
    revalidated,
    saved_as,
    weak_tag,
)
from app.http.openapi.schema import schema_of
from app.http.problems import problem_answer
from app.http.routes.parameters import ListQuery, PathId, last_event_id, read_query
from app.http.waiting import Patience, last_seq, patience, stream_events, wait_for_end
from app.ids import new_id
from app.jobs.child import Bounds
from app.jobs.dispatcher import Dispatcher
from app.jobs.kinds import JOB_KINDS
from app.jobs.refusals import Conflict, KeyReused
from app.requests.examples import Examples
from app.requests.json_reader import JsonReader
from app.store import audit, jobs
from app.store.database import Database
from app.store.job import Job, Listing
from app.store.jobs import NewJob
from app.versions import VERSION
from planner.base.errors import InvalidInput

CANCEL_WAIT_S = 5.0
# What is asked again with a key must be the same.
_ASKED = ("request_sha256", "options", "revises")

# A job and the answer, in JSON, that tells of it as it stands; raises 404.
FindAnswer = Callable[[Request, str], Awaitable[tuple[Job, bytes]]]
# Of a job the file in a media type; raises Conflict where there is none yet.
WriteFile = Callable[[Request, Job, str], Awaitable[bytes]]


@dataclass(frozen=True, kw_only=True)
class JobResource:
    """What is at `path` and kept as jobs of one kind, by its name.

    singular, plural: what they are called.  requests: reads those for one.
    listing: what lists tell of a request, as it was read.  response: of one; list_response: of
    several.  list_query: which of them to list, about_list: in what order.
    also: kinds of jobs that are found here by their id, too.
    """

    kind: str
    also: frozenset[str] = frozenset()
    path: str
    tag: str
    requests: JsonReader[Any]
    examples: Examples
    listing: Callable[[Any], Listing]
    singular: str
    plural: str
    response: type
    list_response: type
    list_query: type[ListQuery] = ListQuery
    about_list: str = "The latest come first."

    def new_job(
        self,
        request: Request,
        spec: Any,  # noqa: ANN401 (what the kind reads)
        body: bytes,
        **members: Any,  # noqa: ANN401 (of NewJob)
    ) -> NewJob:
        return NewJob(
            id=new_id(),
            kind=self.kind,
            name=spec.name,
            request=body,
            request_sha256=hashlib.sha256(body).hexdigest(),
            key_id=_key_id_of(request),
            **{"listing": self.listing(spec)} | members,
        )

    def accept(
        self,
        request: Request,
        spec: Any,  # noqa: ANN401 (what the kind reads)
        body: bytes,
        key: str | None,
        **members: Any,  # noqa: ANN401 (of NewJob)
    ) -> Job:
        """The job for a request, new or known by its key; raises Conflict, KeyReused, QueueFull."""
        dispatcher: Dispatcher = request.app.state.dispatcher
        if members.get("revises") is not None:
            self.require_made(database_of(request), members["revises"])
        asked_by = "\0".join((_key_id_of(request) or "", self.kind, key or ""))
        digest = None if key is None else hashlib.sha256(asked_by.encode()).hexdigest()
        members |= {"deadline_s": self.bounds(request).deadline_s, "idempotency": digest}
        new = self.new_job(request, spec, body, **members)
        job = dispatcher.submit(new, spec)
        if any(getattr(job, name) != getattr(new, name) for name in _ASKED):
            raise KeyReused(
                "this Idempotency-Key came with another request before; send a new key with a new "
                "request",
                field="header.Idempotency-Key",
            )
        return job

    def bounds(self, request: Request) -> Bounds:
        """Of the work on one, as the operator has them."""
        bounds = JOB_KINDS[self.kind].bounds
        most_s = request.app.state.settings.job_deadline_s
        return replace(bounds, deadline_s=min(bounds.deadline_s, most_s))

    def require_made(self, database: Database, plan_id: str) -> None:
        """Raises InvalidInput, Conflict where there is nothing of this id to revise."""
        with database.reading() as connection:
            job = jobs.get(connection, plan_id)
        if job is None or job.kind != self.kind:
            raise InvalidInput(
                f"there is no {self.singular} {plan_id}; GET {self.path} lists them",
                field="query.revises",
            )
        if job.state not in ("done", "failed") or job.problem is not None:
            raise Conflict(
                f"the {self.singular} to revise was not made: its state is {job.state}",
                field="query.revises",
            )

    async def answer_to_post(
        self, request: Request, job: Job, prefer: str | None, wait_s: float, find: FindAnswer
    ) -> Response:
        """201 with what was made while the client waited, 202 with how far it is, or its problem.

        wait_s: unless the client prefers another time.
        """
        waits = patience(prefer, wait_s)
        await wait_for_end(request, job.id, waits.wait_s)
        job, answer = await find(request, job.id)
        headers = self.headers_of_post(job, waits)
        unmade = answer_unmade(request, job, waits, headers, answer)
        return unmade or Response(answer, HTTPStatus.CREATED, headers, JSON)

    def headers_of_post(self, job: Job, waits: Patience) -> dict[str, str]:
        location = f"{self.path}/{job.id}"
        return {"Location": location, "Vary": "Accept, Prefer", **waits.headers}

    async def find_job(self, request: Request, job_id: str) -> Job:
        """Raises 404."""
        return await read(request, lambda connection: self.job_of(connection, job_id))

    def job_of(self, connection: Connection, job_id: str) -> Job:
        """The job that makes one of them; raises 404."""
        job = jobs.get(connection, job_id)
        if job is None or (job.kind != self.kind and job.kind not in self.also):
            raise self._not_found()
        return job

    def _not_found(self) -> HTTPException:
        return HTTPException(
            HTTPStatus.NOT_FOUND,
            f"there is no {self.singular} with this id; GET {self.path} lists them",
        )

    def add_list(self, router: APIRouter) -> None:
        @router.get(
            "",
            summary=f"List {self.plural}",
            description=self.about_list,
            response_model=self.list_response,
            dependencies=ONLY_JSON,
        )
        async def get_list(
            request: Request, query: Annotated[ListQuery, Depends(read_query(self.list_query))]
        ) -> Response:
            return await self.answer_list(request, query)

    async def answer_list(
        self, request: Request, query: ListQuery, plan_id: str | None = None
    ) -> Response:
        """Those the query asks for, the latest first; of one plan by its id."""
        jobs_and_one = await read(
            request,
            lambda connection: jobs.latest(
                connection,
                self.kind,
                query.limit + 1,  # to know whether more come after
                before=query.cursor,
                parent_id=getattr(query, "campaign", None),
                plan_id=plan_id,
                filters={name: getattr(query, name) for name in jobs.FILTERS},
            ),
        )
        answer = list_json(self.list_response, jobs_and_one, query.limit)
        return Response(answer, media_type=JSON)

    def add_one(
        self,
        router: APIRouter,
        find: FindAnswer,
        *,
        summary: str,
        about: str,
        suffixes: Mapping[str, str] = MappingProxyType({}),
        write_file: WriteFile | None = None,
    ) -> None:
        """GET how far one is; suffixes: of the files that Accept may ask for, by media type."""
        forms = (JSON, *suffixes)

        @router.get(
            "/{id}",
            summary=summary,
            description=about,
            response_model=self.response,
            responses={200: {"content": {form: {} for form in forms}}},
        )
        async def get_one(request: Request, job_id: PathId) -> Response:
            media_type = preferred_type(request, forms)
            job, answer = await find(request, job_id)
            headers = revalidated(request, tag_of(answer + media_type.encode()))
            if write_file is not None and media_type != JSON:
                answer = await write_file(request, job, media_type)
                headers |= saved_as(job.name, self.singular, suffixes[media_type])
            return Response(answer, headers=headers, media_type=media_type)

    def add_request(self, router: APIRouter) -> None:
        @router.get(
            "/{id}/request",
            summary=f"Get the request for a {self.singular}",
            response_class=Response,
            responses={
                200: {
                    "description": "The request byte for byte; a POST takes it as it stands",
                    "content": {JSON: {"schema": schema_of(self.requests)}},
                }
            },
            dependencies=ONLY_JSON,
        )
        async def get_request(request: Request, job_id: PathId) -> Response:
            """Requests are kept as they were sent; those for passes are written by their
            campaign."""
            job = await self.find_job(request, job_id)
            headers = revalidated(request, weak_tag(job.request_sha256))
            body = await read(request, lambda connection: jobs.request_of(connection, job_id))
            if body is None:
                raise self._not_found()  # removed just now
            return Response(body, headers=headers, media_type=JSON)

    def add_delete(self, router: APIRouter) -> None:
        @router.delete(
            "/{id}",
            summary=f"Cancel or delete a {self.singular}",
            response_model=JobResponse,
            responses={
                200: {"description": "The work has ended; `state` says how"},
                202: {
                    "model": JobResponse,
                    "description": "The work will end soon, here or elsewhere",
                },
                204: {"description": "Deleted; only the audit log remembers it"},
            },
            dependencies=ONLY_JSON,
        )
        async def delete(request: Request, job_id: PathId) -> Response:
            """Cancels work that waits or runs, whose processor is free within a second; deletes
            what is finished."""
            job = await self.find_job(request, job_id)
            if not job.is_open:
                return await self.answer_removal(request, job)
            cancel = request.app.state.dispatcher.cancel
            await database_of(request).answer(cancel, job_id, _key_id_of(request))
            await wait_for_end(request, job_id, CANCEL_WAIT_S)
            job = await self.find_job(request, job_id)
            status = HTTPStatus.ACCEPTED if job.is_open else HTTPStatus.OK
            return Response(job_json(job), status, media_type=JSON)

    async def answer_removal(self, request: Request, job: Job) -> Response:
        """204, once nothing but the audit log remembers a job that has ended."""
        database = database_of(request)
        key_id, action = _key_id_of(request), f"{job.kind}.delete"

        def remove() -> bool:
            with database.writing() as connection:
                gone = jobs.remove(connection, job.id)
                if gone:
                    audit.record(connection, key_id=key_id, action=action, subject=job.id)
            return gone

        if not await database.answer(remove):
            raise self._not_found()  # another removed it just now
        return Response(status_code=HTTPStatus.NO_CONTENT)

    def add_events(self, router: APIRouter) -> None:
        @router.get(
            "/{id}/events",
            summary=f"Stream the events of a {self.singular}",
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
            """`data` is JSON: `at`, and `state` with `problem`, or `stage`, `done`, `of` and
            `percent`, of a campaign also `value` and `bound`.

            `percent` is a share of the usual time; it is null where that isn't known.
            """
            preferred_type(request, (EVENT_STREAM,))
            job = await self.find_job(request, job_id)
            if not job.is_open and seq >= await last_seq(request, job_id):
                return Response(status_code=HTTPStatus.NO_CONTENT)
            return StreamingResponse(
                stream_events(request, job_id, seq),
                media_type=EVENT_STREAM,
                headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
            )


def _key_id_of(request: Request) -> str | None:
    key_id: str | None = getattr(request.state, "key_id", None)
    return key_id


def answer_unmade(
    request: Request, job: Job, waits: Patience, headers: Mapping[str, str], answer: bytes
) -> Response | None:
    """202 with the answer, or the problem of a job; None where it is done.

    Raises Conflict where it was cancelled while the client waited.
    """
    if job.is_open or waits.wait_s == 0:  # then though it may be done by now
        return Response(answer, HTTPStatus.ACCEPTED, headers, JSON)
    if job.problem is not None:
        return problem_answer(request, job.problem, headers)
    if job.state == "cancelled":
        raise Conflict("it was cancelled while it was waited for; ask again")
    return None


def tag_of(answer: bytes) -> str:
    """The ETag of what may change."""
    return weak_tag(hashlib.sha256(answer).hexdigest()[:32])


def tag_for_good(job_id: str, which: str = "json") -> str:
    """The ETag of what never changes, unless by another version of the program that writes it."""
    return weak_tag(f"{job_id}-{which}-{VERSION}")
