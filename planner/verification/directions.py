"""Directions in inertial space: angles between them, turns, those of the local orbital frame."""

import numpy as np

from planner.base.arrays import Array
from planner.world.orbits import OrbitStates


def apart_rad(a_eci: Array, b_eci: Array) -> Array:
    """Angles between vectors of shape (n, 3), accurate at 0 and pi too, shape (n,)."""
    across = np.linalg.norm(np.cross(a_eci, b_eci), axis=1)
    return np.asarray(np.arctan2(across, np.sum(a_eci * b_eci, axis=1)))


def rotation_matrix(q_xyzw: tuple[float, ...]) -> Array:
    """The rotation v -> q v q* as a matrix, (3, 3); q is scalar last and needs no unit length."""
    x, y, z, w = np.asarray(q_xyzw) / np.linalg.norm(q_xyzw)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def eci_from_lvlh(vector_lvlh: Array, states: OrbitStates) -> Array:
    """Vectors (n, 3) in ECI; +Z to the Earth's centre, +Y against the orbit normal, +X completing
    (near the velocity)."""
    r, v = states.r_sat_eci_m, states.v_sat_eci_m_s
    down = -r / np.sqrt(np.sum(r * r, axis=1, keepdims=True))
    forward_m_s = v - np.sum(v * down, axis=1, keepdims=True) * down
    forward = forward_m_s / np.sqrt(np.sum(forward_m_s * forward_m_s, axis=1, keepdims=True))
    right = np.cross(down, forward)
    x, y, z = (vector_lvlh[:, k, None] for k in range(3))
    return np.asarray(x * forward + y * right + z * down)
