"""When each target can be seen."""

from planner.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.opportunities.search import find_opportunities, opportunities_however_many
from planner.opportunities.windows import Opportunities, Sightings, Windows

__all__ = [
    "Opportunities",
    "OpportunityConditions",
    "OpportunityRequest",
    "OpportunityTarget",
    "Sightings",
    "Windows",
    "find_opportunities",
    "opportunities_however_many",
]
