"""The mover of each kind of platform, and its probability in frame before a plan."""

from collections.abc import Callable

from planner.planning.sessions.platforms.body import BodyMover
from planner.planning.sessions.platforms.body_budget import body_probability_held
from planner.planning.sessions.platforms.mover import Mover
from planner.planning.sessions.platforms.two_axis.budget import probability_held
from planner.planning.sessions.platforms.two_axis.mover import TwoAxisMover
from planner.world.scenario import Scenario

MOVERS: dict[str, Callable[[Scenario], Mover]] = {"two_axis": TwoAxisMover, "body": BodyMover}
# That the target stays in the frame.
HELD: dict[str, Callable[..., float]] = {
    "two_axis": probability_held,
    "body": body_probability_held,
}


def mover_of(scenario: Scenario) -> Mover:
    """Of the scenario's platform."""
    return MOVERS[scenario.platform.kind](scenario)
