"""Frames and geodesy agree with published examples."""

from datetime import UTC, datetime

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
from planner.world.frames.time_scales import Instants

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
