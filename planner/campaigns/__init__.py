"""Which sessions a platform is to fly, and in what order."""

from typing import TYPE_CHECKING

from planner.campaigns.request import CampaignRequest, CampaignTarget, Closing, ViewWeights
from planner.on_first_use import on_first_use

if TYPE_CHECKING:
    from planner.campaigns.campaign import (
        Campaign,
        ChosenLook,
        ChosenPass,
        UnchosenTarget,
        choose_campaign,
        scenario_of,
    )
    from planner.campaigns.unseen import Unseen
    from planner.campaigns.view import Seen
else:
    __getattr__ = on_first_use(
        Campaign="planner.campaigns.campaign",
        ChosenLook="planner.campaigns.campaign",
        ChosenPass="planner.campaigns.campaign",
        Seen="planner.campaigns.view",
        UnchosenTarget="planner.campaigns.campaign",
        Unseen="planner.campaigns.unseen",
        choose_campaign="planner.campaigns.campaign",
        scenario_of="planner.campaigns.campaign",
    )

__all__ = [
    "Campaign",
    "CampaignRequest",
    "CampaignTarget",
    "ChosenLook",
    "ChosenPass",
    "Closing",
    "Seen",
    "UnchosenTarget",
    "Unseen",
    "ViewWeights",
    "choose_campaign",
    "scenario_of",
]
