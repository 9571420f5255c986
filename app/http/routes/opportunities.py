"""Opportunities over HTTP: of the two-axis platform, and passes of the spacecraft."""

from app.answers.imaging_opportunities import ImagingOpportunitiesResponse, ImagingWindowsPage
from app.answers.opportunities import OpportunitiesResponse, WindowsPage
from app.http.routes.search_routes import SearchResource, search_routes
from app.requests.examples import IMAGING_OPPORTUNITY_EXAMPLES, OPPORTUNITY_EXAMPLES
from app.requests.listings import listing_of_imaging, listing_of_search
from app.requests.opportunities import OPPORTUNITY_READER
from app.requests.spacecraft import IMAGING_OPPORTUNITY_READER
from app.work.campaign import answer_opportunities
from app.work.spacecraft import answer_imaging_opportunities

OPPORTUNITIES = SearchResource(
    kind="opportunities",
    path="/v1/opportunities",
    requests=OPPORTUNITY_READER,
    listing=listing_of_search,
    tag="opportunities",
    summary="Search for windows of targets",
    examples=OPPORTUNITY_EXAMPLES,
    find=answer_opportunities,
    response=OpportunitiesResponse,
    windows_response=WindowsPage,
)
IMAGING_OPPORTUNITIES = SearchResource(
    kind="imaging_opportunities",
    path="/v1/spacecraft/opportunities",
    requests=IMAGING_OPPORTUNITY_READER,
    listing=listing_of_imaging,
    tag="spacecraft",
    summary="Search for passes of the imaging spacecraft",
    examples=IMAGING_OPPORTUNITY_EXAMPLES,
    find=answer_imaging_opportunities,
    response=ImagingOpportunitiesResponse,
    windows_response=ImagingWindowsPage,
)

router = search_routes(OPPORTUNITIES)
of_spacecraft = search_routes(IMAGING_OPPORTUNITIES)
