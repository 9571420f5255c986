"""The apparent direction of a target fixed to the Earth, and whether the Earth hides it."""

import math
from dataclasses import dataclass

import erfa
import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.verification.air import lift_to_ground_rad
from planner.verification.earth import earth_orientation
from planner.verification.light import SPEED_OF_LIGHT_M_S, aberrate
from planner.verification.terrain import WGS84, terrain_height_m
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import EarthFixedTarget, GroundTarget, PlaceTarget, StationTarget
from planner.world.targets.gazetteer import Place

WGS84_A_M = 6378137.0
WGS84_A_OVER_B = 1.0 / (1.0 - 1.0 / 298.257223563)

_LIFT_SPACING_S = 5.0  # a tenth of how fast a pass 400 km up changes: a cubic errs by 2e-7
_LIFTS_MIN = 4
# No ray leaves the ground lower than a degree; overhead the lift per sine is level.
_ZENITH_RANGE_RAD = (1e-5, math.radians(89.0))


@dataclass(frozen=True, eq=False)
class EarthFixedSight:
    """A target seen from the carrier at n instants.

    apparent_eci, up_eci: unit vectors, shape (n, 3), up being the target's vertical.
    to_sat_eci_m: from the target to the carrier, geometric, shape (n, 3).
    range_m, elevation_rad: shape (n,), geometric, both ends at the same instant.
    hidden: shape (n,), whether the ellipsoid stands in between.
    """

    apparent_eci: Array
    up_eci: Array
    to_sat_eci_m: Array
    range_m: Array
    elevation_rad: Array
    hidden: NDArray[np.bool_]


def earth_fixed_sight(
    target: EarthFixedTarget, instants: Instants, states: OrbitStates
) -> EarthFixedSight:
    """Light leaves the target at t - range/c and meets the carrier at t, unless it's geometric.

    Through the standard atmosphere where the target asks for it, its layers about the mean
    radius (the ellipsoid's own curvature changes 0.035 arcsec at 5 deg elevation, 0.001 at
    15); else refraction is left out (8 m across the line of sight at 30 deg).
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
    incoming_eci = to_target_m / np.sqrt(np.sum(to_target_m * to_target_m, axis=1, keepdims=True))

    up_itrf, height_m = vertical(r_now_itrf_m)
    up_eci = earth.eci_from_itrf(up_itrf)
    sine = np.sum(to_sat_m * up_eci, axis=1) / range_m
    elevation_rad = np.arcsin(np.clip(sine, -1.0, 1.0))  # overhead it may round to more than 1
    if target.refraction == "standard":
        incoming_eci = _lift(incoming_eci, up_eci, instants.t_s, elevation_rad, range_m, height_m)
    r_sat_itrf_m = r_now_itrf_m + earth.itrf_from_eci(to_sat_m)
    apparent_eci = aberrate(incoming_eci, states.v_sat_eci_m_s)
    if target.is_geometric:
        apparent_eci = -to_sat_m / range_m[:, None]
    return EarthFixedSight(
        apparent_eci=apparent_eci,
        up_eci=up_eci,
        to_sat_eci_m=to_sat_m,
        range_m=range_m,
        elevation_rad=elevation_rad,
        hidden=hidden_by_earth(r_now_itrf_m, r_sat_itrf_m),
    )


def hidden_by_earth(r_target_itrf_m: Array, r_sat_itrf_m: Array) -> NDArray[np.bool_]:
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


def _r_target_itrf_m(target: EarthFixedTarget, instants: Instants) -> Array:
    """Shape (n, 3): ground points by ERFA's geodesy, other modes as they say themselves."""
    point = target.place if isinstance(target, PlaceTarget) else target
    if isinstance(point, GroundTarget | Place | StationTarget):
        longitude_rad, latitude_rad = np.deg2rad([point.longitude_deg, point.latitude_deg])
        r_itrf_m = erfa.gd2gc(WGS84, longitude_rad, latitude_rad, _height_m(point))
        return np.broadcast_to(r_itrf_m, (len(instants.t_s), 3))
    return target.r_target_itrf_m(instants)


def _height_m(point: GroundTarget | Place | StationTarget) -> float:
    if isinstance(point, GroundTarget) and point.terrain is not None:
        place_deg = np.array([point.latitude_deg]), np.array([point.longitude_deg])
        return float(terrain_height_m(point.terrain, *place_deg)[0])
    return point.height_m or 0.0


def vertical(r_itrf_m: Array) -> tuple[Array, Array]:
    """Unit vectors up (n, 3) and heights (n,) above the ellipsoid."""
    longitude_rad, latitude_rad, height_m = erfa.gc2gd(WGS84, r_itrf_m)
    return np.asarray(erfa.s2c(longitude_rad, latitude_rad)), np.asarray(height_m)


def _lift(
    incoming_eci: Array,
    up_eci: Array,
    t_s: Array,
    elevation_rad: Array,
    range_m: Array,
    height_m: Array,
) -> Array:
    """Directions turned towards the target's vertical as the air does, unit vectors (n, 3).

    Per sine of the zenith angle, which stays smooth overhead, at instants some seconds apart.
    """
    count = len(elevation_rad)
    nodes = min(count, math.ceil((t_s[-1] - t_s[0]) / _LIFT_SPACING_S) + _LIFTS_MIN)
    node = np.unique(np.linspace(0, count - 1, nodes).astype(np.intp))
    zenith_rad = np.clip(np.pi / 2.0 - elevation_rad[node], *_ZENITH_RANGE_RAD)
    lift_rad = lift_to_ground_rad(zenith_rad, range_m[node], height_m[node])
    # SciPy's interpolators take 0.2 s to import, which only a plan should pay.
    from scipy.interpolate import CubicSpline

    per_sine = CubicSpline(t_s[node], lift_rad / np.sin(zenith_rad))(t_s)
    across = up_eci - np.sum(up_eci * incoming_eci, axis=1, keepdims=True) * incoming_eci
    turned = incoming_eci + per_sine[:, None] * across
    return np.asarray(turned / np.sqrt(np.sum(turned * turned, axis=1, keepdims=True)))
