"""How is a plan asked for over HTTP?"""

import hashlib
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, field_validator

from app.api.examples import PLAN_EXAMPLES
from app.api.horizon_checks import horizon_checks
from app.api.negotiation import JSON, json_body, preferred
from app.api.plan_request import read_whole_plan_request
from app.api.plan_response import DryRunResponse, PlanResponse, plan_json
from app.api.provenance import provenance
from app.api.table_export import exported, file_name
from app.openapi import request_body
from planner.export import EXPORTERS
from planner.pipeline import make_plan
from planner.scenario import Scenario

router = APIRouter(tags=["plans"])

_DRY_RUN = TypeAdapter(DryRunResponse)
_FORMAT_BY_MEDIA_TYPE = {
    exporter.media_type: name
    for name, exporter in EXPORTERS.items()
    if exporter.media_type != JSON  # which is the whole answer
}


class PlanQuery(BaseModel):
    """Parameters of POST /v1/plans; a misspelled one is refused, not ignored."""

    model_config = ConfigDict(extra="forbid")

    dry_run: bool = Field(default=False, description="Only see whether the request is sound.")
    format: str | None = Field(
        default=None,
        description="The table by itself in this format, whatever the Accept header says: "
        + "; ".join(f"`{name}` {exporter.title}" for name, exporter in EXPORTERS.items()),
        json_schema_extra={"enum": list(EXPORTERS)},
    )

    @field_validator("format")
    @classmethod
    def _registered(cls, name: str) -> str:
        if name not in EXPORTERS:
            raise ValueError(f"must be one of {', '.join(EXPORTERS)}")
        return name


@router.post(
    "/v1/plans",
    summary="Plan sessions: a verified command table",
    status_code=HTTPStatus.CREATED,
    response_model=PlanResponse,
    responses={
        200: {"model": DryRunResponse, "description": "`dry_run`: the request is sound"},
        201: {
            "description": "The plan; or its table by itself, as `format` or Accept asks",
            "content": {media_type: {} for media_type in _FORMAT_BY_MEDIA_TYPE},
        },
    },
    openapi_extra=request_body("PlanRequest", PLAN_EXAMPLES),
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
    asked = query.format or _FORMAT_BY_MEDIA_TYPE.get(
        preferred(request, (JSON, *_FORMAT_BY_MEDIA_TYPE))
    )
    whole = await anyio.to_thread.run_sync(read_whole_plan_request, body)
    scenario = whole.scenario()
    if query.dry_run:
        return Response(_dry_run(scenario, digest, now_utc), HTTPStatus.OK, media_type=JSON)

    def answer() -> Response:
        plan = make_plan(scenario)
        if asked is None:
            answer = plan_json(
                plan,
                input_sha256=digest,
                planned_at_utc=now_utc,
                horizon_checks=horizon_checks(plan.scenario, whole.horizon_cameras),
            )
            return Response(answer, HTTPStatus.CREATED, _VARY, JSON)
        return Response(
            exported(plan, asked, now_utc),
            HTTPStatus.CREATED,
            _VARY | {"Content-Disposition": f'attachment; filename="{file_name(plan, asked)}"'},
            EXPORTERS[asked].media_type,
        )

    return await anyio.to_thread.run_sync(answer, limiter=request.app.state.solves)


_VARY = {"Vary": "Accept"}


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
