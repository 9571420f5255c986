"""When each target can be seen."""

from typing import TYPE_CHECKING

from planner.on_first_use import on_first_use
from planner.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.opportunities.windows import Opportunities, Sightings, Windows

if TYPE_CHECKING:
    from planner.opportunities.search import find_opportunities, opportunities_however_many
else:
    __getattr__ = on_first_use(
        find_opportunities="planner.opportunities.search",
        opportunities_however_many="planner.opportunities.search",
    )

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
