"""How is a session of the imaging spacecraft asked for over HTTP?"""

import hashlib
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field, field_validator

from app.api.negotiation import JSON, json_body, preferred
from app.api.provenance import provenance
from app.api.spacecraft_examples import SPACECRAFT_EXAMPLES
from app.api.spacecraft_request import read_spacecraft_request
from app.api.spacecraft_response import SpacecraftPlanResponse
from app.api.spacecraft_work import session_file, session_json
from app.jobs.disposable import Bounds, run_disposable
from app.openapi import request_body
from planner.spacecraft.export import IMAGING_EXPORTERS

router = APIRouter(tags=["spacecraft"])

# The most that can be asked, an hour with 200 requests and 100 closed-loop runs, took 212 s
# and 2.6 GB on two cores that had four other things to do.
SESSION_BOUNDS = Bounds(deadline_s=300.0, memory_mib=3000)

_FORMAT_BY_MEDIA_TYPE = {exporter.media_type: name for name, exporter in IMAGING_EXPORTERS.items()}
_VARY = {"Vary": "Accept"}


class SpacecraftQuery(BaseModel):
    """Parameters of POST /v1/spacecraft/plans; a misspelled one is refused, not ignored."""

    model_config = ConfigDict(extra="forbid")

    format: str | None = Field(
        default=None,
        description="The table by itself in this format, whatever the Accept header says: "
        + "; ".join(f"`{name}` {exporter.title}" for name, exporter in IMAGING_EXPORTERS.items()),
        json_schema_extra={"enum": list(IMAGING_EXPORTERS)},
    )

    @field_validator("format")
    @classmethod
    def _registered(cls, name: str) -> str:
        if name not in IMAGING_EXPORTERS:
            raise ValueError(f"must be one of {', '.join(IMAGING_EXPORTERS)}")
        return name


@router.post(
    "/v1/spacecraft/plans",
    summary="Plan an imaging session of the CMG spacecraft: attitude and gimbal table",
    status_code=HTTPStatus.CREATED,
    response_model=SpacecraftPlanResponse,
    responses={
        201: {
            "description": "The session; or its table by itself, as `format` or Accept asks",
            "content": {media_type: {} for media_type in _FORMAT_BY_MEDIA_TYPE},
        },
    },
    openapi_extra=request_body("ImagingPlanRequest", SPACECRAFT_EXAMPLES),
)
async def post_spacecraft_plan(
    request: Request,
    body: Annotated[bytes, Depends(json_body)],
    query: Annotated[SpacecraftQuery, Query()],
) -> Response:
    """Chooses and orders what fits, turns between scans, and flies the table closed loop.

    Every table is checked by a judge of its own before it is returned.  Requests that don't
    fit are listed in `left_out` with the reason; when none fits, the session is refused with
    the nearest way out.
    """
    now_utc = datetime.now(UTC)
    asked = query.format or _FORMAT_BY_MEDIA_TYPE.get(
        preferred(request, (JSON, *_FORMAT_BY_MEDIA_TYPE))
    )
    session = await anyio.to_thread.run_sync(read_spacecraft_request, body)
    if asked is None:
        made = provenance(hashlib.sha256(body).hexdigest(), now_utc)
        answer = await anyio.to_thread.run_sync(
            lambda: run_disposable(SESSION_BOUNDS, session_json, session, made),
            limiter=request.app.state.children,
        )
        return Response(answer, HTTPStatus.CREATED, _VARY, JSON)
    exporter = IMAGING_EXPORTERS[asked]
    answer = await anyio.to_thread.run_sync(
        lambda: run_disposable(SESSION_BOUNDS, session_file, session, asked, now_utc),
        limiter=request.app.state.children,
    )
    headers = _VARY | {"Content-Disposition": f'attachment; filename="session{exporter.suffix}"'}
    return Response(answer, HTTPStatus.CREATED, headers, exporter.media_type)
