"""The apparent direction of a star, the Sun, the Moon or a planet, and its way from the limb."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.verification.air import TOP_M, limb_bending_rad
from planner.verification.clock import tt_s
from planner.verification.earth import earth_orientation
from planner.verification.light import SPEED_OF_LIGHT_M_S, aberrate, bend_by_sun
from planner.verification.limb import limb_clearance_rad, lowest_point
from planner.verification.solar_system import (
    EARTH,
    NUMBERS,
    SUN,
    r_body_bary_m,
    tdb_s,
    v_earth_bary_m_s,
)
from planner.verification.stars import towards_star
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import BodyTarget, SkyTarget, StarTarget

# Two honest models of the standard air beyond the limb differ by this share of the bending: by
# its colour (1 % from 400 to 700 nm), by rounding the kinks between its layers (0.4 %), by
# bending in the plane of the geocentre instead of the ellipsoid's vertical (0.3 %).  The
# weather, which nobody plans for, makes 5 %.
LIMB_MODEL_SHARE = 0.01

_LIGHT_TIME_PASSES = 3  # each shrinks the error by v/c: 4 h, 2 s, 0.2 ms, 20 ns for Neptune
_DEEPEST_M = -60e3  # lines that pass lower stay behind the ground however much the air lifts them
_BENDING_PASSES = 40  # Newton climbs one scale height a pass, then converges
_BENT_RAD = 1e-10


@dataclass(frozen=True, eq=False)
class SkyDirection:
    """A target seen from the carrier at n instants.

    apparent_eci: unit vectors, shape (n, 3).  range_m: (n,), infinite for a star.
    clearance_rad: (n,), from the limb of the ellipsoid raised by the grazing altitude.
    bending_rad: (n,), how far the air lifts the target; 0 when refraction isn't asked for.
    """

    apparent_eci: Array
    range_m: Array
    clearance_rad: Array
    bending_rad: Array


def sky_sight(target: SkyTarget, instants: Instants, states: OrbitStates) -> SkyDirection:
    """Parallax, light time and the Sun's bending, then aberration by the Earth and the carrier.

    The limb and its air belong to the Earth's frame in between.  Of a mode it doesn't know
    the judge takes the astrometric direction as given.
    """
    at_s = tdb_s(tt_s(instants.epoch_utc, instants.t_s))
    r_observer_m = r_body_bary_m(EARTH, at_s) + states.r_sat_eci_m
    towards_eci, range_m = _astrometric(target, instants, at_s, r_observer_m)
    if target.body_seen() != "sun":
        towards_eci = bend_by_sun(towards_eci, range_m, r_observer_m - r_body_bary_m(SUN, at_s))
    geocentric_eci = aberrate(towards_eci, v_earth_bary_m_s(at_s))

    earth = earth_orientation(instants.epoch_utc, instants.t_s)
    sight_itrf = earth.itrf_from_eci(geocentric_eci)
    r_sat_itrf_m = earth.itrf_from_eci(states.r_sat_eci_m)
    bending_rad = np.zeros(len(at_s))
    if target.refraction == "standard":
        sight_itrf, bending_rad = _through_air(sight_itrf, r_sat_itrf_m)
        geocentric_eci = earth.eci_from_itrf(sight_itrf)
    return SkyDirection(
        apparent_eci=aberrate(geocentric_eci, states.v_sat_eci_m_s),
        range_m=range_m,
        clearance_rad=limb_clearance_rad(
            sight_itrf, r_sat_itrf_m, target.grazing_altitude_km * 1e3
        ),
        bending_rad=bending_rad,
    )


def _astrometric(
    target: SkyTarget, instants: Instants, at_s: Array, r_observer_m: Array
) -> tuple[Array, Array]:
    """Unit vectors (n, 3) towards where the light came from, and how far it came, (n,)."""
    if isinstance(target, StarTarget):
        return towards_star(target, at_s, r_observer_m), np.full(len(at_s), np.inf)
    if not isinstance(target, BodyTarget):
        return target.seen_from(instants, r_observer_m)
    body = NUMBERS[target.name.lower()]
    light_s = np.zeros(len(at_s))
    for _ in range(_LIGHT_TIME_PASSES):
        to_body_m = r_body_bary_m(body, at_s - light_s) - r_observer_m
        range_m = np.sqrt(np.sum(to_body_m * to_body_m, axis=1))
        light_s = range_m / SPEED_OF_LIGHT_M_S
    return to_body_m / range_m[:, None], range_m


def _through_air(sight_itrf: Array, r_sat_itrf_m: Array) -> tuple[Array, Array]:
    """The direction (n, 3) in which the bent ray arrives, and its bending (n,).

    The air lifts the source along the vertical of the point where the line is lowest, as it
    does a source at infinity; the Moon by 0.6 % less.
    """
    apparent_itrf, bending_rad = sight_itrf.copy(), np.zeros(len(sight_itrf))
    height_m, way_m, _ = lowest_point(sight_itrf, r_sat_itrf_m)
    low = np.flatnonzero((way_m > 0.0) & (height_m > _DEEPEST_M) & (height_m < TOP_M))
    if not len(low):
        return apparent_itrf, bending_rad
    true, r_sat_m, lift_rad = sight_itrf[low], r_sat_itrf_m[low], np.zeros(len(low))
    apparent = true
    for _ in range(_BENDING_PASSES):
        height_m, way_m, up = lowest_point(apparent, r_sat_m)
        bending, slope = limb_bending_rad(height_m)
        step_rad = (bending - lift_rad) / (1.0 - slope * way_m)
        lift_rad = lift_rad + step_rad
        across = up - np.sum(up * true, axis=1, keepdims=True) * true
        across /= np.sqrt(np.sum(across * across, axis=1, keepdims=True))
        apparent = np.cos(lift_rad)[:, None] * true + np.sin(lift_rad)[:, None] * across
        if np.max(np.abs(step_rad)) < _BENT_RAD:
            break
    apparent_itrf[low], bending_rad[low] = apparent, lift_rad
    return apparent_itrf, bending_rad
