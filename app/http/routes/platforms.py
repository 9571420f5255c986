"""The platforms that can be named in a request, over HTTP."""

from dataclasses import dataclass

from fastapi import APIRouter, Depends

from app.answers.platform import definition_of
from app.http.negotiation import accepts_json
from planner.world.platforms import PLATFORMS, PlatformDefinition

router = APIRouter(tags=["platforms"], dependencies=[Depends(accepts_json)])


@dataclass(frozen=True, kw_only=True)
class PlatformList:
    """Every registered platform, written as a request may write out its own.

    platforms: all there are.
    """

    platforms: list[PlatformDefinition]


@router.get("/v1/platforms", summary="List platforms")
async def get_platforms() -> PlatformList:
    """Each has axes, limits and mount; copy one into a request's `platform` to change it."""
    return PlatformList(platforms=[definition_of(platform) for platform in PLATFORMS.values()])
