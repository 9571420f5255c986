"""The Earth, the Sun, the Moon and the planets, by the judge's own reading of DE421.

The file's bytes are taken apart here; the Earth's velocity is another theory's, ERFA's.
Source: NAIF, DAF and SPK Required Reading (segments of data type 2).
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import erfa
import numpy as np
from numpy.polynomial.chebyshev import chebval

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.verification.clock import DAY_S

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
    # SciPy's interpolators take 0.2 s to import, which only a plan should pay.
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(node_s, barycentric["v"] * _AU_PER_DAY_M_S)(at_tdb_s))


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
