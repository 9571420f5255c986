"""Flights of a plan over HTTP: posted, followed, listed, ended."""

from dataclasses import replace
from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Header, HTTPException, Query, Request, Response
from sqlalchemy import Connection

from app.answers.flights import FlightsList, FlightsResponse, flights_json, flights_list_json
from app.http.blocking import read
from app.http.negotiation import JSON, accepts_json, json_body
from app.http.openapi.schema import request_body
from app.http.problems import problem_answer
from app.http.routes.jobs import (
    PREFER,
    accept_job,
    add_delete,
    add_events,
    job_of,
    list_jobs,
    no_such,
)
from app.http.routes.plan_queries import ListQuery, PathId, idempotency_key
from app.http.routes.plans import PLANS
from app.http.routes.resources import JobResource
from app.http.waiting import WAIT_S, patience, wait_for_end
from app.jobs.kinds import FLIGHTS, PLAN, SPACECRAFT_PLAN
from app.jobs.refusals import Conflict
from app.requests.examples.flights import FLIGHTS_EXAMPLES
from app.requests.flights import FlightsRequest, read_flights_request
from app.store import flights, jobs, plans
from app.store.database import Database
from app.store.jobs import NEEDS_ALL, Job
from app.store.listing import Listing
from app.work.flights import PlanToFly, unpacked_outcomes

RESOURCE = JobResource(
    kind=FLIGHTS.name,
    path="/v1/flights",
    request_schema=FlightsRequest.__name__,
    listing=lambda _: Listing(),
    singular="flight",
)
router = APIRouter(tags=["flights"])
_of_plan = APIRouter(prefix=f"{PLANS.path}/{{id}}/flights")
_one = APIRouter(prefix=RESOURCE.path)


@_of_plan.post(
    "",
    summary="Fly a plan many times, with errors drawn anew",
    status_code=HTTPStatus.CREATED,
    response_model=FlightsResponse,
    responses={
        201: {"description": "All runs are flown"},
        202: {
            "model": FlightsResponse,
            "description": "Accepted; GET Location tells what the runs flown so far say",
            "headers": {"Location": {"schema": {"type": "string"}}},
        },
        404: no_such(PLANS),
        409: {"description": "There is no table to fly, or not yet; or cancelled while waited for"},
    },
    openapi_extra=request_body(RESOURCE.request_schema, FLIGHTS_EXAMPLES),
    dependencies=[Depends(accepts_json)],
)
async def post_flights(
    request: Request,
    plan_id: PathId,
    body: Annotated[bytes, Depends(json_body)],
    key: Annotated[str | None, Depends(idempotency_key)],
    prefer: Annotated[str | None, Header(description=PREFER)] = None,
) -> Response:
    """How often the camera holds the target, how sharply, and what is to blame.

    Orbit, attitude, clock, the Earth's turning and the drives are off in each run as the plan's
    pointing budget says; the runs are shared among all processors.
    """
    job = await anyio.to_thread.run_sync(_accept, request, plan_id, body, key)
    waits = patience(prefer, WAIT_S)
    await wait_for_end(request, job.id, waits.wait_s)
    job, answer = await _find(request, job.id)
    headers = {"Location": f"{RESOURCE.path}/{job.id}", "Vary": "Prefer", **waits.headers}
    if waits.is_none or job.is_open:
        return Response(answer, HTTPStatus.ACCEPTED, headers, JSON)
    if job.problem is not None:
        return problem_answer(request, job.problem, headers)
    if job.state != "done":
        raise Conflict("the flights were cancelled while they were waited for; ask again")
    return Response(answer, HTTPStatus.CREATED, headers, JSON)


@_of_plan.get(
    "",
    summary="Which flights of a plan are there?",
    response_model=FlightsList,
    responses={404: no_such(PLANS)},
    dependencies=[Depends(accepts_json)],
)
async def get_flights_of_plan(
    request: Request, plan_id: PathId, query: Annotated[ListQuery, Query()]
) -> Response:
    """The latest first."""

    def reading(connection: Connection) -> list[Job]:
        _require_plan(connection, plan_id)
        return jobs.latest(
            connection,
            RESOURCE.kind,
            query.limit + 1,
            before=query.cursor,
            plan_id=plan_id,
            sought=query.sought(),
        )

    return Response(flights_list_json(await read(request, reading), query.limit), media_type=JSON)


@_one.get(
    "",
    summary="Which flights are there?",
    response_model=FlightsList,
    dependencies=[Depends(accepts_json)],
)
async def get_flights(request: Request, query: Annotated[ListQuery, Query()]) -> Response:
    """Of all plans, the latest first."""
    jobs_and_one = await list_jobs(request, RESOURCE, query)
    return Response(flights_list_json(jobs_and_one, query.limit), media_type=JSON)


@_one.get(
    "/{id}",
    summary="Flights of a plan, as far as they are",
    response_model=FlightsResponse,
    responses={404: no_such(RESOURCE)},
    dependencies=[Depends(accepts_json)],
)
async def get_flight(request: Request, flights_id: PathId) -> Response:
    """What the runs flown so far say; it doesn't change once they are all."""
    _, answer = await _find(request, flights_id)
    return Response(answer, media_type=JSON, headers={"Cache-Control": "no-cache"})


def _accept(request: Request, plan_id: str, body: bytes, key: str | None) -> Job:
    """The job, new or known by its key; raises 404, Conflict, KeyReused, QueueFull."""
    spec = read_flights_request(body)
    database: Database = request.app.state.database
    with database.reading() as connection:
        job = _require_plan(connection, plan_id)
        plan = plans.get(connection, plan_id)
        asked = jobs.request_of(connection, plan_id)
    if plan is None or plan.state != "done" or asked is None:
        raise Conflict(
            f"there is no verified table to fly: the plan's state is {job.state}; GET "
            f"{PLANS.path}/{plan_id} tells more"
        )
    what = PlanToFly(plan_id=plan_id, asked=body, request=asked, table_columns=plan.table_columns)
    resource = replace(RESOURCE, listing=lambda _: _listing(job))
    options = {"runs": spec.runs, "seed": spec.seed, NEEDS_ALL: "runs"}
    return accept_job(request, resource, spec, what.to_bytes(), key, options, plan_id=plan_id)


def _listing(plan: Job) -> Listing:
    """What lists tell of its flights, too."""
    return Listing(
        platform=plan.platform or "",
        start_utc=plan.start_utc,
        stop_utc=plan.stop_utc,
        targets=tuple(plan.targets or ()),
    )


def _require_plan(connection: Connection, plan_id: str) -> Job:
    """Raises 404, with what flies a spacecraft."""
    job = jobs.get(connection, plan_id)
    if job is not None and job.kind == SPACECRAFT_PLAN.name:
        raise HTTPException(
            HTTPStatus.NOT_FOUND,
            "flights are of plans of the platform; a spacecraft's plan tells what its own "
            "closed-loop runs did, in `flight`",
        )
    return job_of(connection, PLANS, plan_id) if job is None or job.kind != PLAN.name else job


async def _find(request: Request, job_id: str) -> tuple[Job, bytes]:
    """The job, and the answer that tells of it; raises 404."""

    def reading(connection: Connection) -> tuple[Job, bytes | None, list[bytes]]:
        job = job_of(connection, RESOURCE, job_id)
        return job, flights.get(connection, job_id), flights.parts_of(connection, job_id)

    job, document, parts = await read(request, reading)

    def answer() -> bytes:
        return flights_json(job, document, [unpacked_outcomes(part) for part in parts])

    return job, await anyio.to_thread.run_sync(answer)


add_delete(_one, RESOURCE)
add_events(_one, RESOURCE)
router.include_router(_of_plan)
router.include_router(_one)
