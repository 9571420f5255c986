"""The lookout of each kind of platform."""

from collections.abc import Callable

from planner.planning.opportunities.platforms.body import BodyLookout
from planner.planning.opportunities.platforms.lookout import Lookout
from planner.planning.opportunities.platforms.two_axis import TwoAxisLookout
from planner.world.attitude import AttitudeLaw
from planner.world.platforms import AnyPlatform

LOOKOUTS: dict[str, Callable[[AnyPlatform, AttitudeLaw | None], Lookout]] = {
    "two_axis": TwoAxisLookout,
    "body": BodyLookout,
}


def lookout_of(platform: AnyPlatform, attitude: AttitudeLaw | None) -> Lookout:
    """Of a platform; attitude: of the carrier that it stands on, if it does."""
    return LOOKOUTS[platform.kind](platform, attitude)
