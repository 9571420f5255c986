"""Time scales: UTC with its leap seconds, TAI and TT.

Inside a positive leap second a `datetime` can't say 23:59:60.x; here it is the second
occurrence of 23:59:59.x, marked by `fold=1`.  Every function of this module reads and
writes that; comparison operators of `datetime` do not.
"""

import re
from bisect import bisect_right
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cache
from typing import Annotated

import numpy as np

from planner.base.answer_members import Member, Schema, written
from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.world.frames.iers import leap_seconds

JulianDate = tuple[Array, Array]

DAY_S = 86400.0
MJD_JD = 2400000.5
TT_MINUS_TAI_S = 32.184
_ORIGIN_UTC = datetime(1972, 1, 1, tzinfo=UTC)
_ORIGIN_MJD = 41317
# The IERS's first day and DE421's last, with a day to spare for what lies around a session.
KNOWN_FROM_UTC = datetime(1973, 1, 3, tzinfo=UTC)
KNOWN_TO_UTC = datetime(2053, 10, 8, tzinfo=UTC)
_US = 1_000_000
_DAY_US = 86_400 * _US
_LAST_TAI_US = (datetime(9998, 12, 31, tzinfo=UTC) - _ORIGIN_UTC) // timedelta(microseconds=1)
_TEXT = re.compile(
    r"(\d{4}-\d{2}-\d{2})[Tt](\d{2}:\d{2}):(\d{2})(?:\.(\d{1,9}))?"
    r"([Zz]|[+-](?:[01]\d|2[0-3]):[0-5]\d)?",
    re.ASCII,
)


class TimeNotCovered(ValueError):
    """A time at which the Earth's orientation or the Moon are not known."""


class ToldTime(Member):
    """A time, told as text with so many decimals."""

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> Schema:
        return written(lambda moment_utc: utc_text(moment_utc, self.decimals or 0), {"type": "str"})


Utc = Annotated[datetime, ToldTime("utc", decimals=3)]
RowUtc = Annotated[datetime, ToldTime("utc", decimals=1)]  # rows are 0.2 s apart


@dataclass(frozen=True, eq=False)
class Instants:
    """Instants given as SI seconds since an epoch; leap seconds are counted.

    epoch_utc: aware.  t_s: shape (n,).
    """

    epoch_utc: datetime
    t_s: Array

    def __len__(self) -> int:
        return len(self.t_s)

    def tai_jd(self) -> JulianDate:
        """TAI as a two-part Julian date, each part of shape (n,); resolves 0.1 ns."""
        day, rest_us = divmod(tai_us(self.epoch_utc), _DAY_US)
        jd1 = np.full(len(self.t_s), MJD_JD + _ORIGIN_MJD + day)
        return jd1, (rest_us / _US + self.t_s) / DAY_S

    def tt_jd(self) -> JulianDate:
        """Terrestrial time as a two-part Julian date."""
        jd1, jd2 = self.tai_jd()
        return jd1, jd2 + TT_MINUS_TAI_S / DAY_S

    def since_s(self, epoch_utc: datetime) -> Array:
        """SI seconds since another epoch, shape (n,), negative before it."""
        return elapsed_s(self.epoch_utc, epoch_utc) + self.t_s

    def utc(self, k: int) -> datetime:
        """The k-th of them, rounded to 1 us."""
        return shifted_utc(self.epoch_utc, float(self.t_s[k]))

    def utc_jd(self) -> JulianDate:
        """UTC as SOFA's quasi Julian date: a day with a leap second has 86401 s; resolves 1 us."""
        starts_tai_s, starts_utc_s, offsets_s = (
            np.array(column) / _US for column in _leap_table_us()
        )
        tai_s = tai_us(self.epoch_utc) / _US + self.t_s
        row = np.searchsorted(starts_tai_s, tai_s, side="right") - 1
        utc_s = tai_s - offsets_s[row]
        next_utc_s = np.append(starts_utc_s, np.inf)[row + 1]
        # In a leap second the old offset still holds, so the count runs past the day's end.
        day = np.floor(utc_s / DAY_S) - (utc_s >= next_utc_s)
        day_length_s = DAY_S + ((day + 1.0) * DAY_S == next_utc_s)
        return MJD_JD + _ORIGIN_MJD + day, (utc_s - day * DAY_S) / day_length_s

    def utc_mjd(self) -> Array:
        """UTC as a modified quasi Julian date in one number (resolves 1 us), for daily tables."""
        jd1, jd2 = self.utc_jd()
        return (jd1 - MJD_JD) + jd2

    def utc_text(self, decimals: int = 3) -> list[str]:
        """RFC 3339 with Z, rounded to at most 6 decimals; a leap second reads 23:59:60."""
        moment_us = tai_us(self.epoch_utc) + np.rint(self.t_s * _US).astype(np.int64)
        step_us = _step_us(decimals)
        rounded_us = (moment_us + step_us // 2) // step_us * step_us
        starts_tai_us, starts_utc_us, offsets_us = map(np.array, _leap_table_us())
        row = np.searchsorted(starts_tai_us, rounded_us, side="right") - 1
        utc_us = rounded_us - offsets_us[row]
        is_plain = (row >= 0) & (rounded_us <= _LAST_TAI_US)
        is_plain &= utc_us < np.append(starts_utc_us, _LAST_TAI_US)[row + 1]  # no leap second
        origin = np.datetime64(_ORIGIN_UTC.replace(tzinfo=None), "us")
        shown = np.datetime_as_string(origin + np.where(is_plain, utc_us, 0))
        cut = shown.astype(f"U{20 + decimals if decimals else 19}")
        texts: list[str] = np.char.add(cut, "Z").tolist()
        for place in np.flatnonzero(~is_plain).tolist():
            texts[place] = _utc_text(int(moment_us[place]), decimals)
        return texts


def utc_from_text(text: str) -> datetime:
    """Aware UTC from RFC 3339 text; refuses a time without Z or offset.

    Refuses, too, times at which the Earth's orientation or the Moon are not known.  Digits
    past the microsecond are rounded (4 mm along an ISS orbit).
    """
    match = _TEXT.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is no RFC 3339 time; write it like 2015-02-27T17:34:00.000Z")
    day, minute, second, fraction, offset = match.groups()
    if offset is None:
        raise ValueError(f"{text!r} has no UTC offset; append Z if it is UTC")
    in_leap_second = second == "60"
    shown = f"{day}T{minute}:{'59' if in_leap_second else second}{offset.upper()}"
    try:
        moment = datetime.fromisoformat(shown)
    except ValueError as error:
        raise ValueError(f"{text!r} is no time: {error}") from None
    require_known(moment)
    moment = moment.astimezone(UTC)
    fraction_us = round(int(fraction or "0") * 10.0 ** (6 - len(fraction or "0")))
    if in_leap_second:
        moment = moment.replace(fold=1)
        if not _is_leap_second(moment):
            raise ValueError(f"{text!r}: there was no leap second at that time")
    return utc_from_tai_us(tai_us(moment) + fraction_us)


def require_known(moment: datetime) -> None:
    """Refuse a time at which the Earth's orientation or the Moon are not known."""
    if not KNOWN_FROM_UTC <= moment <= KNOWN_TO_UTC:
        raise TimeNotCovered(
            f"{moment.isoformat()} lies outside {KNOWN_FROM_UTC:%Y-%m-%d}.."
            f"{KNOWN_TO_UTC:%Y-%m-%d}, for which the Earth's orientation and the Moon are known; "
            "is the year right?"
        )


def utc_text(epoch_utc: datetime, decimals: int = 3) -> str:
    """RFC 3339 with Z, rounded to at most 6 decimals; a leap second reads 23:59:60."""
    return _utc_text(tai_us(epoch_utc), decimals)


def elapsed_s(until_utc: datetime, since_utc: datetime) -> float:
    """SI seconds from since_utc to until_utc, leap seconds counted; exact to 1 us."""
    return (tai_us(until_utc) - tai_us(since_utc)) / _US


def shifted_utc(epoch_utc: datetime, t_s: float) -> datetime:
    """UTC t_s SI seconds after the epoch, rounded to 1 us: the inverse of `elapsed_s`."""
    return utc_from_tai_us(tai_us(epoch_utc) + round(t_s * _US))


def tai_us(moment_utc: datetime) -> int:
    """Microseconds of TAI since 1972-01-01 TAI."""
    if moment_utc.utcoffset() is None:
        raise ValueError(f"{moment_utc.isoformat()} has no UTC offset; append Z if it is UTC")
    _, starts_utc_us, offsets_us = _leap_table_us()
    utc_us = (moment_utc - _ORIGIN_UTC) // timedelta(microseconds=1)
    if utc_us < 0:
        raise OutsideCoverage(
            f"{moment_utc.isoformat()} is before 1972, when UTC got its leap seconds; "
            "use a later epoch"
        )
    offset_us = offsets_us[bisect_right(starts_utc_us, utc_us) - 1]
    return utc_us + offset_us + (_US if _is_leap_second(moment_utc) else 0)


@cache
def _leap_table_us() -> tuple[list[int], list[int], list[int]]:
    """Where each TAI - UTC begins, on TAI's and on UTC's own count, and its value (us)."""
    first_mjd, tai_minus_utc_s = leap_seconds()
    starts_utc_us = [(mjd - _ORIGIN_MJD) * _DAY_US for mjd in first_mjd]
    offsets_us = [seconds * _US for seconds in tai_minus_utc_s]
    starts_tai_us = [a + b for a, b in zip(starts_utc_us, offsets_us, strict=True)]
    return starts_tai_us, starts_utc_us, offsets_us


def _is_leap_second(moment_utc: datetime) -> bool:
    """Whether `fold` marks this 23:59:59.x as 23:59:60.x."""
    if not moment_utc.fold:
        return False
    _, starts_utc_us, _ = _leap_table_us()
    utc_us = (moment_utc - _ORIGIN_UTC) // timedelta(microseconds=1)
    return bisect_right(starts_utc_us, utc_us) < bisect_right(starts_utc_us, utc_us + _US)


def _utc_us(moment_tai_us: int) -> tuple[int, bool]:
    """UTC microseconds since 1972-01-01, and whether they repeat 23:59:59 as 23:59:60."""
    starts_tai_us, starts_utc_us, offsets_us = _leap_table_us()
    row = bisect_right(starts_tai_us, moment_tai_us) - 1
    if moment_tai_us > _LAST_TAI_US:
        raise OutsideCoverage("that is after the year 9998; go less far ahead")
    if row < 0:
        raise OutsideCoverage(
            "that is before 1972, when UTC got its leap seconds; go less far back"
        )
    utc_us = moment_tai_us - offsets_us[row]
    if row + 1 < len(starts_utc_us) and utc_us >= starts_utc_us[row + 1]:
        return utc_us - _US, True
    return utc_us, False


def utc_from_tai_us(moment_tai_us: int) -> datetime:
    """Inverse of `tai_us`."""
    utc_us, in_leap_second = _utc_us(moment_tai_us)
    moment = _ORIGIN_UTC + timedelta(microseconds=utc_us)
    return moment.replace(fold=1) if in_leap_second else moment


def _step_us(decimals: int) -> int:
    if not 0 <= decimals <= 6:
        raise ValueError(f"decimals must lie in 0..6, not {decimals}")
    return int(10 ** (6 - decimals))


def _utc_text(moment_tai_us: int, decimals: int) -> str:
    step_us = _step_us(decimals)
    utc_us, in_leap_second = _utc_us((moment_tai_us + step_us // 2) // step_us * step_us)
    moment = _ORIGIN_UTC + timedelta(microseconds=utc_us)
    second = 60 if in_leap_second else moment.second
    fraction = f".{moment.microsecond:06d}"[: decimals + 1] if decimals else ""
    return f"{moment:%Y-%m-%dT%H:%M}:{second:02d}{fraction}Z"
