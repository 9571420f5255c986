"""Refraction against rays traced by SciPy, and courses over the ellipsoid against GeographicLib.

d/ds (n dr/ds) = grad n (Born and Wolf 1999, 3.2.1): no Bouguer, no series, no quadrature.
Karney 2013 is exact to 15 nm.
"""

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from planner.world.frames.geodesic import LONGEST_M, geodesic_between, geodesic_end
from planner.world.frames.geodesy import itrf_from_geodetic
from planner.world.targets.refraction import EARTH_RADIUS_M, bending_rad, raised_m
from planner.world.targets.standard_atmosphere import refractivity

TOP_M = 130e3
STEP_M = 1.0


def ray(_s, state):
    r, momentum = state[:2], state[2:]
    distance = np.hypot(*r)
    height = distance - EARTH_RADIUS_M
    slope = (refractivity(height + STEP_M) - refractivity(height - STEP_M)) / (2.0 * STEP_M)
    return np.concatenate([momentum / (1.0 + refractivity(height)), slope * r / distance])


def leave_air(height_m, zenith_rad):
    """Position (2,) and direction (2,) above the air of a ray that starts at (0, R + height)."""
    n = 1.0 + refractivity(height_m)
    momentum = n * np.array([np.sin(zenith_rad), np.cos(zenith_rad)])
    start = np.array([0.0, EARTH_RADIUS_M + height_m, *momentum])

    def above(_s, state):
        return np.hypot(state[0], state[1]) - EARTH_RADIUS_M - TOP_M

    above.terminal = True
    above.direction = 1.0
    path = solve_ivp(ray, (0.0, 3e6), start, rtol=1e-12, atol=1e-10, events=above, max_step=2e3)
    r, momentum = path.y[:2, -1], path.y[2:, -1]
    return r, momentum / np.hypot(*momentum)


@pytest.mark.parametrize("height_m", [0.0, 2500.0])
@pytest.mark.parametrize("elevation_deg", [80.0, 45.0, 30.0, 15.0, 8.0, 5.2])
def test_target_seems_raised_onto_the_rays_straight_continuation(height_m, elevation_deg):
    r, direction = leave_air(height_m, np.radians(90.0 - elevation_deg))
    # On to a carrier 400 km high, then what our model says of that carrier.
    along = -r @ direction + np.sqrt((r @ direction) ** 2 - r @ r + (EARTH_RADIUS_M + 400e3) ** 2)
    sat = r + along * direction
    to_sat = sat - np.array([0.0, EARTH_RADIUS_M + height_m])
    raised = raised_m(
        np.array([np.arctan2(*to_sat)]), np.array([np.hypot(*to_sat)]), np.array([height_m])
    )
    expected = sat[1] - sat[0] * direction[1] / direction[0] - EARTH_RADIUS_M - height_m
    # 3e-4: 48 nodes across the kinks of the standard's layers; the weather makes 5e-2.
    assert raised[0] == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize("ray_height_m", [2e3, 8e3, 15e3, 25e3, 40e3, 60e3])
def test_bending_beyond_the_limb(ray_height_m):
    """A ray that is level at its lowest point bends equally on both sides of it."""
    _, direction = leave_air(ray_height_m, np.pi / 2.0)
    bent_rad = 2.0 * np.arctan2(-direction[1], direction[0])
    r = EARTH_RADIUS_M + ray_height_m
    line_height_m = (1.0 + refractivity(ray_height_m)) * r - EARTH_RADIUS_M
    # 1 %: the spline rounds the kinks where the standard's layers meet, 11 km up at most so.
    assert bending_rad(line_height_m) == pytest.approx(bent_rad, rel=0.01)


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
