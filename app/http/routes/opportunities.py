"""Opportunities over HTTP: windows of targets, and ground tracks."""

from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response

from app.http.blocking import answer_in_child
from app.http.negotiation import ONLY_JSON, json_body
from app.http.openapi.schema import json_body_of
from app.http.routes.search_routes import SEARCH_BOUNDS, SearchResource
from app.requests.examples import OPPORTUNITY_EXAMPLES, ORBIT_TRACK_EXAMPLES
from app.work.searches import INCLUDED, OPPORTUNITY_READER, OpportunitiesResponse, listing_of_search
from app.work.view import ORBIT_TRACK_READER, OrbitTrackResponse, orbit_track_json

OPPORTUNITIES = SearchResource(
    kind="opportunities",
    path="/v1/opportunities",
    requests=OPPORTUNITY_READER,
    listing=listing_of_search,
    tag="opportunities",
    summary="Search for windows of targets",
    examples=OPPORTUNITY_EXAMPLES,
    response=OpportunitiesResponse,
    included=INCLUDED,
)

router = OPPORTUNITIES.routes()
of_orbits = APIRouter(tags=["opportunities"], dependencies=ONLY_JSON)


@of_orbits.post(
    "/v1/orbits/tracks",
    summary="Predict the ground track and the eclipses of an orbit",
    response_model=OrbitTrackResponse,
    openapi_extra=json_body_of(ORBIT_TRACK_READER, ORBIT_TRACK_EXAMPLES),
)
async def post_orbit_track(
    request: Request, body: Annotated[bytes, Depends(json_body)]
) -> Response:
    """Tells over days where the carrier is, how much of the Sun it sees, and when it sees none.

    Nothing is kept.
    """
    return await answer_in_child(
        request, body, ORBIT_TRACK_READER.read, SEARCH_BOUNDS, orbit_track_json
    )
