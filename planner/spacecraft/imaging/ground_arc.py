"""Ground arcs and the attitudes that scan them: the one primitive of every imaging mode.

A ground arc P0 -> P1 is scanned in a given time.  The optical axis (-Y) points at the moving
point, X lies along its motion over the Earth's surface as seen across the line of sight, so
that the image runs along the detector's columns: yaw steering against Earth rotation and any
azimuth follow by themselves.
"""

import math
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.polynomial import chebyshev

from planner.base.arrays import Array
from planner.base.mrp import BodyMotion, MrpMotion, body_motion
from planner.base.rotation import Rotation
from planner.spacecraft.table import TICK_S
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.targets.plane_arc import PlaneArc

DEGREE = 28  # of the Chebyshev fit: attitudes of a 200 s span to 1e-12 rad
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


@dataclass(frozen=True, eq=False)
class ChebyshevProfile:
    """An attitude for every instant from start_s to stop_s.

    coefficients: of the series of sigma, the rotation of the body's axes since `middle`.
    """

    q_eci_from_middle: Rotation
    start_s: float
    stop_s: float
    coefficients: Array

    def attitude_at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        """q_body_from_eci and body rates, the series' own derivatives, at instants (m,)."""
        half_s = 0.5 * (self.stop_s - self.start_s)
        x = (np.asarray(t_s) - self.start_s) / half_s - 1.0
        motion = MrpMotion(
            *(
                np.asarray(
                    chebyshev.chebval(x, chebyshev.chebder(self.coefficients, d)).T / half_s**d,
                    dtype=np.float64,
                )
                for d in range(4)
            )
        )
        q_eci_from_body = self.q_eci_from_middle * Rotation.from_mrp(motion.mrp)
        return q_eci_from_body.inv(), body_motion(motion)


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


def fitted_profile(
    arc: GroundArc | None, ephemeris: Ephemeris, epoch_utc: datetime, span_s: tuple[float, float]
) -> ChebyshevProfile:
    """The attitude of an arc (None: orbital orientation) over a span, made differentiable."""
    start_s, stop_s = span_s
    x = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    t_s = start_s + (x + 1.0) * 0.5 * (stop_s - start_s)
    instants = Instants(epoch_utc, t_s)
    if arc is None:
        q_body_from_eci = orbital_q_body_from_eci(ephemeris, instants)
    else:
        share = (t_s - arc.start_s) / arc.duration_s
        q_body_from_eci = scan_q_body_from_eci(arc, share, ephemeris, instants)
    q_eci_from_body = q_body_from_eci.inv()
    q_eci_from_middle = q_eci_from_body[DEGREE // 2]
    sigma = np.asarray((q_eci_from_middle.inv() * q_eci_from_body).as_mrp())
    basis = chebyshev.chebvander(x, DEGREE)
    scale = np.full(DEGREE + 1, 2.0 / (DEGREE + 1))
    scale[0] /= 2.0
    return ChebyshevProfile(q_eci_from_middle, start_s, stop_s, scale[:, None] * (basis.T @ sigma))
