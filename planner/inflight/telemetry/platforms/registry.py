"""The sensors of each kind of platform."""

from collections.abc import Callable

from planner.inflight.telemetry.platforms.body import BodySensors
from planner.inflight.telemetry.platforms.sensors import PlatformSensors
from planner.inflight.telemetry.platforms.two_axis import AxisSensors
from planner.world.plan import FlightPlan

SENSORS: dict[str, Callable[[FlightPlan], PlatformSensors]] = {
    "two_axis": AxisSensors,
    "body": BodySensors,
}


def sensors_of(plan: FlightPlan) -> PlatformSensors:
    """Of the platform that flew it."""
    return SENSORS[plan.scenario.platform.kind](plan)
