"""Campaigns: the sessions a platform is to fly, and their order."""

from typing import TYPE_CHECKING

from planner.base.on_first_use import on_first_use
from planner.planning.campaigns.chosen import ChosenLook, UnchosenTarget
from planner.planning.campaigns.fleet import CampaignCarrier, FleetRequest
from planner.planning.campaigns.request import CampaignRequest, CampaignTarget, ViewWeights

if TYPE_CHECKING:
    from planner.planning.campaigns.campaign import (
        Campaign,
        ChosenPass,
        choose_campaign,
        choose_together,
        choose_what_is_asked,
        priced_here,
        requests_to_choose,
        scenario_of,
    )
    from planner.planning.campaigns.carrier_looks import looks_of_carrier
    from planner.planning.campaigns.view import Seen
else:
    __getattr__ = on_first_use(
        Campaign="planner.planning.campaigns.campaign",
        ChosenPass="planner.planning.campaigns.campaign",
        Seen="planner.planning.campaigns.view",
        choose_campaign="planner.planning.campaigns.campaign",
        choose_together="planner.planning.campaigns.campaign",
        choose_what_is_asked="planner.planning.campaigns.campaign",
        looks_of_carrier="planner.planning.campaigns.carrier_looks",
        priced_here="planner.planning.campaigns.campaign",
        requests_to_choose="planner.planning.campaigns.campaign",
        scenario_of="planner.planning.campaigns.campaign",
    )

__all__ = [
    "Campaign",
    "CampaignCarrier",
    "CampaignRequest",
    "CampaignTarget",
    "ChosenLook",
    "ChosenPass",
    "FleetRequest",
    "Seen",
    "UnchosenTarget",
    "ViewWeights",
    "choose_campaign",
    "choose_together",
    "choose_what_is_asked",
    "looks_of_carrier",
    "priced_here",
    "requests_to_choose",
    "scenario_of",
]
