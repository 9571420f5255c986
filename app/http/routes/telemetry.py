"""The route of comparisons of telemetry with a plan."""

from datetime import UTC, datetime
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Query, Request, Response
from sqlalchemy import Connection

from app.answers.members import provenance
from app.answers.telemetry import ComparisonResponse
from app.http.blocking import in_child, read
from app.http.horizon_upload import MULTIPART
from app.http.negotiation import JSON, preferred_type
from app.http.openapi.schema import REF
from app.http.routes.plan_queries import TableQuery, with_formats
from app.http.telemetry_upload import sent_telemetry, telemetry_body
from app.jobs.child import Bounds
from app.jobs.kinds import PLAN, SPACECRAFT_PLAN
from app.jobs.refusals import Conflict
from app.requests.examples import COMPARISON_EXAMPLES
from app.store import jobs, plans
from app.store.ids import is_id
from app.store.plans import StoredPlan
from app.work.telemetry import PICTURES, compare_stored
from planner.base.errors import InvalidInput

router = APIRouter(tags=["telemetry"])

# Drives' parameters of a plan of 600 s take a hundred flights of 0.3 s.
_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)
_JSON_FORMAT = "json"
_MEDIA_TYPES = {_JSON_FORMAT: JSON} | {name: one.media_type for name, one in PICTURES.items()}

_QUERY = with_formats(
    TableQuery,
    "The comparison in this format",
    {_JSON_FORMAT: "numbers"} | {name: one.title for name, one in PICTURES.items()},
)
_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            JSON: {
                "schema": {"$ref": REF.format(model="ComparisonRequest")},
                "examples": {
                    name: {"summary": summary, "value": value}
                    for name, (summary, value) in COMPARISON_EXAMPLES.items()
                },
            },
            MULTIPART: {
                "schema": {
                    "type": "object",
                    "required": ["request", "samples"],
                    "properties": {
                        "request": {"$ref": REF.format(model="ComparisonRequest")},
                        "samples": {
                            "type": "string",
                            "format": "binary",
                            "description": "CSV: a line that names the columns (t_s or utc, then "
                            "NAME_deg and NAME_rate_deg_s of the axes), a line per sample.",
                        },
                    },
                },
                "encoding": {"request": {"contentType": JSON}},
            },
        },
    }
}


async def post_comparison(
    request: Request,
    sent: Annotated[tuple[str, bytes], Depends(telemetry_body)],
    query: Annotated[TableQuery, Query()],
) -> Response:
    """Estimates the telemetry's clock, then reports each axis's errors session by session, and the
    times at which it oscillated, stuck or exceeded a limit.

    Damaged rows are left out and counted; a file that has no sample of the plan is refused.
    Nothing is kept.
    """
    form = query.format or _asked_form(request)
    media_type, body = sent
    now_utc = datetime.now(UTC)
    telemetry = await sent_telemetry(request, media_type, body)
    plan_request, plan = await _plan_of(request, telemetry.request.plan)
    origin = await anyio.to_thread.run_sync(provenance, now_utc, body)
    answer = await in_child(
        request,
        _BOUNDS,
        compare_stored,
        plan_request,
        plan.table_columns,
        telemetry,
        origin,
        None if form == _JSON_FORMAT else form,
        now_utc,
    )
    return Response(answer, media_type=_MEDIA_TYPES[form])


post_comparison.__annotations__["query"] = Annotated[_QUERY, Query()]
router.post(
    "/v1/telemetry/comparisons",
    summary="Compare telemetry with a plan",
    response_model=ComparisonResponse,
    responses={
        200: {
            "description": "The comparison; or a picture, as `format` or Accept asks",
            "content": {media: {} for media in _MEDIA_TYPES.values() if media != JSON},
        },
        409: {"description": "There is no such plan yet: it is queued, running or was not made"},
    },
    openapi_extra=_BODY,
)(post_comparison)


def _asked_form(request: Request) -> str:
    wanted = preferred_type(request, tuple(_MEDIA_TYPES.values()))
    return next(name for name, media in _MEDIA_TYPES.items() if media == wanted)


async def _plan_of(request: Request, plan_id: str) -> tuple[bytes, StoredPlan]:
    def reading(connection: Connection) -> tuple[str | None, bytes | None, StoredPlan | None]:
        job = jobs.get(connection, plan_id) if is_id(plan_id) else None
        if job is not None and job.kind == SPACECRAFT_PLAN.name:
            raise InvalidInput(
                "telemetry is compared with plans of the platform; a spacecraft's plan tells what "
                "its own closed-loop runs did, in `flight`",
                field="plan",
            )
        if job is None or job.kind != PLAN.name:
            return None, None, None
        return job.state, jobs.request_of(connection, plan_id), plans.get(connection, job)

    state, plan_request, plan = await read(request, reading)
    if state is None:
        raise InvalidInput(
            f"there is no plan {plan_id[:80]!r}; GET /v1/plans lists them", field="plan"
        )
    if plan is None or plan_request is None:
        raise Conflict(
            f"there is no table to compare with: the plan's state is {state}", field="plan"
        )
    return plan_request, plan
