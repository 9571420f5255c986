"""Where are the Sun, the Moon and the planets?  JPL's DE421, from a package.

Geometric geocentric positions in GCRF axes; neither light time nor aberration.
"""

from functools import cache
from importlib.resources import files

import numpy as np
from jplephem.exceptions import OutOfRangeError
from jplephem.spk import SPK
from numpy.typing import NDArray

from planner.errors import OutsideCoverage
from planner.frames.time_scales import Instants

_EARTH_MOON_BARYCENTER = 3
_SUN = 10
_MOON = 301
_EARTH = 399


def r_sun_eci_m(instants: Instants) -> NDArray[np.float64]:
    """Sun from the Earth's centre, shape (n, 3)."""
    return (
        _position_m(0, _SUN, instants)
        - _position_m(0, _EARTH_MOON_BARYCENTER, instants)
        - _position_m(_EARTH_MOON_BARYCENTER, _EARTH, instants)
    )


def r_moon_eci_m(instants: Instants) -> NDArray[np.float64]:
    """Moon from the Earth's centre, shape (n, 3)."""
    return _position_m(_EARTH_MOON_BARYCENTER, _MOON, instants) - _position_m(
        _EARTH_MOON_BARYCENTER, _EARTH, instants
    )


def _position_m(center: int, target: int, instants: Instants) -> NDArray[np.float64]:
    """target from center, NAIF numbers, shape (n, 3).

    TT stands for TDB: 2 ms, in which the Sun moves 60 m and the Moon 2 m.
    """
    try:
        return np.asarray(_kernel()[center, target].compute(*instants.tt_jd()).T * 1e3)
    except OutOfRangeError:
        raise OutsideCoverage(
            "Sun and Moon are known from 1899-07-29 to 2053-10-09 (DE421); use times in between"
        ) from None


@cache
def _kernel() -> SPK:
    # The package's own path function warns of its other file's age; only de421.bsp is wanted.
    return SPK.open(str(files("skyfield_data") / "data" / "de421.bsp"))
