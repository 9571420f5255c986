"""Frames, geodesy and time scales agree with published examples and values."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

from planner.base.errors import OutsideCoverage
from planner.world.frames.earth_orientation import (
    C_GCRF_FROM_EME2000,
    c_itrf_from_eci,
    c_itrf_from_teme,
    earth_orientation_warnings,
    iers_data_end_utc,
    itrf_from_eci_state,
)
from planner.world.frames.geodesy import (
    c_enu_from_itrf,
    geodetic_from_itrf,
    itrf_from_geodetic,
    up_itrf,
)
from planner.world.frames.iers import earth_orientation_table
from planner.world.frames.time_scales import (
    Instants,
    elapsed_s,
    shifted_utc,
    utc_from_text,
    utc_text,
)

# Vallado, Fundamentals of Astrodynamics, 4th ed., examples 3-14 and 3-15
EXAMPLE = Instants(datetime(2004, 4, 6, 7, 51, 28, 386009, tzinfo=UTC), np.zeros(1))
R_ITRF_M = np.array([[-1033.4793830, 7901.2952754, 6380.3565958]]) * 1e3
V_ITRF_M_S = np.array([[-3.225636520, -2.872451450, 5.531924446]]) * 1e3
R_GCRF_M = np.array([[5102.508959, 6123.011403, 6378.136925]]) * 1e3
V_GCRF_M_S = np.array([[-4.743220157, 0.790536497, 5.533755727]]) * 1e3
R_TEME_M = np.array([[5094.18016210, 6127.64465950, 6380.34453270]]) * 1e3

# He takes UT1 - UTC of 0 h; at 07:51 it is less by the length of day he gives, 1.5563 ms.
LATER_RAD = 7.292115e-5 * 1.5563e-3 * (7 * 3600 + 51 * 60 + 28.386) / 86400.0
C_HIS_FROM_OURS = np.array(
    [
        [np.cos(LATER_RAD), np.sin(LATER_RAD), 0.0],
        [-np.sin(LATER_RAD), np.cos(LATER_RAD), 0.0],
        [0.0, 0.0, 1.0],
    ]
)


def test_itrf_of_vallados_example():
    r_itrf_m, v_itrf_m_s = itrf_from_eci_state(R_GCRF_M, V_GCRF_M_S, EXAMPLE)
    # polar motion moves by 1 mas from 0 h to 07:51, UT1's tidal terms by 20 us: 5 cm, 5e-5 m/s
    np.testing.assert_allclose(r_itrf_m @ C_HIS_FROM_OURS.T, R_ITRF_M, rtol=0, atol=0.05)
    np.testing.assert_allclose(v_itrf_m_s @ C_HIS_FROM_OURS.T, V_ITRF_M_S, rtol=0, atol=5e-5)


def test_teme_of_vallados_example():
    r_itrf_m = C_HIS_FROM_OURS @ c_itrf_from_teme(EXAMPLE)[0] @ R_TEME_M[0]
    np.testing.assert_allclose(r_itrf_m, R_ITRF_M[0], rtol=0, atol=0.05)  # as above


def test_frame_bias_is_the_published_one():
    # IERS Conventions 2010, 5.4.4: bias of the pole -16.6170, -6.8192 mas, of the equinox -14.6 mas
    mas_rad = np.pi / 648e6
    c = C_GCRF_FROM_EME2000.T
    np.testing.assert_allclose(
        [c[2, 0], c[2, 1], c[0, 1]],
        np.array([-16.6170, -6.8192, -14.6]) * mas_rad,
        rtol=0,
        atol=1e-3 * mas_rad,
    )


def test_site_of_vallados_example_7_1():
    r_itrf_m = itrf_from_geodetic(np.deg2rad(39.007), np.deg2rad(-104.883), 2187.0)
    published_km = [-1275.1219, -4797.9890, 3994.2975]
    # half the last printed digit
    np.testing.assert_allclose(r_itrf_m / 1e3, published_km, rtol=0, atol=5e-5)


def test_geodetic_of_vallados_example_3_3():
    latitude, longitude, height_m = geodetic_from_itrf(
        np.array([6524.834, 6862.875, 6448.296]) * 1e3
    )
    # he takes an ellipsoid smaller by 0.7 m (6378.1363 km): 1e-6 deg; else half the last digit
    assert np.rad2deg(latitude) == pytest.approx(34.352496, abs=1.5e-6)
    assert np.rad2deg(longitude) == pytest.approx(46.4464, abs=5e-5)
    assert height_m == pytest.approx(5085.22e3, abs=5.0)


@pytest.mark.parametrize(
    ("latitude_deg", "longitude_deg", "r_itrf_m"),
    [
        (0.0, 0.0, [6378137.0, 0.0, 0.0]),
        (0.0, 180.0, [-6378137.0, 0.0, 0.0]),
        (90.0, 0.0, [0.0, 0.0, 6356752.3142]),  # NGA.STND.0036, table 3.3
        (-90.0, 0.0, [0.0, 0.0, -6356752.3142]),
    ],
)
def test_axes_of_the_ellipsoid(latitude_deg, longitude_deg, r_itrf_m):
    position = itrf_from_geodetic(np.deg2rad(latitude_deg), np.deg2rad(longitude_deg), 0.0)
    np.testing.assert_allclose(position, r_itrf_m, rtol=0, atol=5e-5)


def test_local_axes_at_a_known_place():
    # on the equator at 90 deg E: up +Y, east -X, north +Z
    latitude, longitude = 0.0, np.pi / 2
    np.testing.assert_allclose(up_itrf(latitude, longitude), [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(
        c_enu_from_itrf(latitude, longitude),
        [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
        atol=1e-15,
    )


def test_past_the_end_of_the_iers_data_the_plan_is_warned():
    end_utc = iers_data_end_utc()
    assert earth_orientation_warnings(Instants(end_utc, np.array([-1.0]))) == ()
    late = Instants(end_utc, np.array([10.0 * 86400.0]))
    (warning,) = earth_orientation_warnings(late)
    assert "10.0 days" in warning
    # held, not extrapolated: still a rotation
    c = c_itrf_from_eci(late)[0]
    np.testing.assert_allclose(c @ c.T, np.eye(3), atol=1e-14)


def test_before_the_iers_data_orientation_is_refused():
    with pytest.raises(OutsideCoverage, match="1973"):
        c_itrf_from_eci(Instants(datetime(1972, 6, 1, tzinfo=UTC), np.zeros(1)))


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
        "2016-12-31T23:59:59.0Z", "2016-12-31T23:59:59.5Z", "2016-12-31T23:59:60.0Z",
        "2016-12-31T23:59:60.5Z", "2017-01-01T00:00:00.0Z", "2017-01-01T00:00:00.5Z",
    ]  # fmt: skip
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
