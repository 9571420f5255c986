"""The Sun, the Moon and the planets: JPL's DE421, for the years that the product plans in.

Geometric positions in GCRF (= ICRF) axes; neither light time nor aberration.
"""

from functools import cache
from pathlib import Path

import numpy as np
from jplephem.exceptions import OutOfRangeError
from jplephem.spk import SPK

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import DAY_S, Instants

_DE421 = Path(__file__).parent / "data" / "de421.bsp"

_EARTH_MOON_BARYCENTER = 3
_SUN = 10
_MOON = 301
_EARTH = 399

# Which segments, NAIF numbers of centre and target, lead from the barycentre to the body.
_CHAINS = {
    "sun": ((0, _SUN),),
    "moon": ((0, _EARTH_MOON_BARYCENTER), (_EARTH_MOON_BARYCENTER, _MOON)),
    "mercury": ((0, 1), (1, 199)),
    "venus": ((0, 2), (2, 299)),
    "mars": ((0, 4), (4, 499)),
    "jupiter": ((0, 5),),
    "saturn": ((0, 6),),
    "uranus": ((0, 7),),
    "neptune": ((0, 8),),
}
BODIES = tuple(_CHAINS)


def r_sun_eci_m(instants: Instants) -> Array:
    """Sun from the Earth's centre, shape (n, 3)."""
    return (
        _position_m(0, _SUN, instants)
        - _position_m(0, _EARTH_MOON_BARYCENTER, instants)
        - _position_m(_EARTH_MOON_BARYCENTER, _EARTH, instants)
    )


def r_moon_eci_m(instants: Instants) -> Array:
    """Moon from the Earth's centre, shape (n, 3)."""
    return _position_m(_EARTH_MOON_BARYCENTER, _MOON, instants) - _position_m(
        _EARTH_MOON_BARYCENTER, _EARTH, instants
    )


def r_body_bary_m(body: str, instants: Instants) -> Array:
    """One of `BODIES` from the solar system's barycentre, shape (n, 3).

    From Jupiter on it is the barycentre of planet and moons, seen from the Earth at most
    0.08 arcsec (Jupiter), 0.06 (Saturn) and 0.005 (Uranus, Neptune) from the planet's centre.
    """
    return np.asarray(
        sum(_position_m(center, target, instants) for center, target in _CHAINS[body])
    )


def earth_bary_state(instants: Instants) -> tuple[Array, Array]:
    """The Earth's centre from the solar system's barycentre: m and m/s, each (n, 3)."""
    r_m, v_m_s = _state_m(0, _EARTH_MOON_BARYCENTER, instants)
    r_earth_m, v_earth_m_s = _state_m(_EARTH_MOON_BARYCENTER, _EARTH, instants)
    return r_m + r_earth_m, v_m_s + v_earth_m_s


def _position_m(center: int, target: int, instants: Instants) -> Array:
    """target from center, NAIF numbers, shape (n, 3).

    TT stands for TDB: 2 ms, in which the Sun moves 60 m and the Moon 2 m.
    """
    try:
        return np.asarray(_open_kernel()[center, target].compute(*instants.tt_jd()).T * 1e3)
    except OutOfRangeError:
        raise _outside_coverage() from None


def _state_m(center: int, target: int, instants: Instants) -> tuple[Array, Array]:
    """target from center, m and m/s, each (n, 3); TT stands for TDB."""
    try:
        r_km, v_km_day = _open_kernel()[center, target].compute_and_differentiate(*instants.tt_jd())
    except OutOfRangeError:
        raise _outside_coverage() from None
    return np.asarray(r_km.T * 1e3), np.asarray(v_km_day.T * (1e3 / DAY_S))


def _outside_coverage() -> OutsideCoverage:
    return OutsideCoverage(
        "Sun, Moon and planets are known from 1973-01-01 to 2053-10-09 (DE421); "
        "use times in between"
    )


@cache
def _open_kernel() -> SPK:
    return SPK.open(str(_DE421))
