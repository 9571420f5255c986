"""A pixel near the horizon is as long as the round ground between its edges."""

import numpy as np
import pytest

from planner.world.targets.ground_sample import sample_along_m

RADIUS_M, PIXEL_RAD = 6378137.0, 3.3e-6


def range_at_m(elevation_rad, height_m):
    sine = np.sin(elevation_rad)
    return np.sqrt((RADIUS_M * sine) ** 2 + height_m * (2 * RADIUS_M + height_m)) - RADIUS_M * sine


def on_circle_m(elevation_rad, height_m):
    """By the two rays through the pixel's edges; NaN where one passes the circle by."""
    height_ratio = RADIUS_M / (RADIUS_M + height_m)
    off_nadir_rad = np.arcsin(height_ratio * np.cos(elevation_rad))
    edges_rad = off_nadir_rad + PIXEL_RAD * np.array([-0.5, 0.5])
    sine = np.sin(edges_rad) / height_ratio
    if (sine > 1.0).any():
        return np.nan
    return RADIUS_M * float(np.diff(np.arcsin(sine) - edges_rad)[0])


@pytest.mark.parametrize("height_m", [350e3, 420e3, 800e3])
@pytest.mark.parametrize(
    ("elevation_deg", "share"), [(90.0, 1e-6), (30.0, 1e-5), (2.0, 1e-4), (0.5, 1e-3), (0.25, 5e-3)]
)
def test_a_pixel_is_as_long_as_the_ground_between_its_edges(height_m, elevation_deg, share):
    elevation_rad = np.radians(elevation_deg)
    range_m = np.array([range_at_m(elevation_rad, height_m)])
    told_m = sample_along_m(np.sin([elevation_rad]), range_m, PIXEL_RAD)[0]
    assert told_m == pytest.approx(on_circle_m(elevation_rad, height_m), rel=share)


@pytest.mark.parametrize("height_m", [350e3, 800e3])
def test_a_pixel_that_reaches_the_horizon_has_no_length(height_m):
    """And the last that doesn't is a few kilometres long, never more."""
    elevation_rad = np.radians(np.linspace(-0.1, 0.2, 301))
    range_m = range_at_m(elevation_rad, height_m)
    told_m = sample_along_m(np.sin(elevation_rad), range_m, PIXEL_RAD)
    ends = [np.isfinite(on_circle_m(e, height_m)) and e > 0.0 for e in elevation_rad]
    disagree = np.isfinite(told_m) != ends
    assert disagree.sum() <= 1, elevation_rad[disagree]  # at the limit itself
    assert np.nanmax(told_m) < 10e3


def test_no_length_in_space():
    assert np.isnan(sample_along_m(np.ones(1), np.array([np.inf]), PIXEL_RAD)).all()
