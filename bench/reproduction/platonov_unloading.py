"""Three coils that unload the gyros in the Earth's magnetic field.

The paper has three "electromagnetic devices" unload the momentum the gyros gather and says no more.
Here they are coils along the body's axes; each takes what part it can of the dipole
m = k (H x B)/|B|^2, whose torque m x B = -k (H - b (b.H)) brings down the momentum across the
field, never that along it; the field's turn along the orbit makes up for that.
Sources: Wertz 1978, section 18.3 (law); the dipole part of IGRF-13, epoch 2020 (field).
"""

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates

RADIUS_M = 6371.2e3
# g11, h11, g10 of IGRF-13 (Alken and others 2021), as the dipole's vector in ITRF.
DIPOLE_ITRF_T = np.array([-1450.9, 4652.5, -29404.8]) * 1e-9
COIL_A_M2 = 140.0  # assumed: a common size for a craft of one to two tonnes
GAIN_PER_S = 5e-3  # with it the coils are at their limit above 1 N m s
STEP_S = 5.0


class Unloading(NamedTuple):
    """Momentum of body and gyros over time, ECI: t_s (n,), h_eci_n_m_s (n, 3), and the coils'
    torque, N m, (n,)."""

    t_s: Array
    h_eci_n_m_s: Array
    torque_n_m: Array


def field_eci_t(r_eci_m: Array, instants: Instants) -> Array:
    """The dipole's field at positions (n, 3), T: 3 percent to 10 from the real one."""
    c_itrf = c_itrf_from_eci(instants)
    r_itrf = np.einsum("nij,nj->ni", c_itrf, r_eci_m)
    distance_m = np.linalg.norm(r_itrf, axis=1, keepdims=True)
    up = r_itrf / distance_m
    along = up @ DIPOLE_ITRF_T
    field_itrf = (RADIUS_M / distance_m) ** 3 * (3.0 * along[:, None] * up - DIPOLE_ITRF_T)
    return np.asarray(np.einsum("nji,nj->ni", c_itrf, field_itrf))


def coil_torque_n_m(h_n_m_s: Array, field_t: Array, axes: Array, coil_a_m2: float) -> Array:
    """Torque of three coils along axes (3, 3, rows) against momentum, any one frame, (3,)."""
    wanted = GAIN_PER_S * np.cross(h_n_m_s, field_t) / (field_t @ field_t)
    dipole = axes @ wanted
    # All scaled down together, so that what is left stays square to the field and against H.
    dipole *= min(1.0, coil_a_m2 / max(float(np.max(np.abs(dipole))), 1e-12))
    return np.asarray(np.cross(dipole @ axes, field_t))


def unload(
    states: OrbitStates,
    instants: Instants,
    axes_eci: Array,
    start_eci_n_m_s: Array,
    disturbance_eci_n_m: Array,
    coil_a_m2: float = COIL_A_M2,
) -> Unloading:
    """Momentum along an orbit whose states are STEP_S apart.

    axes_eci: the coils' axes (n, 3, 3), rows; disturbance_eci_n_m: (n, 3), outer torque.
    """
    field = field_eci_t(states.r_sat_eci_m, instants)
    h, rows, torques = start_eci_n_m_s.copy(), [], []
    for k in range(len(field)):
        torque = coil_torque_n_m(h, field[k], axes_eci[k], coil_a_m2)
        rows.append(h)
        torques.append(float(np.linalg.norm(torque)))
        h = h + STEP_S * (torque + disturbance_eci_n_m[k])
    return Unloading(np.arange(len(rows)) * STEP_S, np.array(rows), np.array(torques))
