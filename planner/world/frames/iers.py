"""The IERS tables: leap seconds and Earth orientation parameters, from a package.

No download at run time: the tables are those of the installed astropy-iers-data.
"""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from astropy_iers_data import IERS_A_FILE, IERS_LEAP_SECOND_FILE

from planner.base.arrays import Array
from planner.base.interpolation import lagrange_weights

RAD_PER_ARCSEC = math.pi / 648000.0


@cache
def leap_seconds() -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Days (MJD, UTC, 0h) from which TAI is ahead of UTC by so many seconds, and the seconds.

    Since 1972-01-01, when UTC began to differ from TAI by whole seconds.
    """
    mjd, tai_minus_utc_s = np.loadtxt(IERS_LEAP_SECOND_FILE, usecols=(0, 4)).T.astype(int).tolist()
    return tuple(mjd), tuple(tai_minus_utc_s)


@dataclass(frozen=True, eq=False)
class EarthOrientationTable:
    """One row a day at 0h UTC, without gaps, the IERS's own predictions at its end.

    utc_mjd: shape (n,).  ut1_s_pole_rad: shape (n, 5), columns UT1 - TAI (s), polar motion x, y
    (rad) and celestial pole offsets dX, dY (rad).  UT1 - TAI has no leap-second steps, so it can
    be interpolated; dX and dY, whose predictions end months before the others', keep their last.
    Source: finals2000A.all (Bulletin A columns) of the IERS Rapid Service.
    """

    utc_mjd: Array
    ut1_s_pole_rad: Array

    def at(self, utc_mjd: Array) -> Array:
        """The columns, shape (m, 5), at utc_mjd, shape (m,), by four-point Lagrange interpolation.

        Past either end the value at that end is held.  Leaves out the diurnal and
        semi-diurnal ocean tides (0.5 mas and 0.05 ms at most: 3 cm on the ground).
        Source: IERS Conventions 2010, 5.1 (the interpolation it recommends).
        """
        x = np.clip(utc_mjd, self.utc_mjd[0], self.utc_mjd[-1]) - self.utc_mjd[0]
        first = np.clip(np.floor(x).astype(np.intp) - 1, 0, len(self.utc_mjd) - 4)
        days = np.arange(4)
        weights = lagrange_weights(days - (x - first)[:, None])
        nearest = self.ut1_s_pole_rad[first[:, None] + days]
        return np.asarray(np.einsum("mk,mkj->mj", weights, nearest))


@cache
def earth_orientation_table() -> EarthOrientationTable:
    """Read once a process (about 20 ms)."""
    text = Path(IERS_A_FILE).read_bytes()
    rows = np.frombuffer(text, dtype="S1").reshape(-1, text.index(b"\n") + 1)

    def column(start: int, stop: int) -> Array:
        """The fixed-width field in bytes start..stop, counted from one; blanks are NaN."""
        field = np.ascontiguousarray(rows[:, start - 1 : stop]).view(f"S{stop - start + 1}")[:, 0]
        blank = np.char.str_len(np.char.strip(field)) == 0
        return np.where(blank, b"nan", field).astype(np.float64)

    utc_mjd = column(8, 15)
    ut1_minus_utc_s = column(59, 68)
    known = np.isfinite(ut1_minus_utc_s)
    utc_mjd, ut1_minus_utc_s = utc_mjd[known], ut1_minus_utc_s[known]
    first_mjd, tai_minus_utc_s = map(np.array, leap_seconds())
    row = np.searchsorted(first_mjd, utc_mjd, side="right") - 1
    ut1_minus_tai_s = ut1_minus_utc_s - tai_minus_utc_s[row]
    pole_rad = [column(*span)[known] * RAD_PER_ARCSEC for span in ((19, 27), (38, 46))]
    offset_rad = [
        _fill_blanks(column(*span)[known]) * 1e-3 * RAD_PER_ARCSEC
        for span in ((98, 106), (117, 125))
    ]
    return EarthOrientationTable(
        utc_mjd=utc_mjd, ut1_s_pole_rad=np.stack([ut1_minus_tai_s, *pole_rad, *offset_rad], axis=1)
    )


def _fill_blanks(offset_mas: Array) -> Array:
    """Blanks replaced by the last value before them."""
    last = np.maximum.accumulate(np.where(np.isfinite(offset_mas), np.arange(len(offset_mas)), 0))
    return offset_mas[last]
