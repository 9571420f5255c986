"""Routes of the places and stars that a request can name, found by the beginning of a name."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Depends, Query
from pydantic import Field

from app.answers.ranges import Count, LatitudeDeg, LongitudeDeg, Signed
from app.http.negotiation import accepts_json
from app.http.query import Parameters
from planner.world.targets.autocomplete import places_beginning, stars_beginning

router = APIRouter(tags=["platforms"], dependencies=[Depends(accepts_json)])


class NamesQuery(Parameters):
    """Which names to list."""

    begin: str = Field(
        min_length=1,
        max_length=100,
        description="The beginning of the name, in any script and case; of a place, after a comma, "
        "the beginning of region or country.",
        examples=["lond"],
    )
    limit: int = Field(default=8, ge=1, le=50, description="The largest number of names.")


@dataclass(frozen=True, kw_only=True)
class KnownPlace:
    """A town of 15,000 people or more.

    name: the shortest that means it alone, for `name` of a target of mode `place`. E.g.
    `"London, GB"`.
    words: its name with region and country. E.g. `"London, England, GB"`.
    latitude_deg: geodetic, WGS84; north positive.
    longitude_deg: WGS84; east positive.
    height_m: above the WGS84 ellipsoid.
    """

    name: str
    words: str
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: Signed


@dataclass(frozen=True, kw_only=True)
class KnownPlaces:
    """Those of just the letters given first, then those whose own name they begin.

    places: of each kind the most populous first.
    """

    places: list[KnownPlace]


@dataclass(frozen=True, kw_only=True)
class KnownStar:
    """A star with a proper name.

    name: for `name` of a target of mode `star`. E.g. `"Vega"`.
    hip: Hipparcos number. E.g. `91262`.
    """

    name: str
    hip: Count


@dataclass(frozen=True, kw_only=True)
class KnownStars:
    """Stars whose names begin so.

    stars: in order of the alphabet.
    """

    stars: list[KnownStar]


@router.get("/v1/places", summary="List places by the beginning of their names")
def get_places(query: Annotated[NamesQuery, Query()]) -> KnownPlaces:
    """Completes what somebody types; where several places share a name, all are listed."""
    return KnownPlaces(
        places=[
            KnownPlace(
                name=name,
                words=place.in_words,
                latitude_deg=place.latitude_deg,
                longitude_deg=place.longitude_deg,
                height_m=place.height_m,
            )
            for name, place in places_beginning(query.begin, query.limit)
        ]
    )


@router.get("/v1/stars", summary="List stars by the beginning of their names")
def get_stars(query: Annotated[NamesQuery, Query()]) -> KnownStars:
    """Completes what somebody types."""
    found = stars_beginning(query.begin, query.limit)
    return KnownStars(stars=[KnownStar(name=name, hip=hip) for name, hip in found])
