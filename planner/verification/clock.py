"""The time between two UTC instants, by the judge's own count of leap seconds."""

from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np
from astropy_iers_data import IERS_LEAP_SECOND_FILE

from planner.base.arrays import Array

DAY_US = 86_400_000_000
DAY_S = 86400.0
TT_MINUS_TAI_S = 32.184
_J2000_TT_US = 51544 * DAY_US + DAY_US // 2  # since MJD 0
_MJD_ZERO = datetime(1858, 11, 17, tzinfo=UTC)


def tai_us(moment_utc: datetime) -> int:
    """Microseconds of TAI since MJD 0; `fold=1` marks the repeated 23:59:59 of a leap second."""
    since = moment_utc - _MJD_ZERO
    of_day_us = since.seconds * 1_000_000 + since.microseconds
    offset_s = tai_minus_utc_s(since.days)
    if moment_utc.fold and of_day_us >= DAY_US - 1_000_000:
        offset_s = tai_minus_utc_s(since.days + 1)
    return since.days * DAY_US + of_day_us + offset_s * 1_000_000


def tai_minus_utc_s(mjd_utc: int) -> int:
    """On that UTC day, 1972 or later."""
    return next(seconds for first, seconds in reversed(_leaps()) if first <= mjd_utc)


def elapsed_us(until_utc: datetime, since_utc: datetime) -> int:
    """SI microseconds from since_utc to until_utc."""
    return tai_us(until_utc) - tai_us(since_utc)


def tt_s(epoch_utc: datetime, t_s: Array) -> Array:
    """TT in seconds since J2000, shape of t_s, seconds after the epoch; good to 1e-7 s."""
    return np.asarray((tai_us(epoch_utc) - _J2000_TT_US) / 1e6 + TT_MINUS_TAI_S + t_s)


@cache
def _leaps() -> tuple[tuple[int, int], ...]:
    """(first MJD, TAI - UTC in s) in order of time, from the IERS's list since 1972."""
    lines = Path(IERS_LEAP_SECOND_FILE).read_text(encoding="ascii").splitlines()
    rows = (line.split() for line in lines if not line.lstrip().startswith("#"))
    return tuple((int(float(row[0])), int(row[4])) for row in rows if row)
