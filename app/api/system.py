"""Is the service alive, and which version is it?"""

from dataclasses import dataclass
from typing import Literal

from fastapi import APIRouter, Depends

from app.api.negotiation import accepts_json
from app.versions import VERSION

router = APIRouter(tags=["system"], dependencies=[Depends(accepts_json)])


@dataclass(frozen=True, kw_only=True)
class Health:
    """The process answers."""

    status: Literal["ok"]
    version: str


@router.get("/healthz", summary="Is the service alive?")
async def get_health() -> Health:
    """Answers as long as the process does; says nothing of what it depends on."""
    return Health(status="ok", version=VERSION)
