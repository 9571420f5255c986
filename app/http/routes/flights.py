"""Routes of flights: a plan's posted and listed; those of all plans listed, followed, ended."""

from collections.abc import Sequence
from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from sqlalchemy import Connection

from app.answers.job import list_class
from app.http.blocking import database_of, read
from app.http.negotiation import ONLY_JSON, json_body
from app.http.openapi.schema import json_body_of
from app.http.routes.job_routes import JobResource
from app.http.routes.parameters import IdempotencyKey, ListQuery, PathId, Prefer
from app.http.routes.plans import PLANS
from app.http.waiting import WAIT_S
from app.jobs.kinds import FLIGHTS
from app.jobs.refusals import Conflict
from app.requests.examples import FLIGHTS_EXAMPLES
from app.store import plans, results
from app.store.job import Job, Listing
from app.store.jobs import NEEDS_ALL
from app.work.flights import (
    FLIGHTS_READER,
    FlightsResponse,
    PlanToFly,
    flights_json,
    unpacked_outcomes,
)

RESOURCE = JobResource(
    kind=FLIGHTS.name,
    path="/v1/flights",
    tag="flights",
    requests=FLIGHTS_READER,
    examples=FLIGHTS_EXAMPLES,
    listing=lambda _: Listing(),
    singular="set of flights",
    plural="flights",
    response=FlightsResponse,
    list_response=list_class("FlightsList", "flights", "Flights of a plan"),
    about_list="Flights of all plans are listed, the latest first.",
)
router = APIRouter(tags=[RESOURCE.tag], prefix=RESOURCE.path)
of_plan = APIRouter(tags=[RESOURCE.tag], prefix=f"{PLANS.path}/{{id}}/flights")


async def _find_flights(request: Request, job_id: str) -> tuple[Job, bytes]:
    def reading(connection: Connection) -> tuple[Job, bytes | None, Sequence[bytes]]:
        job = RESOURCE.job_of(connection, job_id)
        document = results.document(connection, job_id)
        return job, document, results.documents_of_parts(connection, job_id)

    job, document, parts = await read(request, reading)

    def answer() -> bytes:
        return flights_json(job, document, [unpacked_outcomes(part) for part in parts])

    return job, await anyio.to_thread.run_sync(answer)


RESOURCE.add_list(router)
RESOURCE.add_one(
    router,
    _find_flights,
    summary="Get flights",
    about="The answer covers the runs flown so far; it doesn't change once all are flown.",
)
RESOURCE.add_delete(router)
RESOURCE.add_events(router)


@of_plan.post(
    "",
    summary="Fly a plan many times",
    status_code=HTTPStatus.CREATED,
    response_model=FlightsResponse,
    responses={
        201: {"description": "All runs are flown"},
        202: {
            "model": FlightsResponse,
            "description": "Accepted; GET Location covers the runs flown so far",
        },
        409: {"description": "The plan has no table, or none yet; or the flights were cancelled"},
    },
    openapi_extra=json_body_of(RESOURCE.requests, RESOURCE.examples),
    dependencies=ONLY_JSON,
)
async def post_flights(
    request: Request,
    plan_id: PathId,
    body: Annotated[bytes, Depends(json_body)],
    key: IdempotencyKey,
    prefer: Prefer = None,
) -> Response:
    """Simulates the table with errors drawn at random for each run, and reports how often the
    camera holds the target, how sharply, and which error contributes most.

    The errors of orbit, attitude, clock, Earth orientation and drives have the sigmas of the
    plan's pointing budget; the runs are shared among all processors.
    """
    job = await database_of(request).answer(_accept, request, plan_id, body, key)
    return await RESOURCE.answer_to_post(request, job, prefer, WAIT_S, _find_flights)


@of_plan.get(
    "",
    summary="List flights of a plan",
    response_model=RESOURCE.list_response,
    dependencies=ONLY_JSON,
)
async def get_flights_of_plan(
    request: Request, plan_id: PathId, query: Annotated[ListQuery, Query()]
) -> Response:
    """The latest come first."""
    await PLANS.find_job(request, plan_id)
    return await RESOURCE.answer_list(request, query, plan_id)


def _accept(request: Request, plan_id: str, body: bytes, key: str | None) -> Job:
    """The job, new or known by its key; raises 404, Conflict, KeyReused, QueueFull."""
    spec = RESOURCE.requests.read(body)
    with database_of(request).reading() as connection:
        job = PLANS.job_of(connection, plan_id)
        _, plan, asked = plans.find(connection, plan_id, {job.kind})
    if plan is None or plan.state != "done":
        raise Conflict(
            f"there is no verified table to fly: the plan's state is {job.state}; GET "
            f"{PLANS.path}/{plan_id} tells more"
        )
    what = PlanToFly(plan_id=plan_id, asked=body, request=asked, table_columns=plan.table_columns)
    return RESOURCE.accept(
        request,
        spec,
        what.to_bytes(),
        key,
        plan_id=plan_id,
        listing=_listing(job),
        options={"runs": spec.runs, "seed": spec.seed, NEEDS_ALL: "runs"},
    )


def _listing(plan: Job) -> Listing:
    """What lists tell of its flights, too."""
    return Listing(
        platform=plan.platform or "",
        start_utc=plan.start_utc,
        stop_utc=plan.stop_utc,
        targets=tuple(plan.targets or ()),
    )
