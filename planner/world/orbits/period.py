"""The time of one revolution of an orbit."""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import MU_EARTH_M3_S2, WGS84_A_M
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates


@dataclass(frozen=True, kw_only=True)
class PeriodOptions:
    """What of the Earth's field counts beside the central part."""

    j2: float = 1.0826359e-3  # EGM2008


OPTIONS = PeriodOptions()


def period_s(instants: Instants, states: OrbitStates) -> Array:
    """Of an orbit by its energy, that of the Earth's flattening included, (n,).

    So it is the same to 0.1 s wherever on a low orbit it is looked at, and 0.1 % or so off the time
    from node to node.  Infinite where the orbit isn't closed.
    """
    r_m = np.linalg.norm(states.r_sat_eci_m, axis=1)
    along_pole_m = np.einsum("ni,ni->n", c_itrf_from_eci(instants)[:, 2], states.r_sat_eci_m)
    flattening = OPTIONS.j2 * (WGS84_A_M / r_m) ** 2 * (1.5 * (along_pole_m / r_m) ** 2 - 0.5)
    potential_m2_s2 = MU_EARTH_M3_S2 / r_m * (1.0 - flattening)
    energy_m2_s2 = 0.5 * np.sum(states.v_sat_eci_m_s**2, axis=1) - potential_m2_s2
    bound_m2_s2 = np.maximum(-2.0 * energy_m2_s2, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * math.pi * MU_EARTH_M3_S2 / bound_m2_s2**1.5)
