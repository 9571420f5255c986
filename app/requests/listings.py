"""Listings of requests: the members that lists show until a request is fulfilled."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from app.store.job import Listing

if TYPE_CHECKING:
    from planner.planning.campaigns import CampaignRequest, FleetRequest
    from planner.planning.opportunities import OpportunityRequest
    from planner.spacecraft.requests import ImagingPlanRequest
    from planner.world.scenario import Scenario


def listing_of_scenario(scenario: "Scenario") -> Listing:
    return Listing(
        platform=scenario.platform.name,
        start_utc=scenario.sessions[0].start,
        stop_utc=scenario.sessions[-1].stop,
        targets=_each_once(session.label for session in scenario.sessions),
    )


def listing_of_imaging(request: "ImagingPlanRequest") -> Listing:
    return Listing(
        platform=request.spacecraft,
        start_utc=request.start,
        stop_utc=request.stop,
        targets=_each_once(one.name for one in request.requests),
    )


def listing_of_search(request: "CampaignRequest | FleetRequest | OpportunityRequest") -> Listing:
    return Listing(
        platform=request.platform_names,
        start_utc=request.start,
        stop_utc=request.stop,
        targets=_each_once(one.id for one in request.targets),
    )


def _each_once(labels: Iterable[str]) -> tuple[str, ...]:
    """In their order, without empty ones."""
    return tuple(dict.fromkeys(label for label in labels if label))
