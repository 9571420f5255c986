"""A structural mode: how what the platform is mounted on, or carries, rings."""

import math
from typing import Annotated

from planner.spec import Within, spec


@spec
class StructuralMode:
    """One mode of vibration, excited by the acceleration of either axis.

    frequency_hz: undamped; slower is no vibration, and a table has five rows a second.
    damping: share of critical damping.
    """

    frequency_hz: Annotated[float, Within(0.02, 2.5)]
    damping: Annotated[float, Within(0.0, 0.5)] = 0.005

    @property
    def eigenvalue_rad_s(self) -> complex:
        """The mode's deflection goes as exp of this times t."""
        omega_rad_s = 2.0 * math.pi * self.frequency_hz
        return omega_rad_s * complex(-self.damping, math.sqrt(1.0 - self.damping**2))
