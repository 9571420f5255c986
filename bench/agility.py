"""Agility of the public benchmarks' satellites, in a module of its own.

Of a class that stands in the script that runs, Numba keeps no compiled code from run to run.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled


class Agility(NamedTuple):
    """rate_deg_s, acceleration_deg_s2: the greatest.  settle_s: after each slew."""

    rate_deg_s: float
    acceleration_deg_s2: float
    settle_s: float

    @classmethod
    def told(cls, members: Mapping[str, Any]) -> Self:
        """By a benchmark's names; whole numbers become doubles, or code is compiled for both."""
        return cls(
            float(members["max_slew_velocity_deg_per_s"]),
            float(members["max_slew_acceleration_deg_per_s2"]),
            float(members["settling_time_s"]),
        )


@compiled
def slew_s(angle_deg: float, agility: Agility) -> float:
    """By a constant acceleration, up to a constant rate, without settling."""
    turning_deg = agility.rate_deg_s**2 / agility.acceleration_deg_s2
    if angle_deg <= turning_deg:
        return float(2.0 * math.sqrt(angle_deg / agility.acceleration_deg_s2))
    return float(
        2.0 * agility.rate_deg_s / agility.acceleration_deg_s2
        + (angle_deg - turning_deg) / agility.rate_deg_s
    )


@compiled
def between_s(from_eci: Array, to_eci: Array, agility: Agility) -> float:
    """Slew and settling between two directions."""
    cosine = min(max(np.dot(from_eci, to_eci), -1.0), 1.0)
    return float(slew_s(math.degrees(math.acos(cosine)), agility) + agility.settle_s)
