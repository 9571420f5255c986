"""The limits that the axes of a plan's table keep, as its pictures and views show them."""

from planner.world.platforms import BodyPlatform, Bounds
from planner.world.scenario import Scenario


def bounds_rad(scenario: Scenario) -> tuple[tuple[Bounds | None, Bounds, Bounds, Bounds], ...]:
    """(least, greatest) of angle, rate, acceleration and jerk of each axis, in rad and s.

    Of a body about its axes, without an angle; limits of magnitude hold for the whole vector.
    """
    platform = scenario.platform
    if isinstance(platform, BodyPlatform):
        by_axis = platform.agility.by_order_rad.T.tolist()
        return tuple((None, (-v, v), (-a, a), (-j, j)) for v, a, j in by_axis)
    return tuple(limits.bounds for limits in scenario.axis_limits)
