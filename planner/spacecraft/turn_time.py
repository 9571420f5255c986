"""How long does a turn take, at a guess good enough to choose by?

Least time about the hardest axis for the angle, from rest to rest, plus an allowance for
moving ends, the guard tick after imaging and the settling time before it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.spacecraft.definition import AgileSpacecraft
from planner.spacecraft.eigenaxis import eigenaxis_turn
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turn_problem import EndState, TurnProblem

Array = NDArray[np.float64]
MOVING_ENDS_S = 0.8  # rate differences of 0.4 deg/s at 1 deg/s^2, both ends
ANGLES_DEG = np.array([0.05, 1.0, 2.0, 4.0, 7.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0, 130.0])


@dataclass(frozen=True, eq=False)
class TurnTime:
    """Seconds between two imaging intervals as a function of the angle between them."""

    angles_rad: Array
    seconds: Array

    def ticks(self, angle_rad: Array) -> NDArray[np.int64]:
        """Whole 0.2 s ticks for angles (n,)."""
        seconds = np.interp(angle_rad, self.angles_rad, self.seconds)
        return np.asarray(np.ceil(seconds / TICK_S - 1e-6), dtype=np.int64)


def turn_time(spacecraft: AgileSpacecraft) -> TurnTime:
    """The table for a spacecraft's limits."""
    angles = np.deg2rad(ANGLES_DEG)
    still = np.zeros(3)
    axis = np.eye(3)[int(np.argmax(spacecraft.inertia_kg_m2))]
    seconds = []
    for angle in angles:
        problem = TurnProblem(
            start=EndState(
                attitude=Rotation.identity(), omega_body_rad_s=still, alpha_body_rad_s2=still
            ),
            end=EndState(
                attitude=Rotation.from_rotvec(angle * axis),
                omega_body_rad_s=still,
                alpha_body_rad_s2=still,
            ),
            momentum_eci_n_m_s=still,
            inertia_kg_m2=np.array(spacecraft.inertia_kg_m2),
            limits=spacecraft.slew,
        )
        seconds.append(eigenaxis_turn(problem).duration_s)
    extra_s = MOVING_ENDS_S + TICK_S + spacecraft.slew.settle_s
    return TurnTime(angles, np.array(seconds) + extra_s)
