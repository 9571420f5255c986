"""The apparent direction of a star, the Sun, the Moon or a planet, and its way from the limb."""

import gzip
import math
from bisect import bisect_left
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import erfa
import numpy as np
from numpy.polynomial.chebyshev import chebval

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.verification.air import TOP_M, limb_bending_rad
from planner.verification.clock import DAY_S, tt_s
from planner.verification.earth import earth_orientation, interpolate_evenly
from planner.verification.earth_fixed import WGS84_A_M, WGS84_A_OVER_B, vertical
from planner.verification.light import SPEED_OF_LIGHT_M_S, aberrate, bend_by_sun
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import BodyTarget, SkyTarget, StarTarget

# Angular distance of a line of sight from the Earth's limb, and its height above the ground.


def limb_clearance_rad(sight_itrf: Array, r_sat_itrf_m: Array, raised_m: float) -> Array:
    """From the raised ellipsoid's limb to the line of sight, away from nadir, shape (n,).

    sight_itrf: unit vectors (n, 3).  The ellipsoid has both semi-axes longer by raised_m;
    angles lie in the plane of sight and geocentre, where the tangents d to the ellipsoid
    x M x = 1 obey (d M r)^2 = (d M d)(r M r - 1): a quadratic for the tangent's nadir angle.
    A carrier inside the raised ellipsoid has its limb at the zenith.
    """
    semi_axes_m = WGS84_A_M * np.array([1.0, 1.0, 1.0 / WGS84_A_OVER_B]) + raised_m
    r = r_sat_itrf_m / semi_axes_m
    down_itrf = -r_sat_itrf_m / _length(r_sat_itrf_m)
    from_nadir_rad, aside_itrf = _nadir_angle(sight_itrf, down_itrf)
    down, aside = down_itrf / semi_axes_m, aside_itrf / semi_axes_m

    above = np.sum(r * r, axis=1) - 1.0
    down_r, aside_r = np.sum(down * r, axis=1), np.sum(aside * r, axis=1)
    a = aside_r**2 - above * np.sum(aside * aside, axis=1)
    b = aside_r * down_r - above * np.sum(aside * down, axis=1)
    c = down_r**2 - above * np.sum(down * down, axis=1)
    # a < 0 < c outside: one tangent on either side of nadir; this side's has a positive root.
    outside = above > 0.0
    root = np.sqrt(np.where(outside, b * b - a * c, 0.0))
    limb_rad = np.where(outside, np.arctan2(b + root, -a), np.pi)
    return np.asarray(from_nadir_rad - limb_rad)


def lowest_point(sight_itrf: Array, r_sat_itrf_m: Array) -> tuple[Array, Array, Array]:
    """Of straight lines: height above the ellipsoid, way to it (n,), and the vertical there (n, 3).

    The way is negative where the line only climbs.  Within 1 m below 200 km.
    """
    way_m = -np.sum(sight_itrf * r_sat_itrf_m, axis=1)
    # Nearest to the geocentre, then to the ellipsoid: the height curves like 1/(Earth's radius).
    up_itrf, _ = vertical(r_sat_itrf_m + way_m[:, None] * sight_itrf)
    way_m = way_m - np.sum(up_itrf * sight_itrf, axis=1) * WGS84_A_M
    up_itrf, height_m = vertical(r_sat_itrf_m + way_m[:, None] * sight_itrf)
    return height_m, way_m, up_itrf


def _nadir_angle(sight_itrf: Array, down_itrf: Array) -> tuple[Array, Array]:
    """Angle from nadir (n,) and the unit vector (n, 3) across nadir on the sight's side."""
    along = np.sum(sight_itrf * down_itrf, axis=1)
    aside = sight_itrf - along[:, None] * down_itrf
    size = _length(aside)
    # Straight up or down any side is as good as another.
    other_axis = np.where(np.abs(down_itrf[:, :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    any_side = np.cross(down_itrf, other_axis)
    across = np.where(size > 1e-12, aside / np.maximum(size, 1e-12), any_side / _length(any_side))
    return np.arctan2(size[:, 0], along), across


def _length(v: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(v * v, axis=1, keepdims=True)))


# The Earth, the Sun, the Moon and the planets, by the judge's own reading of DE421.
#
# The file's bytes are taken apart here; the Earth's velocity is another theory's, ERFA's.
# Source: NAIF, DAF and SPK Required Reading (segments of data type 2).

BARYCENTRE = 0
SUN, MOON, EARTH = 10, 301, 399
# NAIF numbers; of the giants, what DE421 has: the centre of mass with their moons.
NUMBERS = {
    "sun": SUN,
    "moon": MOON,
    "mercury": 199,
    "venus": 299,
    "mars": 499,
    "jupiter": 5,
    "saturn": 6,
    "uranus": 7,
    "neptune": 8,
}

_J2000_JD = 2451545.0
_AU_PER_DAY_M_S = erfa.DAU / DAY_S
_NODE_SPACING_MAX_S = 3600.0  # a cubic through the Moon's pull on the Earth: < 1e-8 m/s
_NODES_MIN = 4

_DE421 = Path(__file__).parent / "data" / "de421.bsp"
_WORDS_PER_RECORD = 128
_SUMMARY_WORDS = 5  # two doubles and six 4-byte integers


@dataclass(frozen=True, eq=False)
class _Segment:
    """Chebyshev records of one body about another: words 0, 1 hold middle and half length (s)."""

    center: int
    first_s: float
    record_s: float
    coefficients: Array  # (k, 2 + 3 times as many as there are, km)

    def position_m(self, tdb_s: Array) -> Array:
        number = np.floor((tdb_s - self.first_s) / self.record_s).astype(np.intp)
        if number.min() < 0 or number.max() >= len(self.coefficients):
            raise OutsideCoverage(
                "Sun, Moon and planets are known from 1973-01-01 to 2053-10-09 (DE421); "
                "use times in between"
            )
        position_m = np.empty((len(tdb_s), 3))
        for one in np.unique(number):
            here = number == one
            middle_s, half_s = self.coefficients[one, :2]
            of_xyz = self.coefficients[one, 2:].reshape(3, -1).T
            position_m[here] = 1e3 * chebval((tdb_s[here] - middle_s) / half_s, of_xyz).T
        return position_m


def tdb_s(tt_s: Array) -> Array:
    """TDB from TT, both seconds since J2000, shape (n,).

    Within 10 us.  Source: USNO Circular 179, eq. 2.6, its leading term.
    """
    centuries = tt_s / (DAY_S * 36525.0)
    return np.asarray(tt_s + 0.001657 * np.sin(628.3076 * centuries + 6.2401))


def r_body_bary_m(number: int, at_tdb_s: Array) -> Array:
    """A body by its NAIF number from the solar system's barycentre, shape (n, 3), GCRF axes."""
    position_m = np.zeros((len(at_tdb_s), 3))
    while number != BARYCENTRE:
        segment = _segments()[number]
        position_m += segment.position_m(at_tdb_s)
        number = segment.center
    return position_m


def v_earth_bary_m_s(at_tdb_s: Array) -> Array:
    """The Earth's centre, shape (n, 3), GCRF axes, instants in order of time.

    Within 5 mm/s, 3e-6 arcsec of aberration.  Source: ERFA's epv00 (VSOP2000, ELP).
    """
    span_s = float(at_tdb_s[-1] - at_tdb_s[0])
    count = max(_NODES_MIN, int(np.ceil(span_s / _NODE_SPACING_MAX_S)) + 1)
    node_s = np.linspace(at_tdb_s[0], at_tdb_s[-1], count)
    _, barycentric = erfa.epv00(_J2000_JD, node_s / DAY_S)
    return interpolate_evenly(node_s, barycentric["v"] * _AU_PER_DAY_M_S, at_tdb_s)


@cache
def _segments() -> dict[int, _Segment]:
    """By the number of the body; each body has one segment in DE421."""
    words = np.memmap(_DE421, dtype="<f8", mode="r")
    header = words[:_WORDS_PER_RECORD].tobytes()
    integers = np.frombuffer(header, dtype="<i4")
    if header[:7] != b"DAF/SPK" or tuple(integers[2:4]) != (2, 6):
        raise ValueError("de421.bsp is no little-endian SPK file")
    segments: dict[int, _Segment] = {}
    record = int(integers[19])  # FWARD, the first record of summaries
    while record:
        page = words[(record - 1) * _WORDS_PER_RECORD :][:_WORDS_PER_RECORD]
        for k in range(int(page[2])):
            summary = page[3 + k * _SUMMARY_WORDS :][:_SUMMARY_WORDS]
            body, center, _, kind, first, last = summary[2:].view("<i4").tolist()
            if kind == 2:
                segment = words[first - 1 : last]
                first_s, record_s, size, count = segment[-4:].tolist()
                records = segment[: int(size) * int(count)].reshape(int(count), int(size))
                segments[body] = _Segment(center, first_s, record_s, records)
        record = int(page[0])
    return segments


# The direction of a star, seen from a place in the solar system.

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
def _catalogue_lines() -> bytes:
    return gzip.decompress(_CATALOGUE.read_bytes())


@cache
def _hipparcos(number: int) -> _Star:
    """A line of the catalogue: number, RA and Dec in rad, parallax and motions in mas.

    A negative parallax is the noise of a star too far to tell.
    """
    lines = _catalogue_lines()

    def line(at: int) -> bytes:
        return lines[at * _LINE_BYTES : (at + 1) * _LINE_BYTES]

    count = len(lines) // _LINE_BYTES
    fields = line(bisect_left(range(count), number, key=lambda at: int(line(at)[:6]))).split()
    if int(fields[0]) != number:
        raise KeyError(number)
    ra_rad, dec_rad, parallax_mas, pm_east, pm_north = map(float, fields[1:])
    return _Star(_HIPPARCOS_JYEAR, ra_rad, dec_rad, max(0.0, parallax_mas), pm_east, pm_north)


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
class SkySight:
    """A target seen from the carrier at n instants.

    apparent_eci: unit vectors, shape (n, 3).  range_m: (n,), infinite for a star.
    clearance_rad: (n,), from the limb of the ellipsoid raised by the grazing altitude.
    bending_rad: (n,), how far the air lifts the target; 0 when refraction isn't asked for.
    """

    apparent_eci: Array
    range_m: Array
    clearance_rad: Array
    bending_rad: Array


def sky_sight(target: SkyTarget, instants: Instants, states: OrbitStates) -> SkySight:
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
    return SkySight(
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
