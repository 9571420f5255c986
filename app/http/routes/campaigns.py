"""Routes of campaigns."""

import json
from functools import partial
from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from sqlalchemy import Connection

from app.answers.job import list_class
from app.answers.members import to_json
from app.http.blocking import EXPORT_BOUNDS, database_of, in_child, read
from app.http.negotiation import JSON, ONLY_JSON, json_body
from app.http.openapi.schema import json_body_of
from app.http.routes.job_routes import JobResource
from app.http.routes.parameters import IdempotencyKey, Parameters, PlanId, Prefer, QueryTime
from app.ids import is_id
from app.jobs.job_completion import OF_CAMPAIGN
from app.jobs.kinds import CAMPAIGN, ORDER
from app.jobs.refusals import Conflict
from app.requests.campaign import CAMPAIGN_READER
from app.requests.examples import CAMPAIGN_EXAMPLES
from app.store import jobs, plans, results
from app.store.job import Job
from app.store.packed import unzip
from app.work.campaign import (
    SUFFIXES,
    CampaignDryRun,
    CampaignResponse,
    MadePass,
    campaign_file,
    campaign_json,
    plans_that_stay,
    require_both,
    revised,
)
from app.work.searches import listing_of_search

RESOURCE = JobResource(
    kind=CAMPAIGN.name,
    also=frozenset({ORDER.name}),
    path="/v1/campaigns",
    tag="campaigns",
    requests=CAMPAIGN_READER,
    examples=CAMPAIGN_EXAMPLES,
    listing=listing_of_search,
    singular="campaign",
    plural="campaigns",
    response=CampaignResponse,
    list_response=list_class("CampaignList", "campaigns", "Campaigns"),
)
router = APIRouter(tags=[RESOURCE.tag], prefix=RESOURCE.path)


class CampaignPost(Parameters):
    """Parameters of the POST.

    dry_run: only check that the request is well formed: fields, ranges, platform, orbit and names
    of places and stars. Nothing is searched for, chosen or planned: a campaign that has nothing to
    see, or days that the orbit doesn't reach, passes, too.
    revises: the campaign that this one revises, which stays as it is: `revises` of the request is
    written with its looks.
    frozen_until: with `revises`: passes that begin before it stay as they were chosen.
    """

    dry_run: bool = False
    revises: PlanId | None = None
    frozen_until: QueryTime | None = None


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
        202: {"description": "Accepted; GET Location states its progress, and each pass's plan"},
        409: {
            "description": "The campaign was cancelled while it was waited for, or `revises` "
            "names none made"
        },
    },
    openapi_extra=json_body_of(RESOURCE.requests, RESOURCE.examples),
    dependencies=ONLY_JSON,
)
async def post_campaign(
    request: Request,
    body: Annotated[bytes, Depends(json_body)],
    query: Annotated[CampaignPost, Query()],
    key: IdempotencyKey,
    prefer: Prefer = None,
) -> Response:
    """Searches for windows of all targets, chooses the looks that are worth most together, and
    plans and verifies each pass.

    The answer is 202 at once unless `Prefer: wait` asks to wait.
    """
    require_both(query.revises, query.frozen_until)
    if query.revises is not None:  # written with the looks of the campaign that it revises
        database = database_of(request)
        await database.answer(RESOURCE.require_made, database, query.revises)
        _, campaign = await _find_campaign(request, query.revises)
        told = json.loads(campaign)
        body = await anyio.to_thread.run_sync(revised, body, query.frozen_until, told)
    spec = await anyio.to_thread.run_sync(RESOURCE.requests.read, body)
    if query.dry_run:
        valid = CampaignDryRun(valid=True, name=spec.name, targets=len(spec.targets))
        return Response(to_json(valid), media_type=JSON)
    accept = partial(RESOURCE.accept, request, spec, body, key, revises=query.revises)
    job = await database_of(request).answer(accept)
    return await RESOURCE.answer_to_post(request, job, prefer, 0, _find_campaign)


async def _find_campaign(request: Request, job_id: str) -> tuple[Job, bytes]:
    def reading(connection: Connection) -> tuple[Job, bytes]:
        job = RESOURCE.job_of(connection, job_id)
        document = results.document(connection, job_id)
        return job, campaign_json(job, document, jobs.parts_of(connection, job_id))

    return await read(request, reading)


async def _write_file(request: Request, job: Job, media_type: str) -> bytes:
    def reading(connection: Connection) -> tuple[bytes, list[MadePass]]:
        document = results.document(connection, job.id)
        stay = plans_that_stay(json.loads(unzip(document))) if document else []
        parts = [jobs.get(connection, plan_id) for plan_id in stay if is_id(plan_id)]
        parts += jobs.parts_of(connection, job.id)
        made = [plans.get(connection, one) for one in parts if one and OF_CAMPAIGN in one.options]
        passes = [
            MadePass(
                facts=plan.options[OF_CAMPAIGN],
                plan=plan.id,
                request=jobs.request_of(connection, plan.id) or b"",
                table_columns=plan.table_columns,
                planned_utc=plan.planned_utc,
            )
            for plan in made
            if plan is not None and plan.state == "done"
        ]
        return jobs.request_of(connection, job.id) or b"", passes

    body, passes = await read(request, reading)
    if job.is_open or not passes:
        raise Conflict(
            f"there is no file of looks: the campaign's state is {job.state}, with {len(passes)} "
            f"plans made; GET {RESOURCE.path}/{job.id} as {JSON} tells more"
        )
    passes.sort(key=lambda one: one.number)
    return await in_child(request, EXPORT_BOUNDS, campaign_file, media_type, body, passes)


RESOURCE.add_list(router)
RESOURCE.add_one(
    router,
    _find_campaign,
    summary="Get a campaign",
    about="The choice states how far it is from the best possible; each pass has its plan's state. "
    "Once it has ended, Accept may ask for the looks of plans made as CSV, GeoJSON or KML, or for "
    "a zip archive of each pass's command table and request.",
    suffixes=SUFFIXES,
    write_file=_write_file,
)
RESOURCE.add_request(router)
RESOURCE.add_delete(router)
RESOURCE.add_events(router)
