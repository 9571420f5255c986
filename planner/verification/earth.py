"""The Earth's orientation, straight from the IAU series and the IERS's values.

The judge's own chain: full IAU 2006/2000A series and the exact celestial and polar matrices
at instants at most half an hour apart, cubics through the nearest four, the Earth rotation angle
in full at every instant.
"""

from dataclasses import dataclass
from datetime import datetime
from functools import cache
from pathlib import Path

import erfa
import numpy as np
from astropy_iers_data import IERS_A_FILE

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.verification.clock import DAY_S, DAY_US, TT_MINUS_TAI_S, tai_minus_utc_s, tai_us

MJD_JD = 2400000.5
NODE_SPACING_MAX_S = 1800.0  # a cubic through nutation's fastest day-long terms: < 1e-9 arcsec
NODES_MIN = 4
EARTH_ROTATION_RAD_S = 2.0 * np.pi * 1.00273781191135448 / DAY_S  # IERS Conventions 2010, 5.15

_FIRST_MJD = 41684  # first line of finals2000A: 1973-01-02
_LINE_BYTES = 188
_UT1_COLUMNS = slice(58, 68)
_POLE_X_COLUMNS = slice(18, 27)
_POLE_Y_COLUMNS = slice(37, 46)
_DX_COLUMNS = slice(97, 106)
_DY_COLUMNS = slice(116, 125)
_ARCSEC_RAD = float(erfa.DAS2R)


@dataclass(frozen=True, eq=False)
class EarthOrientation:
    """Orientation of the Earth at n instants.

    c_cirs_from_eci, c_itrf_from_tirs: shape (n, 3, 3); era_rad: shape (n,).
    """

    c_cirs_from_eci: Array
    c_itrf_from_tirs: Array
    era_rad: Array

    def eci_from_itrf(self, vector_itrf: Array, before_s: Array | float = 0.0) -> Array:
        """Shape (n, 3): a vector of each instant, with the Earth turned back by before_s seconds.

        before_s is a light time: over 10 ms the celestial pole moves by 1e-9 arcsec.
        """
        tirs = np.einsum("nji,nj->ni", self.c_itrf_from_tirs, vector_itrf)
        angle = self.era_rad - EARTH_ROTATION_RAD_S * before_s
        cos, sin = np.cos(angle), np.sin(angle)
        cirs = np.stack(
            [cos * tirs[:, 0] - sin * tirs[:, 1], sin * tirs[:, 0] + cos * tirs[:, 1], tirs[:, 2]],
            axis=1,
        )
        return np.asarray(np.einsum("nji,nj->ni", self.c_cirs_from_eci, cirs))

    def itrf_from_eci(self, vector_eci: Array) -> Array:
        """Shape (n, 3): the inverse of `eci_from_itrf` at the instants themselves."""
        cirs = np.einsum("nij,nj->ni", self.c_cirs_from_eci, vector_eci)
        cos, sin = np.cos(self.era_rad), np.sin(self.era_rad)
        tirs = np.stack(
            [cos * cirs[:, 0] + sin * cirs[:, 1], cos * cirs[:, 1] - sin * cirs[:, 0], cirs[:, 2]],
            axis=1,
        )
        return np.asarray(np.einsum("nij,nj->ni", self.c_itrf_from_tirs, tirs))


def earth_orientation(epoch_utc: datetime, t_s: Array) -> EarthOrientation:
    """Orientation at t_s seconds after the epoch, shape (n,), in order of time.

    Leaves out the diurnal and semi-diurnal tides in UT1 and pole (3 cm on the ground); past
    the end of the IERS's predictions the last values are held.
    Source: IERS Conventions 2010, chapter 5 (CIO based).
    """
    day, of_day_us = divmod(tai_us(epoch_utc), DAY_US)
    of_day_s = of_day_us / 1e6
    span_s = float(t_s[-1] - t_s[0])
    count = max(NODES_MIN, int(np.ceil(span_s / NODE_SPACING_MAX_S)) + 1)
    node_s = np.linspace(t_s[0], t_s[-1], count)

    eop = np.array([_earth_orientation_parameters(day, of_day_s + t) for t in node_s])
    ut1_minus_tai_s, pole_x, pole_y, dx, dy = eop.T
    tt_days = (of_day_s + node_s + TT_MINUS_TAI_S) / DAY_S
    cip_x, cip_y, cio_s = erfa.xys06a(MJD_JD + day, tt_days)
    c_cirs_from_eci = erfa.c2ixys(cip_x + dx, cip_y + dy, cio_s)
    c_itrf_from_tirs = erfa.pom00(pole_x, pole_y, erfa.sp00(MJD_JD + day, tt_days))

    nodes = np.concatenate(
        [c_cirs_from_eci.reshape(-1, 9), c_itrf_from_tirs.reshape(-1, 9), ut1_minus_tai_s[:, None]],
        axis=1,
    )
    smooth = interpolate_evenly(node_s, nodes, t_s)
    ut1_days = (of_day_s + t_s + smooth[:, 18]) / DAY_S
    return EarthOrientation(
        c_cirs_from_eci=smooth[:, :9].reshape(-1, 3, 3),
        c_itrf_from_tirs=smooth[:, 9:18].reshape(-1, 3, 3),
        era_rad=np.asarray(erfa.era00(MJD_JD + day, ut1_days)),
    )


def interpolate_evenly(node_s: Array, node_value: Array, t_s: Array) -> Array:
    """Cubic Lagrange polynomials through the four nodes nearest to each instant, (n, k).

    node_s: evenly spaced, at least four.  node_value: (nodes, k).  t_s: (n,), within the nodes.
    By hand, as SciPy's interpolators take 0.1 s of every command's start to import.
    """
    step_s = node_s[1] - node_s[0]
    first = np.clip(((t_s - node_s[0]) / step_s).astype(np.intp) - 1, 0, len(node_s) - 4)
    x = (t_s - node_s[first]) / step_s
    total = np.zeros((len(t_s), node_value.shape[1]))
    for node in range(4):
        weight = np.prod([(x - other) / (node - other) for other in range(4) if other != node], 0)
        total += weight[:, None] * node_value[first + node]
    return total


def _earth_orientation_parameters(tai_mjd: int, tai_of_day_s: float) -> Array:
    """UT1 - TAI (s), pole x, y and celestial pole offsets dX, dY (rad), shape (5,).

    Cubic Lagrange through the four nearest days, as IERS Conventions 2010, 5.1 advise.
    """
    last = _last_mjd()
    utc_days = (tai_of_day_s - tai_minus_utc_s(tai_mjd)) / DAY_S
    mjd_whole = tai_mjd + int(np.floor(utc_days))
    fraction = utc_days - np.floor(utc_days)
    if mjd_whole < _FIRST_MJD:
        raise OutsideCoverage("Earth orientation is not known before 1973-01-02; use later times")
    if mjd_whole >= last:
        return _daily_values(last)
    first = min(max(mjd_whole - 1, _FIRST_MJD), last - 3)
    x = mjd_whole - first + fraction
    values = np.array([_daily_values(first + k) for k in range(4)])
    weights = [
        np.prod([(x - other) / (node - other) for other in range(4) if other != node])
        for node in range(4)
    ]
    return np.asarray(weights @ values)


@cache
def _daily_values(mjd: int) -> Array:
    """UT1 - TAI (s), x, y, dX, dY (rad) at 0h UTC of one day; unpredicted offsets keep the last."""
    line = _line(mjd)
    offsets_mjd = mjd
    while not _line(offsets_mjd)[_DX_COLUMNS].strip():
        offsets_mjd -= 1
    offsets = _line(offsets_mjd)
    return np.array(
        [
            float(line[_UT1_COLUMNS]) - tai_minus_utc_s(mjd),
            float(line[_POLE_X_COLUMNS]) * _ARCSEC_RAD,
            float(line[_POLE_Y_COLUMNS]) * _ARCSEC_RAD,
            float(offsets[_DX_COLUMNS]) * 1e-3 * _ARCSEC_RAD,
            float(offsets[_DY_COLUMNS]) * 1e-3 * _ARCSEC_RAD,
        ]
    )


@cache
def _last_mjd() -> int:
    """Last day the IERS predicts UT1 for."""
    mjd = _FIRST_MJD + Path(IERS_A_FILE).stat().st_size // _LINE_BYTES - 1
    while not _line(mjd)[_UT1_COLUMNS].strip():
        mjd -= 1
    return mjd


@cache
def _line(mjd: int) -> str:
    """One day of finals2000A, Bulletin A in its columns; the file has one line a day."""
    with Path(IERS_A_FILE).open("rb") as file:
        file.seek((mjd - _FIRST_MJD) * _LINE_BYTES)
        line = file.read(_LINE_BYTES).decode("ascii")
    if float(line[7:15]) != mjd:
        raise ValueError(f"finals2000A.all no longer holds MJD {mjd} where its format puts it")
    return line
