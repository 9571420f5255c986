"""The motion of a table's axes between its rows, and the limits it keeps."""

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.interpolation import cubic_coefficients
from planner.world.platforms import BodyPlatform
from planner.world.scenario import Scenario

Bounds = tuple[float, float]


def accelerations_rad_s2(table: CommandTable, cell: Indices) -> Array:
    """At the start and the end of each cell between two rows, (k, 2, m).

    Of axes those of the cubic that is flown there, of a body those of the two rows.
    """
    if table.acceleration_rad_s2 is not None:
        return np.stack([table.acceleration_rad_s2[cell + i] for i in (0, 1)], axis=1)
    h = COMMAND_STEP_S
    angle, rate = table.position, table.rate_rad_s
    *_, c2, c3 = cubic_coefficients(h, angle[cell], angle[cell + 1], rate[cell], rate[cell + 1])
    return np.stack([2.0 * c2, 2.0 * c2 + 6.0 * c3], axis=1) / h**2


def bounds_rad(scenario: Scenario) -> tuple[tuple[Bounds | None, Bounds, Bounds, Bounds], ...]:
    """(least, greatest) of angle, rate, acceleration and jerk of each axis, in rad and s.

    Of a body about its axes, without an angle; limits of magnitude hold for the whole vector.
    """
    platform = scenario.platform
    if isinstance(platform, BodyPlatform):
        by_axis = platform.agility.by_order_rad.T.tolist()
        return tuple((None, (-v, v), (-a, a), (-j, j)) for v, a, j in by_axis)
    found = []
    for limits in scenario.axis_limits:
        angle, rate, acceleration, jerk = limits.bounds
        found.append((angle, rate, acceleration, jerk))
    return tuple(found)
