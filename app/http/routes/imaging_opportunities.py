"""Passes of the imaging spacecraft over HTTP."""

from app.answers.imaging_opportunities import ImagingOpportunitiesResponse, ImagingWindowsPage
from app.http.routes.searches import SearchResource, search_routes
from app.jobs.child import Bounds
from app.requests.examples import IMAGING_OPPORTUNITY_EXAMPLES
from app.requests.listings import listing_of_imaging
from app.requests.spacecraft import read_imaging_opportunity_request
from app.work.spacecraft import answer_imaging_opportunities

router = search_routes(
    SearchResource(
        kind="imaging_opportunities",
        path="/v1/spacecraft/opportunities",
        request_schema="ImagingOpportunityRequest",
        listing=listing_of_imaging,
        singular="search for opportunities",
        tag="spacecraft",
        summary="Search for passes of the imaging spacecraft",
        examples=IMAGING_OPPORTUNITY_EXAMPLES,
        read=read_imaging_opportunity_request,
        find=answer_imaging_opportunities,
        bounds=Bounds(deadline_s=120.0, memory_mib=2000),
        response=ImagingOpportunitiesResponse,
        page=ImagingWindowsPage,
    )
)
