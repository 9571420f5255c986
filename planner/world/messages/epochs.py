"""Epochs of CCSDS messages: time codes A and B, in several time systems, as TAI."""

import re
from datetime import UTC, datetime, timedelta
from functools import lru_cache

import numpy as np

from planner.world.frames.iers import earth_orientation_table
from planner.world.frames.time_scales import DAY_S, require_known, tai_us

TIME_SYSTEMS = ("UTC", "TAI", "TT", "GPS", "UT1")

_NS = 1_000_000_000
_DAY_NS = 86_400 * _NS
_ORIGIN = datetime(1972, 1, 1, tzinfo=UTC)
_ORIGIN_MJD = 41317
_TAI_MINUS_NS = {"TAI": 0, "TT": -32_184_000_000, "GPS": 19 * _NS}
_CODE = re.compile(r"(\d{4}-(?:\d{2}-\d{2}|\d{3}))T(\d{2}):(\d{2}):(\d{2})(?:\.(\d*))?Z?", re.ASCII)


def tai_ns(text: str, time_system: str) -> int:
    """Nanoseconds of TAI since 1972-01-01 TAI.

    Reads calendar (2022-02-07) and day-of-year (2022-038) dates, 23:59:60 in a UTC leap
    second, with or without Z.  time_system: one of TIME_SYSTEMS.  ValueError names the text.
    Source: CCSDS 301.0-B-4, time codes ASCII A and B.
    """
    match = _CODE.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is no CCSDS epoch such as 2022-02-07T12:00:00.000")
    day, hour, minute, second, fraction = match.groups()
    start_ns, length_ns = _day_ns(day, time_system)
    whole_s = int(hour) * 3600 + int(minute) * 60 + int(second)
    of_day_ns = whole_s * _NS
    if fraction:
        of_day_ns += int(fraction[:9].ljust(9, "0"))
    if of_day_ns >= length_ns or int(minute) > 59 or int(second) > 59 + (whole_s >= 86_400):
        raise ValueError(f"{text!r} is no time of that day")
    return start_ns + of_day_ns


@lru_cache(maxsize=64)
def _day_ns(text: str, time_system: str) -> tuple[int, int]:
    """Start (TAI ns) and length (ns) of the day."""
    try:
        layout = "%Y-%j" if len(text) == 8 else "%Y-%m-%d"
        day = datetime.strptime(text, layout).replace(tzinfo=UTC)
        if day.year != int(text[:4]):  # day 366 of a year of 365
            raise ValueError
    except ValueError:
        raise ValueError(f"{text!r} is no date") from None
    require_known(day)
    if time_system == "UTC":
        start_us, end_us = tai_us(day), tai_us(day + timedelta(days=1))
        return start_us * 1000, (end_us - start_us) * 1000
    count_ns = (day - _ORIGIN).days * _DAY_NS
    if time_system == "UT1":
        # UT1 read as UTC is at most 1 s off, in which UT1 - TAI moves by 1e-8 s.
        mjd = np.array([_ORIGIN_MJD + count_ns / (_NS * DAY_S)])
        ut1_minus_tai_s = earth_orientation_table().at(mjd)[0, 0]
        return count_ns - round(ut1_minus_tai_s * _NS), _DAY_NS
    return count_ns + _TAI_MINUS_NS[time_system], _DAY_NS
