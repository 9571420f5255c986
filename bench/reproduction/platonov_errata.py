"""The laws of Platonov, Sumarokov 2019 taken by the letter: what their misprints do, in numbers.

A rigid body, ideal gyros and sensors, the control cycle of 0.2 s.  Source: "Control law of the
gyro system", eq. 1 and the laws above it.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from planner.base.arrays import Array
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.cmg_array import CmgArray
from planner.spacecraft.vehicle.definition import AGILE_CMG

INERTIA_KG_M2 = np.array(AGILE_CMG.inertia_kg_m2)
ARRAY = CmgArray()
K1_PER_S, K2_PER_S2 = 1.8, 1.0
ORBITAL_RATE_RAD_S = np.array([0.0, 0.0, -np.deg2rad(0.0617)])  # in pitch, from 600 km
TURN_RATE_RAD_S = np.array([0.0, 0.0, np.deg2rad(1.5)])
SUBSTEPS = 10


def parallel_measure(gimbal_rad: Array) -> float:
    """The paper's Phi = -(m1 x m2)^2 - (m3 x m4)^2: 0 where each pair's torques are parallel."""
    m = ARRAY.jacobian(gimbal_rad).T
    return -float(np.sum(np.cross(m[0], m[1]) ** 2) + np.sum(np.cross(m[2], m[3]) ** 2))


def printed_rates_rad_s(
    gimbal_rad: Array, torque_n_m: Array, weight_rad_s: float, xi_sign: float
) -> Array:
    """Gimbal rates of eq. 1: D'(DD')^-1 M/h + rho (D'(DD')^-1 D - E) xi, xi = sign dPhi/dd.

    xi_sign: -1 as printed.
    """
    d = ARRAY.jacobian(gimbal_rad)
    inverse = d.T @ np.linalg.inv(d @ d.T)
    step = 1e-6 * np.eye(4)
    gradient = np.array(
        [parallel_measure(gimbal_rad + e) - parallel_measure(gimbal_rad - e) for e in step]
    ) / 2e-6  # fmt: skip
    null = (inverse @ d - np.eye(4)) @ (xi_sign * gradient)
    return np.asarray(inverse @ torque_n_m / ARRAY.momentum_n_m_s + weight_rad_s * null)


def margin_under_null_motion(xi_sign: float, seconds: float = 120.0) -> Array:
    """Least singular value of D every 0.2 s, from empty gyros and without torque: (n,)."""
    gimbal_rad = ARRAY.gimbal_angles(np.zeros(3))
    margins = []
    for _ in range(round(seconds / TICK_S)):
        margins.append(float(ARRAY.singularity_margin(gimbal_rad)))
        if margins[-1] < 1e-2:
            break
        rates = printed_rates_rad_s(gimbal_rad, np.zeros(3), 0.02, xi_sign)
        gimbal_rad = gimbal_rad + TICK_S * rates
    return np.array(margins)


class Hold(NamedTuple):
    """Of the imaging law at a steady rate: the error left, deg, and its torque, N m."""

    error_deg: float
    torque_n_m: float


def hold(rate_rad_s: Array, stored_n_m_s: Array, twice: bool, seconds: float = 40.0) -> Hold:
    """The imaging law on a steadily turning goal with momentum stored in the gyros.

    twice: with M* = M + omega x H as in the text, M holding omega x G already; else omega x G
    once.  stored_n_m_s: in ECI; the gyros hold what the body doesn't.
    """
    goal, omega = Rotation.identity(), rate_rad_s.copy()
    q_eci_from_body = goal
    total_eci = INERTIA_KG_M2 * omega + stored_n_m_s
    step_s = TICK_S / SUBSTEPS
    gyros = stored_n_m_s.copy()
    for _ in range(round(seconds / TICK_S)):
        error = (goal.inv() * q_eci_from_body).as_quat(canonical=True)[:3]
        total = q_eci_from_body.inv().apply(total_eci)
        # What the gyros take up: M = -J(k2 2n + k1 (omega - goal's)) is given to the body.
        acceleration = -K2_PER_S2 * 2.0 * error - K1_PER_S * (omega - rate_rad_s)
        taken = -INERTIA_KG_M2 * acceleration - np.cross(omega, total)
        if twice:
            taken -= np.cross(omega, gyros)
        for _ in range(SUBSTEPS):
            gyros = gyros + step_s * taken
            half = q_eci_from_body * Rotation.from_rotvec(0.5 * step_s * omega)
            middle = (half.inv().apply(total_eci) - gyros + 0.5 * step_s * taken) / INERTIA_KG_M2
            q_eci_from_body = q_eci_from_body * Rotation.from_rotvec(step_s * middle)
            omega = (q_eci_from_body.inv().apply(total_eci) - gyros) / INERTIA_KG_M2
        goal = goal * Rotation.from_rotvec(TICK_S * rate_rad_s)
    left = (goal.inv() * q_eci_from_body).magnitude()
    return Hold(float(np.rad2deg(left)), float(np.linalg.norm(np.cross(omega, gyros))))


def switching_rate_deg_s(torque_n_m: float, share: float = 0.75) -> float:
    """Rate the imaging law asks for where the paper hands over to it without a limit of rate.

    sqrt(2 a1 phi) = phi k2/k1 at phi = 2 a1 (k1/k2)^2; the rate is 2 a1 k1/k2.
    """
    a1 = share * torque_n_m / INERTIA_KG_M2[2]
    return float(np.rad2deg(2.0 * a1 * K1_PER_S / K2_PER_S2))
