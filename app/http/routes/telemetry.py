"""The route of comparisons of telemetry with a plan."""

import json
from datetime import UTC, datetime
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Depends, Request, Response

from app.answers.members import provenance
from app.http.blocking import in_child, read
from app.http.negotiation import (
    JSON,
    MAX_REQUEST_BYTES,
    MULTIPART,
    FormPart,
    format_of,
    media_type_of,
    read_parts,
    unreadable,
    unsupported,
    whole_body,
)
from app.http.openapi.schema import form_body_of, json_body_of, schema_of
from app.http.routes.parameters import TableQuery, read_query, with_formats
from app.jobs.child import Bounds
from app.jobs.kinds import PLANS
from app.jobs.refusals import Conflict
from app.requests.examples import COMPARISON_EXAMPLES
from app.store import plans
from app.store.plans import StoredPlan
from app.work.telemetry import (
    COMPARISON_READER,
    FILES,
    ComparisonResponse,
    SentTelemetry,
    compare_stored,
    read_sent,
)
from planner.base.errors import InvalidInput

router = APIRouter(tags=["telemetry"])

# Drives' parameters of a plan of 600 s take a hundred flights of 0.3 s.
_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)
_JSON_FORMAT = "json"
_MEDIA_TYPES = {_JSON_FORMAT: JSON} | {name: one.media_type for name, one in FILES.items()}

_TITLES = {_JSON_FORMAT: "numbers"} | {name: one.title for name, one in FILES.items()}
_read_query = read_query(with_formats(TableQuery, "The comparison in this format", _TITLES))
_FIELDS = ("request", "plan", "epoch")  # a form may give plan and epoch without writing JSON
_PARTS = (
    *(FormPart(name, most_bytes=MAX_REQUEST_BYTES) for name in _FIELDS),
    FormPart("samples", "is needed: a CSV file"),
)
_CSV = {
    "type": "string",
    "format": "binary",
    "description": "CSV: a line that names the columns (t_s or utc, then NAME_deg and "
    "NAME_rate_deg_s of the axes, or a body's q_1 to q_4 and omega_body_deg_s_x, _y, _z), a line "
    "per sample.",
}
_BODY = json_body_of(COMPARISON_READER, COMPARISON_EXAMPLES)
_FORM = form_body_of(schema_of(COMPARISON_READER), {"samples": _CSV})
_BODY["requestBody"]["content"] |= _FORM["requestBody"]["content"]


async def _body(request: Request) -> bytes:
    """The whole body, JSON or a form; refused with 415 and 413."""
    media_type, settings = media_type_of(request), request.app.state.settings
    if media_type == JSON:
        way_out = (
            f"; send more samples as CSV by {MULTIPART}, up to {settings.max_upload_bytes} bytes"
        )
        return await whole_body(request, settings.max_body_bytes, way_out)
    if media_type == MULTIPART:
        return await whole_body(request, settings.max_upload_bytes)
    raise unsupported(
        request,
        f"{JSON} with the samples in it, or {MULTIPART} (its part `request` holds JSON, its part "
        "`samples` CSV)",
    )


async def _sent(request: Request, body: bytes) -> SentTelemetry:
    """Raises InvalidRequest."""
    if media_type_of(request) == JSON:
        return read_sent(body)
    parts = await read_parts(request, body, _PARTS)
    return read_sent(_head(parts), *parts["samples"])


def _head(parts: dict[str, list[bytes]]) -> bytes:
    fields = {name: parts[name][0] for name in _FIELDS if parts[name]}
    if "request" in fields:
        if len(fields) > 1:
            raise unreadable("plan", "goes into the part request where there is one")
        return fields["request"]
    text = {name: content.decode("utf-8", "replace") for name, content in fields.items()}
    if "plan" not in text:
        raise unreadable("request", "is needed: JSON with the id of the plan")
    head: dict[str, object] = {"plan": text["plan"]}
    if "epoch" in text:
        head["samples"] = {"epoch": text["epoch"]}
    return json.dumps(head).encode()


@router.post(
    "/v1/telemetry/comparisons",
    summary="Compare telemetry with a plan",
    response_model=ComparisonResponse,
    responses={
        200: {
            "description": "The comparison; or a file, as `format` or Accept asks",
            "content": {media: {} for media in _MEDIA_TYPES.values() if media != JSON},
        },
        409: {"description": "There is no such plan yet: it is queued, running or was not made"},
    },
    openapi_extra=_BODY,
)
async def post_comparison(
    request: Request,
    body: Annotated[bytes, Depends(_body)],
    query: Annotated[TableQuery, Depends(_read_query)],
) -> Response:
    """Estimates the telemetry's clock, then reports each axis's errors session by session, and the
    times at which it oscillated, stuck or exceeded a limit.

    Damaged rows are left out and counted; a file that has no sample of the plan is refused.
    Nothing is kept.
    """
    format_name = query.format or format_of(request, _MEDIA_TYPES)
    now_utc = datetime.now(UTC)
    telemetry = await _sent(request, body)
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
        None if format_name == _JSON_FORMAT else format_name,
        now_utc,
    )
    return Response(answer, media_type=_MEDIA_TYPES[format_name])


async def _plan_of(request: Request, plan_id: str) -> tuple[bytes, StoredPlan]:
    job, plan, plan_request = await read(
        request, lambda connection: plans.find(connection, plan_id, PLANS)
    )
    if job is None:
        raise InvalidInput(
            f"there is no plan {plan_id[:80]!r}; GET /v1/plans lists them", field="plan"
        )
    if plan is None:
        raise Conflict(
            f"there is no table to compare with: the plan's state is {job.state}", field="plan"
        )
    return plan_request, plan
