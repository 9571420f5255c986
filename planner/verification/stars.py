"""The direction of a star, seen from a place in the solar system."""

import gzip
import math
from bisect import bisect_left
from functools import cache
from pathlib import Path
from typing import NamedTuple

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.world.targets import StarTarget

_CATALOGUE = Path(__file__).parent / "data" / "hipparcos.txt.gz"
_LINE_BYTES = 60  # sorted by number
_J2000_JYEAR = 2000.0
_HIPPARCOS_JYEAR = 1991.25
_YEAR_S = 365.25 * 86400.0
_MAS_RAD = float(erfa.DMAS2R)


class _Star(NamedTuple):
    """ICRS at an epoch, and its motion, in the order of the catalogue."""

    jyear: float
    ra_rad: float
    dec_rad: float
    parallax_mas: float
    pm_east_mas_yr: float
    pm_north_mas_yr: float


def towards_star(target: StarTarget, at_tdb_s: Array, r_observer_bary_m: Array) -> Array:
    """Unit vectors (n, 3), GCRF axes, at instants counted from J2000; parallax included.

    The star goes on along its great circle: after t years at an angle whose tangent is
    mu t / (1 + t v/d), mu its proper motion, v/d its recession by its distance.
    Neglects that its light reaches the observer up to 500 s earlier or later than the Sun:
    0.2 mas at 10 arcsec a year.  Source: ESA SP-1200 (1997), vol. 1, 1.5.5, rewritten.
    """
    number = target.catalogue_number
    star = _from_coordinates(target) if number is None else _hipparcos(number)
    towards = erfa.s2c(star.ra_rad, star.dec_rad)
    east = np.array([-np.sin(star.ra_rad), np.cos(star.ra_rad), 0.0])
    east_yr, north_yr = star.pm_east_mas_yr * _MAS_RAD, star.pm_north_mas_yr * _MAS_RAD
    motion_yr = east_yr * east + north_yr * np.cross(towards, east)
    mu_yr = np.sqrt(motion_yr @ motion_yr)
    first_parallax_rad = star.parallax_mas * _MAS_RAD
    receding_yr = target.radial_velocity_km_s * 1e3 * first_parallax_rad / erfa.DAU * _YEAR_S

    since_yr = at_tdb_s / _YEAR_S + (_J2000_JYEAR - star.jyear)
    across, along = mu_yr * since_yr, 1.0 + receding_yr * since_yr
    gone_rad = np.arctan2(across, along)[:, None]
    parallax_rad = first_parallax_rad / np.hypot(across, along)[:, None]
    ahead = motion_yr / mu_yr if mu_yr > 0.0 else east
    from_sun = np.cos(gone_rad) * towards + np.sin(gone_rad) * ahead
    seen = from_sun - parallax_rad / erfa.DAU * r_observer_bary_m
    return np.asarray(seen / np.sqrt(np.sum(seen * seen, axis=1, keepdims=True)))


def _from_coordinates(target: StarTarget) -> _Star:
    if target.ra_deg is None or target.dec_deg is None:
        raise TypeError("a star without a catalogue number has coordinates")
    return _Star(
        target.epoch_jyear or _J2000_JYEAR,
        math.radians(target.ra_deg),
        math.radians(target.dec_deg),
        target.parallax_mas or 0.0,
        target.pm_ra_cosdec_mas_yr or 0.0,
        target.pm_dec_mas_yr or 0.0,
    )


@cache
def _hipparcos(number: int) -> _Star:
    """A line of the catalogue: number, RA and Dec in rad, parallax and motions in mas.

    A negative parallax is the noise of a star too far to tell.
    """
    lines = gzip.decompress(_CATALOGUE.read_bytes())

    def line(at: int) -> bytes:
        return lines[at * _LINE_BYTES : (at + 1) * _LINE_BYTES]

    count = len(lines) // _LINE_BYTES
    fields = line(bisect_left(range(count), number, key=lambda at: int(line(at)[:6]))).split()
    if int(fields[0]) != number:
        raise KeyError(number)
    ra_rad, dec_rad, parallax_mas, pm_east, pm_north = map(float, fields[1:])
    return _Star(_HIPPARCOS_JYEAR, ra_rad, dec_rad, max(0.0, parallax_mas), pm_east, pm_north)
