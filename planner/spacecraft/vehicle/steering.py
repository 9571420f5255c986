"""The gyros' momentum and steering law, compiled: null motion, guarded inverse, rate limit.

Source: Platonov, Sumarokov 2019, eq. 1 and the definitions below it.
"""

import math

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled
from planner.spacecraft.vehicle.cmg_array import Gyros

SINGULARITY_GUARD = 0.02  # of det(D D^T): below it the inverse is damped


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
    damping = 0.0
    if psi < SINGULARITY_GUARD:
        damping = 0.01 * (1.0 - psi / SINGULARITY_GUARD) + 1e-9
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
