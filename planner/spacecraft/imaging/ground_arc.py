"""Ground arcs and the attitudes that scan them: the one primitive of every imaging mode.

A ground arc P0 -> P1 is scanned in a given time.  The optical axis (-Y) points at the moving
point, X lies along its motion over the Earth's surface as seen across the line of sight, so
that the image runs along the detector's columns: yaw steering against Earth rotation and any
azimuth follow by themselves.
"""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.spacecraft.table import TICK_S
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.targets.plane_arc import PlaneArc

# In orbital orientation: X along flight, Y up, Z = X x Y, in LVLH axes (X forward, Y against the
# orbit normal, Z nadir).
_Q_BODY_FROM_LVLH = Rotation.from_matrix([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class GroundArc(PlaneArc):
    """An arc over the ground, scanned from `start_s` on.

    start_s: seconds since the session's epoch when P0 is under the slit.  backwards: the
    detector runs in its other sense (X against the motion).
    """

    start_s: float
    duration_s: float
    backwards: bool = False

    @property
    def ticks(self) -> int:
        """Whole ticks that cover its scan."""
        return math.ceil(self.duration_s / TICK_S - 1e-6)


def scan_q_body_from_eci(
    arc: GroundArc, share: Array, ephemeris: Ephemeris, instants: Instants
) -> Rotation:
    """Attitudes with the arc's point at `share` (n,) under the slit at n instants.

    Geometric: light time and aberration shift the image by 16 m along the track, alike for
    every point, and refraction by less than 5 m at 45 deg; both are left out.
    """
    r_sat_eci_m = ephemeris.states(instants).r_sat_eci_m
    c_itrf = c_itrf_from_eci(instants)
    r_point_itrf_m, motion_itrf = arc.point_itrf(share)
    r_point_eci_m = np.einsum("nji,nj->ni", c_itrf, r_point_itrf_m)
    motion_eci = np.einsum("nji,nj->ni", c_itrf, motion_itrf)
    y_eci = r_sat_eci_m - r_point_eci_m
    y_eci /= np.linalg.norm(y_eci, axis=1, keepdims=True)
    x_eci = motion_eci - y_eci * np.sum(motion_eci * y_eci, axis=1, keepdims=True)
    x_eci /= np.linalg.norm(x_eci, axis=1, keepdims=True)
    if arc.backwards:
        x_eci = -x_eci
    c_eci_from_body = np.stack([x_eci, y_eci, np.cross(x_eci, y_eci)], axis=-1)
    return Rotation.from_matrix(c_eci_from_body).inv()


def orbital_q_body_from_eci(ephemeris: Ephemeris, instants: Instants) -> Rotation:
    """Attitudes with X along flight and Y up, no tilt."""
    states = ephemeris.states(instants)
    return _Q_BODY_FROM_LVLH * q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
