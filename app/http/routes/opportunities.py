"""Opportunities over HTTP."""

from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response

from app.answers.opportunities import OpportunitiesResponse
from app.http.blocking import answer_in_child
from app.http.negotiation import accepts_json, json_body
from app.http.openapi.schema import request_body
from app.jobs.child import Bounds
from app.requests.examples.opportunities import OPPORTUNITY_EXAMPLES
from app.requests.opportunities import read_opportunity_request
from app.work.campaign import answer_opportunities

SEARCH_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)

router = APIRouter(tags=["opportunities"], dependencies=[Depends(accepts_json)])


@router.post(
    "/v1/opportunities",
    summary="When can each target be seen?",
    response_model=OpportunitiesResponse,
    openapi_extra=request_body("OpportunityRequest", OPPORTUNITY_EXAMPLES),
)
async def post_opportunities(
    request: Request, body: Annotated[bytes, Depends(json_body)]
) -> Response:
    """Windows to the millisecond, with what opens and closes each, and the view through it."""
    return await answer_in_child(
        request, body, read_opportunity_request, SEARCH_BOUNDS, answer_opportunities
    )
