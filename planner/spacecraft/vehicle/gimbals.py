"""The gimbal angles and rates that give a planned attitude.

The gyros must hold H = R^T G - J omega at every row, G the total momentum with the gravity
gradient's part; the steering law turns the difference of two rows into gimbal rates.
"""

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.compiled import compiled
from planner.base.rotation import Rotation
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.cmg_array import CmgArray, Gyros
from planner.spacecraft.vehicle.steering import rotor_momentum, steer
from planner.world.frames.geodesy import MU_EARTH_M3_S2


def total_momentum_eci(
    q_body_from_eci: Rotation, start_eci_n_m_s: Array, r_sat_eci_m: Array, inertia_kg_m2: Array
) -> Array:
    """Total angular momentum at rows 0.2 s apart, (n, 3), grown by the gravity gradient.

    inertia_kg_m2: (3,).  Leaves out aerodynamic, solar and magnetic torque (1e-4 N m).
    """
    radius_m = np.linalg.norm(r_sat_eci_m, axis=1, keepdims=True)
    nadir_body = q_body_from_eci.apply(-r_sat_eci_m / radius_m)
    torque_body_n_m = (
        3.0 * MU_EARTH_M3_S2 / radius_m**3 * np.cross(nadir_body, inertia_kg_m2 * nadir_body)
    )
    torque_eci_n_m = q_body_from_eci.inv().apply(torque_body_n_m)
    steps_n_m_s = 0.5 * TICK_S * (torque_eci_n_m[1:] + torque_eci_n_m[:-1])
    return np.asarray(start_eci_n_m_s + np.vstack([np.zeros(3), np.cumsum(steps_n_m_s, axis=0)]))


def gimbal_rows(
    array: CmgArray, h_body_n_m_s: Array, imaging: NDArray[np.bool_], null_gain_rad_s: float
) -> tuple[Array, Array]:
    """Gimbal angles and the rates held from each row on, (n, 4) each; the last rate is zero.

    h_body_n_m_s: what the gyros must hold, (n, 3).  imaging: (n - 1,), no null motion.
    """
    start_rad = array.gimbal_angles(h_body_n_m_s[0])
    h_body_n_m_s = np.ascontiguousarray(h_body_n_m_s)
    return _propagate(array.gyros(), h_body_n_m_s, imaging, start_rad, null_gain_rad_s)


@compiled
def _propagate(
    gyros: Gyros,
    h_body_n_m_s: Array,
    imaging: NDArray[np.bool_],
    start_rad: Array,
    null_gain_rad_s: float,
) -> tuple[Array, Array]:
    n = len(h_body_n_m_s)
    rows_rad, rows_rad_s = np.zeros((n, 4)), np.zeros((n, 4))
    now_rad = start_rad.copy()
    rate_rad_s, held_n_m_s = np.zeros(4), np.zeros(3)
    for k in range(n):
        rows_rad[k] = now_rad
        if k == n - 1:
            break
        rotor_momentum(gyros, now_rad, held_n_m_s)
        torque_n_m = (h_body_n_m_s[k + 1] - held_n_m_s) / TICK_S
        middle_rad, gain_rad_s = now_rad.copy(), 0.0 if imaging[k] else null_gain_rad_s
        for _ in range(4):
            steer(gyros, middle_rad, torque_n_m, gain_rad_s, rate_rad_s)
            middle_rad = now_rad + 0.5 * TICK_S * rate_rad_s
        now_rad += TICK_S * rate_rad_s
        rows_rad_s[k] = rate_rad_s
    return rows_rad, rows_rad_s
