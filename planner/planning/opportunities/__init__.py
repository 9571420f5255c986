"""Windows in which each target can be seen."""

from typing import TYPE_CHECKING

from planner.base.on_first_use import on_first_use
from planner.planning.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.planning.opportunities.windows import (
    Opportunities,
    Sightings,
    WindowEdges,
    Windows,
)

if TYPE_CHECKING:
    from planner.planning.opportunities.search import (
        WindowSearch,
        find_opportunities,
        opportunities_however_many,
    )
else:
    __getattr__ = on_first_use(
        WindowSearch="planner.planning.opportunities.search",
        find_opportunities="planner.planning.opportunities.search",
        opportunities_however_many="planner.planning.opportunities.search",
    )

__all__ = [
    "Opportunities",
    "OpportunityConditions",
    "OpportunityRequest",
    "OpportunityTarget",
    "Sightings",
    "WindowEdges",
    "WindowSearch",
    "Windows",
    "find_opportunities",
    "opportunities_however_many",
]
