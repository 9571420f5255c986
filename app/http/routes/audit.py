"""The audit log over HTTP."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from pydantic import Field

from app.http.negotiation import accepts_json
from app.http.query import Parameters
from app.store.audit import AuditEntry, entries

router = APIRouter(tags=["system"], dependencies=[Depends(accepts_json)])

_ID_MAX = 2**31 - 1  # of the database's column


@dataclass(frozen=True, kw_only=True)
class AuditLog:
    """The latest first; for older ones ask again with `before` the last id."""

    entries: list[AuditEntry]


class AuditQuery(Parameters):
    """Parameters of GET /v1/audit."""

    limit: int = Field(default=100, ge=1, le=1000, description="Most entries.")
    before: int = Field(
        default=_ID_MAX, ge=1, le=_ID_MAX, description="Only entries older than the one of this id."
    )


@router.get("/v1/audit", summary="Who did what, and when?")
def get_audit(request: Request, query: Annotated[AuditQuery, Query()]) -> AuditLog:
    """Keys made and revoked, plans made, cancelled and deleted; needs an admin's key."""
    found = entries(request.app.state.database, limit=query.limit, before=query.before)
    return AuditLog(entries=found)
