"""Routes of the service itself: health, readiness, version, metrics, the audit log."""

from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query, Request, Response
from pydantic import Field

from app.answers.service import AuditLog, Health, ReadinessResponse
from app.http.blocking import read
from app.http.metrics import CONTENT_TYPE
from app.http.negotiation import ONLY_JSON
from app.http.routes.parameters import Parameters
from app.store.audit import entries
from app.versions import VERSION

router = APIRouter(tags=["system"])

_AUDIT_ID_MAX = 2**31 - 1  # of the database's column
_NOT_READY: dict[int | str, dict[str, Any]] = {
    503: {"description": "Something the service needs doesn't answer; `detail` says what"}
}


@router.get("/healthz", summary="Check that the process answers")
async def get_health() -> Health:
    """Says nothing of what the service depends on; Accept is disregarded."""
    return Health(status="ok", version=VERSION)


@router.get("/readyz", summary="Check that the service can work", responses=_NOT_READY)
async def get_readiness(request: Request) -> ReadinessResponse:
    """The checks cover database, solver (a child process solves a problem) and Earth orientation.

    They run every 5 s, however often this is asked; the answer is the same whatever Accept asks
    for.
    """
    checks = await request.app.state.readiness.now()
    failed = [check for check in checks if check.state == "failed"]
    if failed:
        raise HTTPException(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "; ".join(f"{check.name}: {check.detail}" for check in failed),
        )
    degraded = any(check.state == "degraded" for check in checks)
    return ReadinessResponse(status="degraded" if degraded else "ready", checks=list(checks))


@router.get(
    "/metrics",
    summary="Get metrics",
    response_class=Response,
    responses={200: {"description": "Prometheus's text format", "content": {"text/plain": {}}}},
)
async def get_metrics(request: Request) -> Response:
    """The metrics cover requests by route, refusals by type, solve times, iterations and jobs by
    state since the start; the answer is the same whatever Accept asks for.
    """
    text = await request.app.state.database.answer(request.app.state.metrics.text)
    return Response(text, headers={"Content-Type": CONTENT_TYPE})


class AuditQuery(Parameters):
    """Parameters of GET /v1/audit.

    limit: most entries.
    before: only entries older than the one of this id.
    """

    limit: int = Field(default=100, ge=1, le=1000)
    before: int = Field(default=_AUDIT_ID_MAX, ge=1, le=_AUDIT_ID_MAX)


@router.get("/v1/audit", summary="List the audit log", dependencies=ONLY_JSON)
async def get_audit(request: Request, query: Annotated[AuditQuery, Query()]) -> AuditLog:
    """Lists keys made and revoked, plans made, cancelled and deleted; needs an admin key."""
    found = await read(request, lambda connection: entries(connection, query.limit, query.before))
    return AuditLog(entries=found)
