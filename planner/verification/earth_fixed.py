"""Where does a target fixed to the Earth appear, and does the Earth or its horizon hide it?"""

from dataclasses import dataclass
from typing import TypeGuard

import erfa
import numpy as np
from numpy.typing import NDArray

from planner.frames.time_scales import Instants
from planner.orbits import OrbitStates
from planner.targets import EarthFixedTarget, GroundTarget
from planner.verification.earth import earth_orientation

WGS84 = 1  # ERFA's number for the ellipsoid
WGS84_A_M = 6378137.0
WGS84_A_OVER_B = 1.0 / (1.0 - 1.0 / 298.257223563)
SPEED_OF_LIGHT_M_S = 299792458.0  # exact, BIPM


@dataclass(frozen=True, eq=False)
class EarthFixedSight:
    """A target seen from the carrier at n instants.

    apparent_eci, up_eci: unit vectors, shape (n, 3), up being the target's vertical.
    range_m, elevation_rad: shape (n,), geometric, both ends at the same instant.
    hidden: shape (n,), whether the ellipsoid stands in between.
    """

    apparent_eci: NDArray[np.float64]
    up_eci: NDArray[np.float64]
    range_m: NDArray[np.float64]
    elevation_rad: NDArray[np.float64]
    hidden: NDArray[np.bool_]


def is_earth_fixed(target: object) -> TypeGuard[EarthFixedTarget]:
    """Whether the judge can tell by itself where the target appears."""
    return isinstance(target, EarthFixedTarget)


def earth_fixed_sight(
    target: EarthFixedTarget, instants: Instants, states: OrbitStates
) -> EarthFixedSight:
    """Light leaves the target at t - range/c and meets the carrier at t.

    Neglects refraction (8 m across the line of sight at 30 deg elevation).
    """
    earth = earth_orientation(instants.epoch_utc, instants.t_s)
    r_now_itrf_m = _r_target_itrf_m(target, instants)
    r_now_eci_m = earth.eci_from_itrf(r_now_itrf_m)
    to_sat_m = states.r_sat_eci_m - r_now_eci_m
    range_m = np.sqrt(np.sum(to_sat_m * to_sat_m, axis=1))

    # The range itself errs by the metre the target moves meanwhile: 2 um after this one step.
    light_s = range_m / SPEED_OF_LIGHT_M_S
    emitted = Instants(instants.epoch_utc, instants.t_s - light_s)
    r_then_eci_m = earth.eci_from_itrf(_r_target_itrf_m(target, emitted), before_s=light_s)
    to_target_m = r_then_eci_m - states.r_sat_eci_m
    incoming = to_target_m / np.sqrt(np.sum(to_target_m * to_target_m, axis=1, keepdims=True))

    up_eci = earth.eci_from_itrf(_up_itrf(r_now_itrf_m))
    r_sat_itrf_m = r_now_itrf_m + earth.itrf_from_eci(to_sat_m)
    return EarthFixedSight(
        apparent_eci=seen_in_motion(incoming, states.v_sat_eci_m_s),
        up_eci=up_eci,
        range_m=range_m,
        elevation_rad=np.arcsin(np.sum(to_sat_m * up_eci, axis=1) / range_m),
        hidden=hidden_by_earth(r_now_itrf_m, r_sat_itrf_m),
    )


def seen_in_motion(
    towards_source: NDArray[np.float64], v_observer_m_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Direction to the source in the rest frame of a moving observer, unit vectors (n, 3).

    The photon's four-momentum is boosted: its energy and momentum along and across the motion.
    Source: Lorentz transformation, Jackson 1999, eq. 11.19.
    """
    beta = v_observer_m_s / SPEED_OF_LIGHT_M_S
    beta2 = np.sum(beta * beta, axis=1, keepdims=True)
    gamma = 1.0 / np.sqrt(1.0 - beta2)
    photon = -towards_source
    along = np.sum(photon * beta, axis=1, keepdims=True)
    boosted = photon + (gamma**2 / (gamma + 1.0) * along - gamma) * beta
    return np.asarray(-boosted / np.sqrt(np.sum(boosted * boosted, axis=1, keepdims=True)))


def hidden_by_earth(
    r_target_itrf_m: NDArray[np.float64], r_sat_itrf_m: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Whether the straight line between them enters the ellipsoid, shape (n,).

    Stretched along the axis the ellipsoid becomes a sphere and lines stay lines.  For a target
    below the ellipsoid (the Dead Sea) the surface passes through the target.
    """
    stretch = np.array([1.0, 1.0, WGS84_A_OVER_B])
    target, sat = r_target_itrf_m * stretch, r_sat_itrf_m * stretch
    line = sat - target
    at_lowest = -np.sum(target * line, axis=1) / np.sum(line * line, axis=1)
    lowest = target + np.clip(at_lowest, 0.0, 1.0)[:, None] * line
    surface_m = np.minimum(WGS84_A_M, np.linalg.norm(target, axis=1))
    grazing_m = 1e-3  # a millimetre: rounding of 6e6 m is a millionth of it
    return np.asarray(np.linalg.norm(lowest, axis=1) < surface_m - grazing_m)


def _r_target_itrf_m(target: EarthFixedTarget, instants: Instants) -> NDArray[np.float64]:
    """Shape (n, 3): ground points by ERFA's geodesy, other modes as they say themselves."""
    if isinstance(target, GroundTarget):
        longitude_rad, latitude_rad = np.deg2rad([target.longitude_deg, target.latitude_deg])
        r_itrf_m = erfa.gd2gc(WGS84, longitude_rad, latitude_rad, target.height_m)
        return np.broadcast_to(r_itrf_m, (len(instants.t_s), 3))
    return target.r_target_itrf_m(instants)


def _up_itrf(r_itrf_m: NDArray[np.float64]) -> NDArray[np.float64]:
    longitude_rad, latitude_rad, _ = erfa.gc2gd(WGS84, r_itrf_m)
    return np.asarray(erfa.s2c(longitude_rad, latitude_rad))
