"""The flyer of each kind of platform."""

from collections.abc import Callable

from planner.inflight.simulation.platforms.body import BodyFlyer
from planner.inflight.simulation.platforms.flyer import Flyer
from planner.inflight.simulation.platforms.two_axis import TwoAxisFlyer
from planner.world.scenario import Scenario

FLYERS: dict[str, Callable[[Scenario], Flyer]] = {"two_axis": TwoAxisFlyer, "body": BodyFlyer}


def flyer_of(scenario: Scenario) -> Flyer:
    """Of the scenario's platform."""
    return FLYERS[scenario.platform.kind](scenario)
