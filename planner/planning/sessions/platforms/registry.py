"""The mover of each kind of platform."""

from collections.abc import Callable

from planner.planning.sessions.platforms.body import BodyMover
from planner.planning.sessions.platforms.mover import Mover
from planner.planning.sessions.platforms.two_axis.mover import TwoAxisMover
from planner.world.scenario import Scenario

MOVERS: dict[str, Callable[[Scenario], Mover]] = {"two_axis": TwoAxisMover, "body": BodyMover}


def mover_of(scenario: Scenario) -> Mover:
    """Of the scenario's platform."""
    return MOVERS[scenario.platform.kind](scenario)
