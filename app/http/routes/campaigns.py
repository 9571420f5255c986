"""Routes of campaigns."""

from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Header, Query, Request, Response
from pydantic import Field
from sqlalchemy import Connection

from app.answers.campaign import (
    CampaignDryRun,
    CampaignList,
    CampaignResponse,
    campaign_json,
    campaign_list_json,
)
from app.answers.members import to_json
from app.http.blocking import read
from app.http.negotiation import JSON, accepts_json, json_body
from app.http.openapi.schema import request_body
from app.http.problems import problem_answer
from app.http.query import Parameters
from app.http.routes.jobs import (
    PREFER,
    accept_job,
    add_delete,
    add_events,
    add_request,
    job_of,
    list_jobs,
    no_such,
)
from app.http.routes.plan_queries import ListQuery, PathId, idempotency_key
from app.http.routes.resources import JobResource
from app.http.waiting import patience, wait_for_end
from app.jobs.kinds import CAMPAIGN
from app.requests.campaign import read_campaign_request
from app.requests.examples import CAMPAIGN_EXAMPLES
from app.requests.listings import listing_of_search
from app.store import jobs, plans
from app.store.database import Database
from app.store.jobs import Job

RESOURCE = JobResource(
    kind=CAMPAIGN.name,
    path="/v1/campaigns",
    request_schema="CampaignRequest",
    listing=listing_of_search,
    singular="campaign",
)
router = APIRouter(tags=["campaigns"], prefix=RESOURCE.path)


class CampaignPost(Parameters):
    """Parameters of the POST."""

    dry_run: bool = Field(
        default=False,
        description="Only check that the request is well formed: fields, ranges, platform, orbit "
        "and names of places and stars. Nothing is searched for, chosen or planned: a campaign "
        "that has nothing to see, or days that the orbit doesn't reach, passes, too.",
    )


@router.post(
    "",
    summary="Choose and plan sessions of many targets over days",
    status_code=HTTPStatus.ACCEPTED,
    response_model=CampaignResponse,
    responses={
        200: {
            "model": CampaignDryRun,
            "description": "`dry_run`: the request is well formed; nothing more was checked",
        },
        201: {"model": CampaignResponse, "description": "All passes are planned"},
        202: {
            "description": "Accepted; GET Location states its progress, and each pass's plan",
            "headers": {"Location": {"schema": {"type": "string"}}},
        },
    },
    openapi_extra=request_body(RESOURCE.request_schema, CAMPAIGN_EXAMPLES),
    dependencies=[Depends(accepts_json)],
)
async def post_campaign(
    request: Request,
    body: Annotated[bytes, Depends(json_body)],
    query: Annotated[CampaignPost, Query()],
    key: Annotated[str | None, Depends(idempotency_key)],
    prefer: Annotated[str | None, Header(description=PREFER)] = None,
) -> Response:
    """Searches for windows of all targets, chooses the looks that are worth most together, and
    plans and verifies each pass.

    The answer is 202 at once unless `Prefer: wait` asks to wait.
    """
    spec = await anyio.to_thread.run_sync(read_campaign_request, body)
    if query.dry_run:
        valid = CampaignDryRun(valid=True, name=spec.name, targets=len(spec.targets))
        return Response(to_json(valid), media_type=JSON)
    database: Database = request.app.state.database
    job = await database.answer(accept_job, request, RESOURCE, spec, body, key, {})
    waits = patience(prefer, 0)
    await wait_for_end(request, job.id, waits.wait_s)
    job, answer = await _find_campaign(request, job.id)
    headers = {"Location": f"{RESOURCE.path}/{job.id}", "Vary": "Prefer", **waits.headers}
    if job.problem is not None and not waits.is_none:
        return problem_answer(request, job.problem, headers)
    is_made = job.state == "done" and not waits.is_none  # else 202, though it may be done by now
    status = HTTPStatus.CREATED if is_made else HTTPStatus.ACCEPTED
    return Response(answer, status, headers, JSON)


@router.get(
    "",
    summary="List campaigns",
    response_model=CampaignList,
    dependencies=[Depends(accepts_json)],
)
async def get_campaigns(request: Request, query: Annotated[ListQuery, Query()]) -> Response:
    """The latest come first."""
    jobs_and_one = await list_jobs(request, RESOURCE, query)
    return Response(campaign_list_json(jobs_and_one, query.limit), media_type=JSON)


@router.get(
    "/{id}",
    summary="Get a campaign",
    response_model=CampaignResponse,
    responses={404: no_such(RESOURCE)},
    dependencies=[Depends(accepts_json)],
)
async def get_campaign(request: Request, campaign_id: PathId) -> Response:
    """The choice states how far it is from the best possible; each pass has its plan's state."""
    _, answer = await _find_campaign(request, campaign_id)
    return Response(answer, media_type=JSON, headers={"Cache-Control": "no-cache"})


add_request(router, RESOURCE)
add_delete(router, RESOURCE)
add_events(router, RESOURCE)


async def _find_campaign(request: Request, job_id: str) -> tuple[Job, bytes]:
    """The job, and the answer that tells of it; raises 404."""

    def reading(connection: Connection) -> tuple[Job, bytes]:
        job = job_of(connection, RESOURCE, job_id)
        choice = plans.choice_of(connection, job_id)
        return job, campaign_json(job, choice, jobs.parts_of(connection, job_id))

    return await read(request, reading)
