"""What does the child do for opportunities?"""

from app.api.opportunity_response import opportunities_json
from app.api.provenance import ProvenanceOut
from planner.opportunities import OpportunityRequest, find_opportunities


def opportunities_found(request: OpportunityRequest, made: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON."""
    return opportunities_json(find_opportunities(request), made)
