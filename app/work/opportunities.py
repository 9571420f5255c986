"""A child's work for opportunities."""

from app.answers.members import ProvenanceOut
from app.answers.opportunities import opportunities_json
from planner.opportunities import OpportunityRequest, find_opportunities


def answer_opportunities(request: OpportunityRequest, provenance: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON."""
    return opportunities_json(find_opportunities(request), provenance)
