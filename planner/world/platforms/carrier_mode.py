"""Modes in which the carrier's structure rocks under the platform."""

import math
from typing import Annotated

from planner.base.spec import UnitPart, Within, spec

UNIT_TOLERANCE = 1e-6


@spec
class CarrierMode:
    """One mode in which the carrier's structure rocks, excited by the reaction of the axes.

    axis_platform: unit vector about which the platform's base turns. E.g. `[1.0, 0.0, 0.0]`.
    frequency_hz: undamped, without the axes. E.g. `0.3`.
    damping: share of critical damping. E.g. `0.005`.
    inertia_kg_m2: of what swings, about that axis, without the axes. E.g. `5e5`.
    """

    axis_platform: tuple[UnitPart, UnitPart, UnitPart]
    frequency_hz: Annotated[float, Within(0.02, 10.0)]
    damping: Annotated[float, Within(0.0, 0.5)] = 0.005
    inertia_kg_m2: Annotated[float, Within(1.0, 1e9)]

    def __post_init__(self) -> None:
        norm = math.hypot(*self.axis_platform)
        if not abs(norm - 1.0) <= UNIT_TOLERANCE:
            raise ValueError(f"axis_platform must have unit length, not {norm}")
