"""The audit log over HTTP."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from pydantic import Field

from app.http.negotiation import accepts_json
from app.http.query import Parameters
from app.store.audit import AuditEntry, entries
from planner.frames.time_scales import utc_text

router = APIRouter(tags=["system"], dependencies=[Depends(accepts_json)])

_ID_MAX = 2**31 - 1  # of the database's column


@dataclass(frozen=True, kw_only=True)
class AuditEntryOut:
    """One deed: `key_id` did `action` to `subject`; null without a key."""

    id: int
    at: str
    key_id: str | None
    action: str
    subject: str
    detail: str


@dataclass(frozen=True, kw_only=True)
class AuditLog:
    """The latest first; for older ones ask again with `before` the last id."""

    entries: list[AuditEntryOut]


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
    return AuditLog(entries=[_out(entry) for entry in found])


def _out(entry: AuditEntry) -> AuditEntryOut:
    return AuditEntryOut(
        id=entry.id,
        at=utc_text(entry.at_utc),
        key_id=entry.key_id,
        action=entry.action,
        subject=entry.subject,
        detail=entry.detail,
    )
