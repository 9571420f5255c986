"""The time scales agree with the IERS's and SOFA's published values."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

from planner.base.errors import OutsideCoverage
from planner.world.frames.iers import earth_orientation_table
from planner.world.frames.time_scales import (
    Instants,
    elapsed_s,
    shifted_utc,
    utc_from_text,
    utc_text,
)

ONE = np.zeros(1)


def ut1_jd(instants):
    jd1, jd2 = instants.tai_jd()
    return jd1, jd2 + earth_orientation_table().at(instants.utc_mjd())[:, 0] / 86400.0


def second_of_day(julian_date):
    return ((julian_date[0][0] - 0.5) % 1.0 + julian_date[1][0]) * 86400.0


def test_scales_of_the_sofa_cookbook():
    # SOFA Time Scale and Calendar Tools, 4.2: 2006-01-15 21:24:37.5 UTC
    instants = Instants(datetime(2006, 1, 15, 21, 24, 37, 500000, tzinfo=UTC), ONE)
    tolerance_s = 1e-9  # our two-part dates resolve 0.1 ns
    assert second_of_day(instants.tai_jd()) == pytest.approx(
        21 * 3600 + 25 * 60 + 10.5, abs=tolerance_s
    )
    assert second_of_day(instants.tt_jd()) == pytest.approx(
        21 * 3600 + 25 * 60 + 42.684, abs=tolerance_s
    )
    # its UT1 - UTC is printed as 0.3341 s
    assert second_of_day(ut1_jd(instants)) == pytest.approx(21 * 3600 + 24 * 60 + 37.8341, abs=5e-5)


def test_leap_second_of_2016():
    # IERS Bulletin C 52: 2016-12-31 23:59:59, 23:59:60, 2017-01-01 00:00:00
    instants = Instants(datetime(2016, 12, 31, 23, 59, 59, tzinfo=UTC), np.arange(0.0, 2.6, 0.5))
    assert instants.utc_text(1) == [
        "2016-12-31T23:59:59.0Z",
        "2016-12-31T23:59:59.5Z",
        "2016-12-31T23:59:60.0Z",
        "2016-12-31T23:59:60.5Z",
        "2017-01-01T00:00:00.0Z",
        "2017-01-01T00:00:00.5Z",
    ]
    assert elapsed_s(utc_from_text("2017-01-01T00:00:00Z"), instants.epoch_utc) == 2.0
    # TAI - UTC goes from 36 to 37 s: Bulletin C 52
    start, stop = (
        Instants(datetime(2016, 12, 31, tzinfo=UTC), ONE),
        Instants(datetime(2017, 1, 1, tzinfo=UTC), ONE),
    )
    assert second_of_day(start.tai_jd()) == pytest.approx(36.0, abs=1e-9)
    assert second_of_day(stop.tai_jd()) == pytest.approx(37.0, abs=1e-9)


def test_a_time_inside_the_leap_second_survives_every_path():
    moment = utc_from_text("2016-12-31T23:59:60.25Z")
    assert utc_text(moment, 2) == "2016-12-31T23:59:60.25Z"
    assert elapsed_s(utc_from_text("2017-01-01T00:00:00Z"), moment) == 0.75
    assert utc_text(shifted_utc(moment, -0.5), 2) == "2016-12-31T23:59:59.75Z"
    before = datetime(2016, 12, 31, 23, 59, 59, tzinfo=UTC)
    assert utc_text(shifted_utc(before, 1.25), 2) == "2016-12-31T23:59:60.25Z"


def test_the_day_with_a_leap_second_has_86401_s():
    # SOFA's quasi Julian date (Time Scale and Calendar Tools, 3.5)
    noon = Instants(datetime(2016, 12, 31, 12, tzinfo=UTC), ONE)
    assert noon.utc_jd()[1][0] == pytest.approx(43200.0 / 86401.0, abs=1e-11)
    ordinary = Instants(datetime(2016, 12, 30, 12, tzinfo=UTC), ONE)
    assert ordinary.utc_jd()[1][0] == pytest.approx(0.5, abs=1e-11)


def test_ut1_has_no_step_at_the_leap_second():
    instants = Instants(datetime(2016, 12, 31, 23, 59, 58, tzinfo=UTC), np.arange(5.0))
    jd1, jd2 = ut1_jd(instants)
    # a day is 1-2 ms longer than 86400 s: 2e-8 s in each second
    np.testing.assert_allclose(np.diff(jd1 + 0.0 - jd1[0] + jd2) * 86400.0, 1.0, atol=1e-7)


def test_text_is_rounded_across_the_leap_second():
    assert utc_text(utc_from_text("2016-12-31T23:59:60.9996Z"), 3) == "2017-01-01T00:00:00.000Z"
    assert utc_text(utc_from_text("2016-12-31T23:59:59.9996Z"), 3) == "2016-12-31T23:59:60.000Z"


def test_offsets_are_read():
    assert utc_from_text("2015-02-27T20:34:00.5+03:00") == datetime(
        2015, 2, 27, 17, 34, 0, 500000, tzinfo=UTC
    )
    eastern = timezone(timedelta(hours=-5))
    assert utc_text(datetime(2015, 2, 27, 12, 34, tzinfo=eastern), 0) == "2015-02-27T17:34:00Z"


def test_naive_and_ancient_epochs_are_refused():
    with pytest.raises(ValueError, match="append Z"):
        elapsed_s(datetime(2015, 2, 27), datetime(2015, 2, 27, tzinfo=UTC))  # noqa: DTZ001
    with pytest.raises(OutsideCoverage, match="before 1972"):
        Instants(datetime(1969, 7, 20, tzinfo=UTC), ONE).tai_jd()
