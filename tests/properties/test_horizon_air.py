"""The vertical lies within its stated error under the air of another model.

The limbs' light is SASKTRAN2's, stored in tests/data/horizon/air; the frames share only the camera
model with the estimator.
"""

from dataclasses import replace

import numpy as np
import pytest
from horizon_air import CONDITIONS, cases
from limb_frames import lowest_points
from test_horizon_estimate import FOUR_SIGMA, normalised2

from estimator.pipeline import estimate_vertical


@pytest.fixture(scope="module", params=["drawn_2", "tropical", "after_eruption"])
def pair(request):
    """The same frames in colour and in grey."""
    return next(cases(request.param, CONDITIONS["day, noisy, 320 px"], 1, seed=6))


def test_predicted_pair_is_right(pair):
    for one in pair:
        nadir = estimate_vertical(one.images, one.request).geocentric
        assert normalised2(nadir, one.geocentric_body) < FOUR_SIGMA
        # Half a pixel of 0.18 deg: the limb is found to a part of that, whatever lifts it.
        assert np.linalg.norm(nadir.nadir_body - one.geocentric_body) < np.deg2rad(0.09)


def test_heading_from_light_is_as_good_as_told(pair):
    """Taken for ordinary air, an eruption's haze turns the Sun's side around."""
    for one in pair:
        answer = estimate_vertical(one.images, replace(one.request, predicted=None))
        assert normalised2(answer.geocentric, one.geocentric_body) < FOUR_SIGMA
        assert normalised2(answer.geodetic, one.geodetic_body) < FOUR_SIGMA


def test_clouds_in_clean_air_do_not_draw_the_limb_down():
    """Clouds beyond the horizon, seen through air without dust, put this frame 11 sigma off."""
    _, (_, grey) = cases("exponential", CONDITIONS["day"], 2, seed=1)
    alone = replace(grey.request, cameras=grey.request.cameras[:1])
    for answer in (
        estimate_vertical(grey.images[:1], alone),
        estimate_vertical(grey.images, grey.request),
    ):
        assert answer.geocentric is not None
        assert normalised2(answer.geocentric, grey.geocentric_body) < FOUR_SIGMA


def test_frames_have_the_ellipsoids_limb():
    """Seen from 500 km over the equator, rays that touch the ellipsoid: in the equator's plane, at
    cos = a / r; due north, by the tangent to the meridian's ellipse."""
    a_m, b_m, r_m = 6378137.0, 6356752.3142, 6878137.0
    down = np.arccos(a_m / r_m)
    east = np.array([-np.sin(down), np.cos(down), 0.0])
    slope = b_m / np.sqrt(r_m**2 - a_m**2)
    north = np.array([-1.0, 0.0, slope]) / np.hypot(1.0, slope)
    _, _, height_m = lowest_points(np.array([r_m, 0.0, 0.0]), np.stack([east, north]))
    np.testing.assert_allclose(height_m, 0.0, atol=1e-3)
