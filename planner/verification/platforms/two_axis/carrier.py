"""Directions fixed to the platform, in inertial space.

Derived again from the orbit's states by the definitions of the attitude laws, as plain
vectors and matrices.
"""

import numpy as np

from planner.base.arrays import Array
from planner.verification.clock import elapsed_us
from planner.verification.directions import eci_from_lvlh, rotation_matrix
from planner.world.attitude import AttitudeLaw
from planner.world.attitude.inertial import InertialAttitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import TwoAxisPlatform

DERIVED_LAWS = (LvlhAttitude, InertialAttitude)  # any other law's rotations are taken as given


def boresight_platform(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """Unit vectors, shape (n, 3), for angles of shape (n, 2), outer axis first.

    Source: Sumarokov 2016, eq. 11, by Rodrigues' formula: the inner axis turns first, carried
    by the outer one.
    """
    carried = _turn(
        np.asarray(platform.zero_direction_platform),
        np.asarray(platform.inner_axis_platform),
        angle_rad[:, 1],
    )
    boresight = _turn(carried, np.asarray(platform.outer_axis_platform), angle_rad[:, 0])
    return np.asarray(boresight / np.linalg.norm(boresight, axis=1, keepdims=True))


def eci_from_platform(
    vector_platform: Array,
    platform: TwoAxisPlatform,
    attitude: AttitudeLaw,
    instants: Instants,
    states: OrbitStates,
) -> Array:
    """Vectors fixed to the platform, shape (n, 3), in ECI at the n instants."""
    c_platform_from_body = rotation_matrix(platform.q_platform_from_body_xyzw)
    vector_body = vector_platform @ c_platform_from_body  # rows times C: C transposed, applied
    if isinstance(attitude, DERIVED_LAWS) and attitude.corrections:
        vector_body = _turn_back(vector_body, attitude.turn_rad(instants))
    if isinstance(attitude, LvlhAttitude):
        return eci_from_lvlh(vector_body @ _c_body_from_lvlh(attitude), states)
    if isinstance(attitude, InertialAttitude):
        return _eci_from_spinning(vector_body, attitude, instants)
    return np.asarray(attitude.q_body_from_eci(instants, states).inv().apply(vector_body))


def _turn(v: Array, axis: Array, angle_rad: Array) -> Array:
    """Vectors v, (3,) or (n, 3), turned about one axis by n angles.  Source: Rodrigues 1840."""
    unit = axis / np.linalg.norm(axis)
    cos, sin = np.cos(angle_rad)[:, None], np.sin(angle_rad)[:, None]
    along = (v @ unit)[..., None] * unit
    return np.asarray(along + cos * (v - along) + sin * np.cross(unit, v))


def _turn_back(v: Array, turn_rad: Array) -> Array:
    """Vectors (n, 3) in axes that n rotation vectors (n, 3) turn, in the axes before.

    Source: Rodrigues 1840.
    """
    angle_rad = np.sqrt(np.sum(turn_rad**2, axis=1, keepdims=True))
    unit = turn_rad / np.where(angle_rad > 0.0, angle_rad, 1.0)
    along = np.sum(v * unit, axis=1, keepdims=True) * unit
    turned = along + np.cos(angle_rad) * (v - along) - np.sin(angle_rad) * np.cross(unit, v)
    return np.asarray(turned)


def _c_body_from_lvlh(attitude: LvlhAttitude) -> Array:
    """Yaw, pitch, roll in that order (3-2-1).  Source: Wertz 1978, table E-1."""
    yaw, pitch, roll = np.deg2rad([attitude.yaw_deg, attitude.pitch_deg, attitude.roll_deg])
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    return np.array(
        [
            [cp * cy, cp * sy, -sp],
            [sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp],
            [cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp],
        ]
    )


def _eci_from_spinning(vector_body: Array, attitude: InertialAttitude, instants: Instants) -> Array:
    """The body turns about an axis fixed both in itself and in inertial space."""
    rate_rad_s = np.deg2rad(attitude.omega_body_deg_s)
    speed_rad_s = float(np.linalg.norm(rate_rad_s))
    if speed_rad_s > 0.0:
        since_s = instants.t_s + elapsed_us(instants.epoch_utc, attitude.epoch) / 1e6
        vector_body = _turn(vector_body, rate_rad_s, speed_rad_s * since_s)
    return np.asarray(vector_body @ rotation_matrix(attitude.q_body_from_eci_xyzw))
