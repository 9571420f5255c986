"""The gyros' momentum and steering law, and the gimbal rows by which they fly an attitude.

The law is compiled: null motion, guarded inverse, rate limit.  Rows hold H = R^T G - J omega, G the
total momentum with the gravity gradient's part; the law turns the difference of two into rates.

Source: Platonov, Sumarokov 2019, eq. 1 and the definitions below it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import compiled
from planner.base.rotation import Rotation
from planner.world.platforms.cmg_array import CmgArray, Gyros
from planner.world.platforms.gravity_gradient import gradient_torque_body_n_m


@compiled
def rotor_momentum(gyros: Gyros, gimbal_rad: Array, h_body_n_m_s: Array) -> None:
    """H of the rotors into h_body_n_m_s (3,)."""
    rotor, torque = gyros.rotor_axes_body, gyros.torque_axes_body
    for k in range(3):
        h_body_n_m_s[k] = 0.0
    for i in range(4):
        c = gyros.momentum_n_m_s * math.cos(gimbal_rad[i])
        s = gyros.momentum_n_m_s * math.sin(gimbal_rad[i])
        for k in range(3):
            h_body_n_m_s[k] += c * rotor[i, k] + s * torque[i, k]


@compiled
def _column_products(a: Array, b: Array) -> Array:
    """Of each of four columns with its counterpart."""
    products = np.zeros(4)
    for i in range(4):
        for k in range(3):
            products[i] += a[k, i] * b[k, i]
    return products


@compiled
def steer(
    gyros: Gyros,
    gimbal_rad: Array,
    torque_body_n_m: Array,
    null_gain_rad_s: float,
    rate_rad_s: Array,
) -> None:
    """Gimbal rates (4,), into rate_rad_s, that change H by torque_body_n_m (3,).

    d' = D^T (D D^T)^-1 M/h + rho (E - D^T (D D^T)^-1 D) dPsi/dd, all rates scaled down
    together to gyros.rate_max_rad_s; rho is null_gain_rad_s.  Psi = det(D D^T) grows away from
    singularity; the paper's (m1 x m2)^2 + (m3 x m4)^2 is its part for parallel pairs.  The sign
    is the one that leaves singularities: taken literally, the printed xi = -dPhi/dd under its
    projector drives into them.  Near one (det below the guard) the inverse is damped.
    """
    rotor, torque = gyros.rotor_axes_body, gyros.torque_axes_body
    d, d_turned = np.empty((3, 4)), np.empty((3, 4))
    for i in range(4):
        c, s = math.cos(gimbal_rad[i]), math.sin(gimbal_rad[i])
        for k in range(3):
            d[k, i] = c * torque[i, k] - s * rotor[i, k]
            d_turned[k, i] = -c * rotor[i, k] - s * torque[i, k]
    a = d @ d.T
    psi = np.linalg.det(a)
    damping, guard = 0.0, 0.02  # below the guard the inverse is damped
    if psi < guard:
        damping = 0.01 * (1.0 - psi / guard) + 1e-9
    for k in range(3):
        a[k, k] += damping
    inverse = np.linalg.inv(a)
    y = inverse @ (torque_body_n_m / gyros.momentum_n_m_s)
    gradient = 2.0 * psi * _column_products(inverse @ d, d_turned)
    projected = inverse @ (d @ gradient)
    largest = 0.0
    for i in range(4):
        pseudo, seen = 0.0, 0.0
        for k in range(3):
            pseudo += d[k, i] * y[k]
            seen += d[k, i] * projected[k]
        rate_rad_s[i] = pseudo + null_gain_rad_s * (gradient[i] - seen)
        largest = max(largest, abs(rate_rad_s[i]))
    if largest > gyros.rate_max_rad_s:
        for i in range(4):
            rate_rad_s[i] *= gyros.rate_max_rad_s / largest


def total_momentum_eci(
    q_body_from_eci: Rotation, start_eci_n_m_s: Array, r_sat_eci_m: Array, inertia_kg_m2: Array
) -> Array:
    """Total angular momentum at rows 0.2 s apart, (n, 3), grown by the gravity gradient.

    start_eci_n_m_s: at row 0, (3,).  inertia_kg_m2: (3, 3).  Leaves out the torques of air, light
    and magnetic field (1e-4 N m).
    """
    torque_body_n_m = gradient_torque_body_n_m(q_body_from_eci, r_sat_eci_m, inertia_kg_m2)
    torque_eci_n_m = q_body_from_eci.inv().apply(torque_body_n_m)
    steps_n_m_s = 0.5 * COMMAND_STEP_S * (torque_eci_n_m[1:] + torque_eci_n_m[:-1])
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
        torque_n_m = (h_body_n_m_s[k + 1] - held_n_m_s) / COMMAND_STEP_S
        middle_rad, gain_rad_s = now_rad.copy(), 0.0 if imaging[k] else null_gain_rad_s
        for _ in range(4):
            steer(gyros, middle_rad, torque_n_m, gain_rad_s, rate_rad_s)
            middle_rad = now_rad + 0.5 * COMMAND_STEP_S * rate_rad_s
        now_rad += COMMAND_STEP_S * rate_rad_s
        rows_rad_s[k] = rate_rad_s
    return rows_rad, rows_rad_s
