"""Which sessions a platform is to fly, and in what order."""

from planner.campaigns.campaign import (
    Campaign,
    ChosenLook,
    ChosenPass,
    UnchosenTarget,
    choose_campaign,
    scenario_of,
)
from planner.campaigns.request import CampaignRequest, CampaignTarget
from planner.campaigns.unseen import Closing, Unseen
from planner.campaigns.view import Seen, ViewWeights

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
