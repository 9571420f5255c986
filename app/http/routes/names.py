"""Routes of what a request can name: platforms; places and stars by the beginning of a name."""

from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import Field

from app.answers.service import KnownPlaces, KnownStars, PlatformList, platform_list
from app.http.negotiation import ONLY_JSON
from app.http.routes.parameters import Parameters
from planner.world.targets.autocomplete import places_beginning, stars_beginning

router = APIRouter(tags=["platforms"], dependencies=ONLY_JSON)


class NamesQuery(Parameters):
    """Which names to list.

    begin: the beginning of the name, in any script and case; of a place, after a comma, the
    beginning of region or country.
    limit: the largest number of names.
    """

    begin: str = Field(min_length=1, max_length=100, examples=["lond"])
    limit: int = Field(default=8, ge=1, le=50)


@router.get("/v1/platforms", summary="List platforms")
async def get_platforms() -> PlatformList:
    """Two axes on a carrier, or a body; copy one into a request's `platform` to change it."""
    return platform_list()


@router.get("/v1/places", summary="List places by the beginning of their names")
def get_places(query: Annotated[NamesQuery, Query()]) -> KnownPlaces:
    """Completes what somebody types; where several places share a name, all are listed."""
    return KnownPlaces(places=places_beginning(query.begin, query.limit))


@router.get("/v1/stars", summary="List stars by the beginning of their names")
def get_stars(query: Annotated[NamesQuery, Query()]) -> KnownStars:
    """Completes what somebody types."""
    return KnownStars(stars=stars_beginning(query.begin, query.limit))
