"""The follower of each kind of platform."""

from collections.abc import Callable

from planner.planning.campaigns.platforms.body import BodyFollower
from planner.planning.campaigns.platforms.follower import Follower
from planner.planning.campaigns.platforms.two_axis import TwoAxisFollower
from planner.planning.campaigns.request import CampaignRequest

FOLLOWERS: dict[str, Callable[[CampaignRequest], Follower]] = {
    "two_axis": TwoAxisFollower,
    "body": BodyFollower,
}


def follower_of(request: CampaignRequest) -> Follower:
    """Of the campaign's platform."""
    return FOLLOWERS[request.platform.kind](request)
