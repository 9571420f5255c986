"""Which sessions a platform is to fly, and in what order."""

from planner.campaigns.campaign import (
    Campaign,
    ChosenLook,
    ChosenPass,
    choose_campaign,
    scenario_of,
)
from planner.campaigns.request import CampaignRequest, CampaignTarget

__all__ = [
    "Campaign",
    "CampaignRequest",
    "CampaignTarget",
    "ChosenLook",
    "ChosenPass",
    "choose_campaign",
    "scenario_of",
]
