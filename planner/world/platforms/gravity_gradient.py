"""The gravity gradient's torque on a body."""

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.world.frames.geodesy import MU_EARTH_M3_S2


def gradient_torque_body_n_m(
    q_body_from_eci: Rotation, r_sat_eci_m: Array, inertia_kg_m2: Array
) -> Array:
    """At n instants in body axes, (n, 3), of a point-like Earth.

    inertia_kg_m2: about the centre of mass, in body axes, (3, 3).
    Source: Hughes, Spacecraft Attitude Dynamics, 1986, section 8.1.
    """
    radius_m = np.linalg.norm(r_sat_eci_m, axis=1, keepdims=True)
    nadir_body = q_body_from_eci.apply(-r_sat_eci_m / radius_m)
    turning = np.cross(nadir_body, nadir_body @ inertia_kg_m2)
    return np.asarray(3.0 * MU_EARTH_M3_S2 / radius_m**3 * turning)
