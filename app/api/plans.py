"""How is a plan asked for over HTTP?"""

import hashlib
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from pydantic import BaseModel, ConfigDict, TypeAdapter

from app.api.examples import PLAN_EXAMPLES
from app.api.negotiation import JSON, accepts_json, json_body
from app.api.plan_request import read_plan_request
from app.api.plan_response import DryRunResponse, PlanResponse, plan_json, provenance
from planner.pipeline import make_plan
from planner.scenario import Scenario

router = APIRouter(tags=["plans"], dependencies=[Depends(accepts_json)])

_DRY_RUN = TypeAdapter(DryRunResponse)


class PlanQuery(BaseModel):
    """Parameters of POST /v1/plans; a misspelled one is refused, not ignored."""

    model_config = ConfigDict(extra="forbid")

    dry_run: bool = False


@router.post(
    "/v1/plans",
    summary="Plan sessions: a verified command table",
    status_code=HTTPStatus.CREATED,
    response_model=PlanResponse,
    responses={200: {"model": DryRunResponse, "description": "`dry_run`: the request is sound"}},
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {
                JSON: {
                    "schema": {"$ref": "#/components/schemas/PlanRequest"},
                    "examples": {
                        name: {"summary": summary, "value": value}
                        for name, (summary, value) in PLAN_EXAMPLES.items()
                    },
                }
            },
        }
    },
)
async def post_plan(
    request: Request,
    body: Annotated[bytes, Depends(json_body)],
    query: Annotated[PlanQuery, Query()],
) -> Response:
    """Slews and tracks for every session, one row of angles and rates per 0.2 s.

    The plan is checked by a verification of its own before it is returned.  What can't be
    flown is refused with the axis, the limit and the earliest start that works.
    """
    now_utc = datetime.now(UTC)
    digest = hashlib.sha256(body).hexdigest()
    scenario = await anyio.to_thread.run_sync(read_plan_request, body)
    if query.dry_run:
        return Response(_dry_run(scenario, digest, now_utc), HTTPStatus.OK, media_type=JSON)
    answer = await anyio.to_thread.run_sync(
        lambda: plan_json(make_plan(scenario), input_sha256=digest, planned_at_utc=now_utc),
        limiter=request.app.state.solves,
    )
    return Response(answer, HTTPStatus.CREATED, media_type=JSON)


def _dry_run(scenario: Scenario, digest: str, now_utc: datetime) -> bytes:
    return _DRY_RUN.dump_json(
        DryRunResponse(
            valid=True,
            name=scenario.name,
            platform=scenario.platform.name,
            sessions=len(scenario.sessions),
            provenance=provenance(digest, now_utc),
        )
    )
