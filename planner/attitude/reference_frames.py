"""Attitudes against other frames, turned into attitudes against ECI."""

import numpy as np
from scipy.spatial.transform import Rotation

from planner.frames.earth_orientation import C_GCRF_FROM_EME2000, c_itrf_from_eci
from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants
from planner.orbits import OrbitStates

LOCAL_ORBITAL = ("LVLH", "RTN")

# Radial is -Z of LVLH, along-track +X, and the orbit's normal -Y.
_Q_RTN_FROM_LVLH = Rotation.from_matrix([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def q_frame_from_eci(frame: str, instants: Instants, states: OrbitStates) -> Rotation:
    """n rotations to the axes of one of `planner.messages.aem.FRAMES`.

    `states` is the orbit at the same n instants; only the local orbital frames need it.
    """
    if frame == "ITRF":
        return Rotation.from_matrix(c_itrf_from_eci(instants))
    if frame in LOCAL_ORBITAL:
        q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
        return q_frame_from_lvlh(frame) * q_lvlh
    c_frame_from_eci = C_GCRF_FROM_EME2000.T if frame == "EME2000" else np.eye(3)
    return Rotation.from_matrix(np.broadcast_to(c_frame_from_eci, (len(instants), 3, 3)))


def q_frame_from_lvlh(frame: str) -> Rotation:
    """The constant rotation from LVLH to one of LOCAL_ORBITAL."""
    return _Q_RTN_FROM_LVLH if frame == "RTN" else Rotation.identity()
