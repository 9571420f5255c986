"""The axes of the local orbital frame (LVLH)."""

import numpy as np

from planner.base.arrays import Array, cross
from planner.base.rotation import Rotation


def q_lvlh_from_eci(r_sat_eci_m: Array, v_sat_eci_m_s: Array) -> Rotation:
    """n rotations to LVLH axes: +Z geocentric nadir, +Y against the orbit normal, +X forward.

    r_sat_eci_m, v_sat_eci_m_s: shape (n, 3), inertial, not parallel to each other.
    Source: CCSDS 500.0-G-4 (LVLH); NASA's use for the ISS.
    """
    return Rotation.from_matrix(c_lvlh_from_eci(r_sat_eci_m, v_sat_eci_m_s))


def c_lvlh_from_eci(r_sat_eci_m: Array, v_sat_eci_m_s: Array) -> Array:
    """The same as matrices, (n, 3, 3); from any axes in which position and inertial velocity are
    given."""
    z = -r_sat_eci_m / np.linalg.norm(r_sat_eci_m, axis=-1, keepdims=True)
    minus_h = cross(v_sat_eci_m_s, r_sat_eci_m)
    y = minus_h / np.linalg.norm(minus_h, axis=-1, keepdims=True)
    return np.stack([cross(y, z), y, z], axis=-2)
