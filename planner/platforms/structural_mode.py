"""How does a structure ring that the platform is mounted on, or that it carries?"""

import math

from planner.spec import spec

FREQUENCY_HZ = (0.02, 2.5)  # slower is no vibration; a table has five rows a second
DAMPING_MAX = 0.5


@spec
class StructuralMode:
    """One mode of vibration, excited by the acceleration of either axis.

    frequency_hz: undamped.  damping: share of critical damping.
    """

    frequency_hz: float
    damping: float = 0.005

    def __post_init__(self) -> None:
        least_hz, most_hz = FREQUENCY_HZ
        if not least_hz <= self.frequency_hz <= most_hz:
            raise ValueError(
                f"frequency_hz must lie in {least_hz:g}..{most_hz:g} (the table has five rows a "
                f"second), not {self.frequency_hz:g}"
            )
        if not 0.0 <= self.damping <= DAMPING_MAX:
            raise ValueError(f"damping must lie in 0..{DAMPING_MAX:g}, not {self.damping:g}")

    @property
    def eigenvalue_rad_s(self) -> complex:
        """The mode's deflection goes as exp of this times t."""
        omega_rad_s = 2.0 * math.pi * self.frequency_hz
        return omega_rad_s * complex(-self.damping, math.sqrt(1.0 - self.damping**2))
