"""The bending of light from a star or planet by the Sun, Jupiter, Saturn and the Earth."""

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.world.frames.solar_system import r_body_bary_m
from planner.world.frames.time_scales import Instants
from planner.world.targets.apparent import SPEED_OF_LIGHT_M_S

AU_M = 149597870700.0  # exact, IAU 2012 resolution B2

# Mass in solar masses (IAU 1976 system of masses, USNO Circular 179, table 2), and ERFA's
# limiter, half the square of an angle within which the source would be behind the body.
_SOLAR_MASSES = {
    "sun": (1.0, 6e-6),
    "jupiter": (1 / 1047.3486, 3e-9),
    "saturn": (1 / 3497.898, 3e-10),
}
_EARTH_SOLAR_MASSES = 1.0 / 332946.050895
_EARTH_LIMITER = 0.5  # of 1 rad: the limb stands 70 deg from nadir, so nothing visible is touched


def deflect(
    direction: Array,
    range_m: Array,
    instants: Instants,
    r_observer_bary_m: Array,
    r_sat_eci_m: Array,
    source: str | None,
) -> Array:
    """Directions in which the light arrives, unit vectors (n, 3) in and out, GCRF axes.

    range_m: infinite for a star.  source: the body looked at, which doesn't bend its own
    light.  At most 1.75 arcsec at the Sun's limb, 17 mas at Jupiter's, 6 mas at Saturn's,
    0.3 mas at the Earth's.  Source: IERS Conventions 2010, 11.1, as ERFA's `ld`.
    """
    for body, (mass, limiter) in _SOLAR_MASSES.items():
        if body == source:
            continue
        now_m = r_body_bary_m(body, instants) - r_observer_bary_m
        # The light passed the body about when the body's own light left it.
        earlier_s = np.linalg.norm(now_m, axis=1) / SPEED_OF_LIGHT_M_S
        passed = Instants(instants.epoch_utc, instants.t_s - earlier_s)
        r_from_body_m = r_observer_bary_m - r_body_bary_m(body, passed)
        direction = _bend_light(direction, range_m, r_from_body_m, mass, limiter)
    return _bend_light(direction, range_m, r_sat_eci_m, _EARTH_SOLAR_MASSES, _EARTH_LIMITER)


def _bend_light(
    direction: Array, range_m: Array, r_from_body_m: Array, mass_ratio: float, limiter_rad2: float
) -> Array:
    """mass_ratio: of the body to the Sun.  limiter_rad2: ERFA's."""
    distance_m = np.linalg.norm(r_from_body_m, axis=1)
    source_from_body = direction + r_from_body_m / range_m[:, None]
    source_from_body /= np.linalg.norm(source_from_body, axis=1, keepdims=True)
    arriving = erfa.ld(
        mass_ratio,
        direction,
        source_from_body,
        r_from_body_m / distance_m[:, None],
        distance_m / AU_M,
        limiter_rad2,
    )
    return np.asarray(arriving / np.linalg.norm(arriving, axis=1, keepdims=True))
