"""The apparent direction of a target, seen from the moving carrier."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets.session_target import SessionTarget

SPEED_OF_LIGHT_M_S = 299792458.0  # exact, BIPM


@dataclass(frozen=True, kw_only=True)
class ApparentDirection:
    """A target at n instants, after light time and aberration.

    direction_eci: unit vectors, shape (n, 3).  range_m: shape (n,).
    clearance_rad: shape (n,), how far the target is inside the region where it can be
    seen; negative where it can't.
    """

    direction_eci: Array
    range_m: Array
    clearance_rad: Array


class VisibleTarget(SessionTarget, ABC):
    """A target that is pointed at by looking along its apparent direction."""

    @abstractmethod
    def apparent(self, instants: Instants, states: OrbitStates) -> ApparentDirection:
        """The target seen from the orbit's `states` at the same n instants."""

    @abstractmethod
    def hidden_because(self, clearance_rad: float) -> str:
        """Why a negative clearance means it can't be seen, for a refusal."""


def aberrate(direction: Array, v_observer_m_s: Array) -> Array:
    """Direction in which a moving observer sees light that comes from `direction`.

    Both (n, 3) in the same inertial axes; unit vectors in and out.
    Source: Explanatory Supplement to the Astronomical Almanac (2013), eq. 7.40, as ERFA's `ab`
    far from the Sun.
    """
    beta = v_observer_m_s / SPEED_OF_LIGHT_M_S
    inverse_gamma = np.sqrt(1.0 - np.sum(beta**2, axis=1))
    return np.asarray(erfa.ab(direction, beta, np.inf, inverse_gamma))
