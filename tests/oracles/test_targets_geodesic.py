"""Courses over the ellipsoid against GeographicLib (Karney 2013, exact to 15 nm)."""

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import assume, given
from hypothesis import strategies as st

from planner.world.frames.geodesic import LONGEST_M, geodesic_between, geodesic_end
from planner.world.frames.geodesy import itrf_from_geodetic

latitudes = st.floats(-90.0, 90.0)
longitudes = st.floats(-180.0, 360.0)


@given(latitudes, longitudes, st.floats(-180.0, 360.0), st.floats(-10e6, 10e6))
def test_course_ends_where_geographiclib_says(latitude_deg, longitude_deg, course_deg, distance_m):
    end = geodesic_end(*np.radians([latitude_deg, longitude_deg, course_deg]), distance_m)
    theirs = Geodesic.WGS84.Direct(latitude_deg, longitude_deg, course_deg, distance_m)
    ours_m = itrf_from_geodetic(*end, 0.0)
    theirs_m = itrf_from_geodetic(*np.radians([theirs["lat2"], theirs["lon2"]]), 0.0)
    # Vincenty's series: 0.1 mm.
    np.testing.assert_allclose(ours_m, theirs_m, rtol=0, atol=1e-4)


@given(latitudes, longitudes, latitudes, longitudes)
def test_course_between_points_is_geographiclibs(latitude_1, longitude_1, latitude_2, longitude_2):
    theirs = Geodesic.WGS84.Inverse(latitude_1, longitude_1, latitude_2, longitude_2)
    assume(1.0 < theirs["s12"] < 0.99 * LONGEST_M)
    azimuth_rad, distance_m = geodesic_between(
        *np.radians([latitude_1, longitude_1, latitude_2, longitude_2]).tolist()
    )
    assert distance_m == pytest.approx(theirs["s12"], abs=1e-3)  # 0.1 mm of series, rounding
    end = geodesic_end(*np.radians([latitude_1, longitude_1]), azimuth_rad, distance_m)
    np.testing.assert_allclose(
        itrf_from_geodetic(*end, 0.0),
        itrf_from_geodetic(*np.radians([latitude_2, longitude_2]), 0.0),
        rtol=0,
        atol=1e-3,
    )


def test_points_too_far_apart_are_refused():
    with pytest.raises(ValueError, match="put one in between"):
        geodesic_between(0.0, 0.0, 0.0, np.radians(179.7))
