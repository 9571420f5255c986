"""Closed forms behind the second paper's part of the report."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).parents[2] / "bench"))

from reproduction.lomaka import (
    Rig,
    arc_px,
    circle_misfit_px,
    dip_rad,
    horizon_print,
    lens,
    model_rms_deg,
    nadir_error_deg,
    pair,
    printed_circle,
    seen,
    tilted_nadir,
    told_tilt_rad,
)


def test_a_flat_print_seen_square_on_only_turns_and_shrinks():
    print_xy = horizon_print()
    tilt, distance = 0.2, 3.0
    turn = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    found = seen(print_xy, Rig(distance=distance), tilt)
    np.testing.assert_allclose(found, print_xy @ turn.T / distance, atol=1e-12)


def test_a_line_on_a_print_turned_aside_leans_as_perspective_has_it():
    """The line y = b of a plane turned by e about the upright axis at distance D has a slope of
    -b tan(e) / D: it meets the plane's vanishing point at (1 / tan(e), 0)."""
    b, distance, aside = 0.2, 1.5, np.deg2rad(25.0)
    line = np.column_stack([np.linspace(-0.3, 0.3, 5), np.full(5, b)])
    x, y = seen(line, Rig(distance=distance, off_square_deg=-25.0), 0.0).T
    np.testing.assert_allclose(np.diff(y) / np.diff(x), -b / distance * np.tan(aside), atol=1e-12)


def test_an_axis_below_the_lens_moves_it_sideways():
    # By the sine of the tilt, over the distance.
    tilt, below = 0.1, 0.3
    point = np.zeros((1, 2))
    x, y = seen(point, Rig(pivot_below=below), tilt)[0]
    away = np.array([-below * np.sin(tilt), -below * (1.0 - np.cos(tilt))])
    c, s = np.cos(tilt), np.sin(tilt)
    np.testing.assert_allclose([x, y], [[c, s], [-s, c]] @ away, atol=1e-12)


def test_a_scale_error_is_twice_the_tilt_in_sine():
    # atan((1 + e) tan t) = t + e/2 sin 2t to first order in e
    t = np.array([0.1, 0.2])
    told = told_tilt_rad(t, Rig(scale_error=1e-6), np.random.default_rng(0))
    np.testing.assert_allclose(told - t, 0.5e-6 * np.sin(2.0 * t), rtol=1e-5)


@pytest.mark.parametrize(("pitch", "yaw"), [(0.0, 0.0), (14.0, 3.0), (-9.0, 12.0)])
def test_chords_between_unit_rays_are_square_to_the_nadir(pitch, yaw):
    """d.n is the same for all rays of the horizon of a sphere."""
    found = nadir_error_deg(pair(60.0, 22.0), tilted_nadir(pitch, yaw), 500e3, unit_rays=True)
    assert found < 1e-9


def test_whole_pixels_make_the_models_error():
    # Two ends, each even within a pixel, over the frame's width; 57 pitches leave it 15 %.
    expected = np.rad2deg(np.sqrt(1.0 / 6.0) / 640.0)
    assert model_rms_deg(50.0, 400e3, unit_rays=True) == pytest.approx(expected, rel=0.2)


def test_the_corrected_circle_is_one_about_its_axis():
    axis = np.array([0.2, -0.5, 0.8])
    points = printed_circle(axis, corrected=True)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(points @ axis, 0.0, atol=1e-12)


def test_no_circle_is_nearer_to_the_arc_than_the_nearest():
    """The nearest departs equally far to either side (Chebyshev): by 0.55 of what the best one in
    least squares does at its ends, the departure going with the fourth power."""
    arc = arc_px(lens(60.0, 640, np.rad2deg(dip_rad(500e3)), 0.0), tilted_nadir(0.0, 0.0), 500e3)
    x = np.linspace(*arc[[0, -1], 0], 641)
    y = np.interp(x, *arc[np.argsort(arc[:, 0])].T)
    start = np.array([319.5, 1700.0, 1460.0])
    fit = least_squares(lambda c: np.hypot(x - c[0], y - c[1]) - c[2], start, x_scale=1e3)
    assert circle_misfit_px(60.0) == pytest.approx(0.55 * np.abs(fit.fun).max(), rel=0.05)
