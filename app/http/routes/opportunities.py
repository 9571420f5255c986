"""Opportunities of the two-axis platform over HTTP."""

from app.answers.opportunities import OpportunitiesResponse, WindowsPage
from app.http.routes.searches import SearchResource, search_routes
from app.jobs.child import Bounds
from app.requests.examples import OPPORTUNITY_EXAMPLES
from app.requests.listings import listing_of_search
from app.requests.opportunities import read_opportunity_request
from app.work.campaign import answer_opportunities

OPPORTUNITIES = SearchResource(
    kind="opportunities",
    path="/v1/opportunities",
    request_schema="OpportunityRequest",
    listing=listing_of_search,
    singular="search for opportunities",
    tag="opportunities",
    summary="Search for windows of targets",
    examples=OPPORTUNITY_EXAMPLES,
    read=read_opportunity_request,
    find=answer_opportunities,
    bounds=Bounds(deadline_s=120.0, memory_mib=2000),
    response=OpportunitiesResponse,
    page=WindowsPage,
)

router = search_routes(OPPORTUNITIES)
