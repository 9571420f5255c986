"""Routes of flights: listed, followed, ended."""

from collections.abc import Sequence
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from sqlalchemy import Connection

from app.answers.flights import FlightsList, FlightsResponse, flights_json, flights_list_json
from app.http.blocking import read
from app.http.negotiation import JSON, accepts_json
from app.http.routes.jobs import add_delete, add_events, job_of, list_jobs, no_such
from app.http.routes.plan_queries import ListQuery, PathId
from app.http.routes.resources import JobResource
from app.jobs.kinds import FLIGHTS
from app.requests.flights import FlightsRequest
from app.store import results
from app.store.jobs import Job
from app.store.listing import Listing
from app.work.flights import unpacked_outcomes

RESOURCE = JobResource(
    kind=FLIGHTS.name,
    path="/v1/flights",
    request_schema=FlightsRequest.__name__,
    listing=lambda _: Listing(),
    singular="flight",
)
router = APIRouter(tags=["flights"], prefix=RESOURCE.path)


@router.get(
    "",
    summary="List flights",
    response_model=FlightsList,
    dependencies=[Depends(accepts_json)],
)
async def get_flights(request: Request, query: Annotated[ListQuery, Query()]) -> Response:
    """Flights of all plans are listed, the latest first."""
    jobs_and_one = await list_jobs(request, RESOURCE, query)
    return Response(flights_list_json(jobs_and_one, query.limit), media_type=JSON)


@router.get(
    "/{id}",
    summary="Get flights",
    response_model=FlightsResponse,
    responses={404: no_such(RESOURCE)},
    dependencies=[Depends(accepts_json)],
)
async def get_flight(request: Request, flights_id: PathId) -> Response:
    """The answer covers the runs flown so far; it doesn't change once all are flown."""
    _, answer = await find_flights(request, flights_id)
    return Response(answer, media_type=JSON, headers={"Cache-Control": "no-cache"})


add_delete(router, RESOURCE)
add_events(router, RESOURCE)


async def find_flights(request: Request, job_id: str) -> tuple[Job, bytes]:
    """The job, and the answer that tells of it; raises 404."""

    def reading(connection: Connection) -> tuple[Job, bytes | None, Sequence[bytes]]:
        job = job_of(connection, RESOURCE, job_id)
        document = results.document(connection, job_id)
        return job, document, results.documents_of_parts(connection, job_id)

    job, document, parts = await read(request, reading)

    def answer() -> bytes:
        return flights_json(job, document, [unpacked_outcomes(part) for part in parts])

    return job, await anyio.to_thread.run_sync(answer)
