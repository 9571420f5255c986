"""What attitude scans a stretch of ground?  The one primitive of every imaging mode.

A ground arc P0 -> P1 is scanned in a given time.  The optical axis (-Y) points at the moving
point, X lies along its motion over the Earth's surface as seen across the line of sight, so
that the image runs along the detector's columns: yaw steering against Earth rotation and any
azimuth follow by themselves.
"""

from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.polynomial import chebyshev
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.frames.earth_orientation import c_itrf_from_eci
from planner.frames.geodesy import WGS84_A_M, WGS84_F, up_itrf
from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants
from planner.orbits import Ephemeris
from planner.spacecraft.mrp import BodyMotion, body_motion

DEGREE = 28  # of the Chebyshev fit: attitudes of a 200 s span to 1e-12 rad
# X along flight, Y up, Z = X x Y, in LVLH axes (X forward, Y against the orbit normal, Z nadir).
_ORBITAL_FROM_LVLH = Rotation.from_matrix([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True, kw_only=True)
class GroundArc:
    """From P0 to P1 along the ellipsoid's section through its centre (geodetic, rad, m).

    start_s: seconds since the session's epoch when P0 is under the slit.  backwards: the
    detector runs in its other sense (X against the motion).
    The speed over ground is even to 0.03 % (500 km) and better for shorter arcs.
    """

    latitude_rad: tuple[float, float]
    longitude_rad: tuple[float, float]
    height_m: float
    start_s: float
    duration_s: float
    backwards: bool = False

    def length_m(self) -> float:
        """Along the ground from P0 to P1."""
        r, _ = self.point_itrf(np.linspace(0.0, 1.0, 65))
        return float(np.sum(np.linalg.norm(np.diff(r, axis=0), axis=1)))

    def point_itrf(self, share: Array) -> tuple[Array, Array]:
        """Position (m) and its derivative by the share of the arc, ITRF, (n, 3) each.

        Shares outside 0..1 continue the arc: where a turn joins and leaves it.
        """
        flat = np.array([1.0, 1.0, 1.0 / (1.0 - WGS84_F) ** 2]) / WGS84_A_M**2
        up = up_itrf(np.array(self.latitude_rad), np.array(self.longitude_rad))
        ends = up / flat
        ends /= np.linalg.norm(ends, axis=1, keepdims=True)
        angle = 2.0 * np.arcsin(0.5 * np.linalg.norm(ends[1] - ends[0]))
        u = np.asarray(share)[:, None]
        d = (np.sin((1.0 - u) * angle) * ends[0] + np.sin(u * angle) * ends[1]) / np.sin(angle)
        d1 = (
            angle
            * (np.cos(u * angle) * ends[1] - np.cos((1.0 - u) * angle) * ends[0])
            / np.sin(angle)
        )
        q = np.sum(flat * d * d, axis=1, keepdims=True)
        q1 = np.sum(flat * d * d1, axis=1, keepdims=True)
        normal = flat * d
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal, normal1 = normal / length, flat * d1 / length
        normal1 = normal1 - normal * np.sum(normal * normal1, axis=1, keepdims=True)
        return (
            d / np.sqrt(q) + self.height_m * normal,
            d1 / np.sqrt(q) - d * q1 / q**1.5 + self.height_m * normal1,
        )


@dataclass(frozen=True, eq=False)
class Profile:
    """An attitude for every instant from start_s to stop_s, as a Chebyshev series of sigma."""

    middle: Rotation
    start_s: float
    stop_s: float
    coefficients: Array

    def at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        """eci_from_body and body rates, analytic derivatives of the series, at (m,) instants."""
        half = 0.5 * (self.stop_s - self.start_s)
        x = (np.asarray(t_s) - self.start_s) / half - 1.0
        curve = [
            np.asarray(
                chebyshev.chebval(x, chebyshev.chebder(self.coefficients, d)).T / half**d,
                dtype=np.float64,
            )
            for d in range(4)
        ]
        return self.middle * Rotation.from_mrp(curve[0]), body_motion(*curve)


def arc_attitude(
    arc: GroundArc, share: Array, ephemeris: Ephemeris, instants: Instants
) -> Rotation:
    """eci_from_body with the arc's point at `share` (n,) under the slit at n instants.

    Geometric: light time and aberration shift the image by 16 m along the track, alike for
    every point, and refraction by less than 5 m at 45 deg; both are left out.
    """
    r_sat_eci_m = ephemeris.states(instants).r_sat_eci_m
    c = c_itrf_from_eci(instants)
    r_itrf_m, motion_itrf = arc.point_itrf(share)
    r_eci_m = np.einsum("nji,nj->ni", c, r_itrf_m)
    motion_eci = np.einsum("nji,nj->ni", c, motion_itrf)
    y = r_sat_eci_m - r_eci_m
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    x = motion_eci - y * np.sum(motion_eci * y, axis=1, keepdims=True)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    if arc.backwards:
        x = -x
    return Rotation.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1))


def orbital_attitude(ephemeris: Ephemeris, instants: Instants) -> Rotation:
    """eci_from_body with X along flight and Y up, no tilt."""
    states = ephemeris.states(instants)
    lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    return (_ORBITAL_FROM_LVLH * lvlh).inv()


def fitted_profile(
    arc: GroundArc | None, ephemeris: Ephemeris, epoch_utc: datetime, span_s: tuple[float, float]
) -> Profile:
    """The attitude of an arc (None: orbital orientation) over a span, made differentiable."""
    start_s, stop_s = span_s
    x = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    t_s = start_s + (x + 1.0) * 0.5 * (stop_s - start_s)
    instants = Instants(epoch_utc, t_s)
    if arc is None:
        attitude = orbital_attitude(ephemeris, instants)
    else:
        attitude = arc_attitude(arc, (t_s - arc.start_s) / arc.duration_s, ephemeris, instants)
    middle = attitude[DEGREE // 2]
    sigma = (middle.inv() * attitude).as_mrp()
    basis = chebyshev.chebvander(x, DEGREE)
    scale = np.full(DEGREE + 1, 2.0 / (DEGREE + 1))
    scale[0] /= 2.0
    return Profile(middle, start_s, stop_s, scale[:, None] * (basis.T @ sigma))


def look_angles(
    r_target_itrf_m: Array, ephemeris: Ephemeris, instants: Instants
) -> tuple[Array, Array]:
    """Angles of the direction to ITRF points (n, 3) along and across the track, rad, (n,) each.

    along: positive ahead; across: positive to the right of flight, both from geocentric
    nadir in LVLH (atan2 of the component and the downward one).
    """
    states = ephemeris.states(instants)
    r_eci_m = np.einsum("nji,nj->ni", c_itrf_from_eci(instants), r_target_itrf_m)
    lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    los = lvlh.apply(r_eci_m - states.r_sat_eci_m)
    return np.arctan2(los[:, 0], los[:, 2]), np.arctan2(los[:, 1], los[:, 2])
