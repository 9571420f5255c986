"""Routes of a plan's flights: posted and listed."""

from dataclasses import replace
from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Depends, Header, HTTPException, Query, Request, Response
from sqlalchemy import Connection

from app.answers.flights import FlightsList, FlightsResponse, flights_list_json
from app.http.blocking import read
from app.http.negotiation import JSON, accepts_json, json_body
from app.http.openapi.schema import request_body
from app.http.problems import problem_answer
from app.http.routes.flights import RESOURCE, find_flights
from app.http.routes.jobs import PREFER, accept_job, job_of, no_such
from app.http.routes.plan_queries import ListQuery, PathId, idempotency_key
from app.http.routes.plans import PLANS
from app.http.waiting import WAIT_S, patience, wait_for_end
from app.jobs.kinds import SPACECRAFT_PLAN
from app.jobs.refusals import Conflict
from app.requests.examples import FLIGHTS_EXAMPLES
from app.requests.flights import read_flights_request
from app.store import jobs, plans
from app.store.database import Database
from app.store.jobs import NEEDS_ALL, Job
from app.store.listing import Listing
from app.work.flights import PlanToFly

router = APIRouter(tags=["flights"], prefix=f"{PLANS.path}/{{id}}/flights")


@router.post(
    "",
    summary="Fly a plan many times",
    status_code=HTTPStatus.CREATED,
    response_model=FlightsResponse,
    responses={
        201: {"description": "All runs are flown"},
        202: {
            "model": FlightsResponse,
            "description": "Accepted; GET Location covers the runs flown so far",
            "headers": {"Location": {"schema": {"type": "string"}}},
        },
        404: no_such(PLANS),
        409: {"description": "The plan has no table, or none yet; or the flights were cancelled"},
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
    """Simulates the table with errors drawn at random for each run, and reports how often the
    camera holds the target, how sharply, and which error contributes most.

    The errors of orbit, attitude, clock, Earth orientation and drives have the sigmas of the
    plan's pointing budget; the runs are shared among all processors.
    """
    database: Database = request.app.state.database
    job = await database.answer(_accept, request, plan_id, body, key)
    waits = patience(prefer, WAIT_S)
    await wait_for_end(request, job.id, waits.wait_s)
    job, answer = await find_flights(request, job.id)
    headers = {"Location": f"{RESOURCE.path}/{job.id}", "Vary": "Prefer", **waits.headers}
    if waits.is_none or job.is_open:
        return Response(answer, HTTPStatus.ACCEPTED, headers, JSON)
    if job.problem is not None:
        return problem_answer(request, job.problem, headers)
    if job.state != "done":
        raise Conflict("the flights were cancelled while they were waited for; ask again")
    return Response(answer, HTTPStatus.CREATED, headers, JSON)


@router.get(
    "",
    summary="List flights of a plan",
    response_model=FlightsList,
    responses={404: no_such(PLANS)},
    dependencies=[Depends(accepts_json)],
)
async def get_flights_of_plan(
    request: Request, plan_id: PathId, query: Annotated[ListQuery, Query()]
) -> Response:
    """The latest come first."""

    def reading(connection: Connection) -> list[Job]:
        _require_plan(connection, plan_id)
        return jobs.latest(
            connection,
            RESOURCE.kind,
            query.limit + 1,
            before=query.cursor,
            plan_id=plan_id,
            list_filter=query.list_filter(),
        )

    return Response(flights_list_json(await read(request, reading), query.limit), media_type=JSON)


def _accept(request: Request, plan_id: str, body: bytes, key: str | None) -> Job:
    """The job, new or known by its key; raises 404, Conflict, KeyReused, QueueFull."""
    spec = read_flights_request(body)
    database: Database = request.app.state.database
    with database.reading() as connection:
        job = _require_plan(connection, plan_id)
        plan = plans.get(connection, job)
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
    return job_of(connection, PLANS, plan_id)
