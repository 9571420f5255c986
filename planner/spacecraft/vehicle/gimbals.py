"""Which gimbal angles and rates give the planned attitude?

The gyros must hold H = R^T G - J omega at every row, G the total momentum with the gravity
gradient's part; the steering law turns the difference of two rows into gimbal rates.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.compiled import compiled
from planner.frames.geodesy import MU_EARTH_M3_S2
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.cmg_array import CmgArray, rotor_momentum, steer


def total_momentum_eci(
    attitude: Rotation, start_n_m_s: Array, r_sat_eci_m: Array, inertia_kg_m2: Array
) -> Array:
    """Total angular momentum at rows 0.2 s apart, (n, 3), grown by the gravity gradient.

    attitude: eci_from_body.  Leaves out aerodynamic, solar and magnetic torque (1e-4 N m).
    """
    radius_m = np.linalg.norm(r_sat_eci_m, axis=1, keepdims=True)
    nadir_body = attitude.inv().apply(-r_sat_eci_m / radius_m)
    torque_body = (
        3.0 * MU_EARTH_M3_S2 / radius_m**3 * np.cross(nadir_body, inertia_kg_m2 * nadir_body)
    )
    torque_eci = attitude.apply(torque_body)
    steps = 0.5 * TICK_S * (torque_eci[1:] + torque_eci[:-1])
    return np.asarray(start_n_m_s + np.vstack([np.zeros(3), np.cumsum(steps, axis=0)]))


def gimbal_rows(
    array: CmgArray, momentum_body_n_m_s: Array, imaging: NDArray[np.bool_], null_gain_rad_s: float
) -> tuple[Array, Array]:
    """Gimbal angles and the rates held from each row on, (n, 4) each; the last rate is zero.

    momentum_body_n_m_s: what the gyros must hold, (n, 3).  imaging: (n - 1,), no null motion.
    """
    start = array.gimbal_angles(momentum_body_n_m_s[0])
    return _propagate(
        np.ascontiguousarray(momentum_body_n_m_s),
        imaging,
        start,
        array.momentum_n_m_s,
        np.ascontiguousarray(array.rotor_axes),
        np.ascontiguousarray(array.torque_axes),
        array.rate_max_rad_s,
        null_gain_rad_s,
    )


@compiled
def _propagate(
    wanted: Array,
    imaging: NDArray[np.bool_],
    start: Array,
    momentum: float,
    rotor: Array,
    torque: Array,
    rate_max: float,
    null_gain: float,
) -> tuple[Array, Array]:
    n = len(wanted)
    angles, rates = np.zeros((n, 4)), np.zeros((n, 4))
    now, middle, rate, held = start.copy(), start.copy(), np.zeros(4), np.zeros(3)
    for k in range(n):
        angles[k] = now
        if k == n - 1:
            break
        rotor_momentum(now, momentum, rotor, torque, held)
        change = (wanted[k + 1] - held) / TICK_S
        middle[:] = now
        for _ in range(4):
            gain = 0.0 if imaging[k] else null_gain
            steer(middle, change, momentum, rotor, torque, rate_max, gain, rate)
            for i in range(4):
                middle[i] = now[i] + 0.5 * TICK_S * rate[i]
        for i in range(4):
            now[i] += TICK_S * rate[i]
        rates[k] = rate
    return angles, rates
