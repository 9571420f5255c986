"""The axis angles point where SciPy's rotations say, and their rates follow."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy_boresight import scipy_boresight

from planner.motion.pointing.angles import (
    axis_angles,
    axis_motion,
    boresight_platform,
    singular_margin_rad,
)
from planner.world.platforms import ISS_HRC, AxisLimits, TwoAxisPlatform

ROUNDING = 1e-9  # rad, 0.2 mas: double precision magnified near the singular directions
LIMITS = AxisLimits(
    angle_min_rad=-3.0,
    angle_max_rad=3.0,
    rate_max_rad_s=1.0,
    acceleration_max_rad_s2=1.0,
    jerk_max_rad_s3=1.0,
)


def boresight_of(platform, angle_rad):
    return scipy_boresight(angle_rad, platform.axes_platform, platform.zero_direction_platform)


def directions(seed, count):
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@st.composite
def platforms(draw):
    """Any axes at least 6 deg from parallel and any zero direction 6 deg off the inner axis."""
    seed = draw(st.integers(0, 2**32 - 1))
    vectors = directions(seed, 200)
    outer = vectors[0]
    inner = next(v for v in vectors[1:] if abs(v @ outer) < 0.995)
    zero = next(v for v in vectors[100:] if abs(v @ inner) < 0.995)
    return TwoAxisPlatform(
        name="any",
        outer_name="outer",
        outer_axis_platform=tuple(outer),
        outer_limits=LIMITS,
        inner_name="inner",
        inner_axis_platform=tuple(inner),
        inner_limits=LIMITS,
        zero_direction_platform=tuple(zero),
    )


@given(platform=platforms(), seed=st.integers(0, 10_000))
def test_both_branches_point_there_for_any_axes(platform, seed):
    los = directions(seed, 50)
    angles, reachable = axis_angles(platform, los)
    for branch in range(2):
        pointed = boresight_of(platform, angles[branch][reachable])
        ours = boresight_platform(platform, angles[branch][reachable])
        np.testing.assert_allclose(ours, pointed, rtol=0, atol=1e-12)
        clear = singular_margin_rad(platform, angles[branch], los)[reachable] > 1e-4
        np.testing.assert_allclose(pointed[clear], los[reachable][clear], rtol=0, atol=ROUNDING)
    assert np.isnan(angles[:, ~reachable]).all()


@given(platform=platforms(), seed=st.integers(0, 10_000))
def test_every_direction_the_axes_make_is_found_again(platform, seed):
    angle_rad = np.random.default_rng(seed).uniform(-np.pi, np.pi, size=(50, 2))
    los = boresight_of(platform, angle_rad)
    clear = singular_margin_rad(platform, angle_rad, los) > 1e-3
    angles, reachable = axis_angles(platform, los)
    assert reachable[clear].all()
    turns = np.angle(np.exp(1j * (angles - angle_rad)))
    nearest = np.abs(turns).max(axis=2).min(axis=0)
    assert np.all(nearest[clear] < ROUNDING)


def test_unreachable_cone_is_where_no_angles_point():
    """Inner axis 30 deg off perpendicular: the outer axis keeps a dead cone of that size."""
    tilted = TwoAxisPlatform(
        name="tilted",
        outer_name="outer",
        outer_axis_platform=(0.0, 0.0, 1.0),
        outer_limits=LIMITS,
        inner_name="inner",
        inner_axis_platform=(float(np.cos(np.pi / 6)), 0.0, 0.5),
        inner_limits=LIMITS,
        zero_direction_platform=(0.0, 1.0, 0.0),
    )
    los = directions(3, 4000)
    _, reachable = axis_angles(tilted, los)
    polar_rad = np.arccos(los[:, 2])
    np.testing.assert_array_equal(
        reachable, (polar_rad >= np.pi / 6) & (polar_rad <= np.pi - np.pi / 6)
    )


def test_hrc_closed_form_for_zero_direction_plus_z():
    """beta and alpha by hand from the geometry of Sumarokov 2016, eq. 11, axes tilted 5 deg."""
    tilt = np.deg2rad(5.0)
    los = directions(1, 500)
    m = los @ [0.0, -np.cos(tilt), np.sin(tilt)]
    n = los @ [0.0, np.sin(tilt), np.cos(tilt)]
    beta = np.arctan2(m, np.hypot(los[:, 0], n)) - tilt
    alpha = np.arctan2(-los[:, 0], n)
    other_beta = np.deg2rad(175.0) - np.arcsin(m)
    angles, reachable = axis_angles(ISS_HRC, los)
    assert reachable.all()

    def apart(a, b):
        return np.abs(np.angle(np.exp(1j * (a - b))))

    first = int(np.argmin(apart(angles[:, 0, 1], beta[0])))
    np.testing.assert_allclose(apart(angles[first, :, 0], alpha), 0.0, atol=ROUNDING)
    np.testing.assert_allclose(apart(angles[first, :, 1], beta), 0.0, atol=ROUNDING)
    np.testing.assert_allclose(apart(angles[1 - first, :, 0], alpha + np.pi), 0.0, atol=ROUNDING)
    np.testing.assert_allclose(apart(angles[1 - first, :, 1], other_beta), 0.0, atol=ROUNDING)


def test_hrc_singular_margin_is_the_angle_to_the_outer_axis():
    los = directions(2, 300)
    angles, _ = axis_angles(ISS_HRC, los)
    to_axis = np.arccos(np.abs(los @ ISS_HRC.axes_platform[0]))
    for branch in range(2):
        np.testing.assert_allclose(
            singular_margin_rad(ISS_HRC, angles[branch], los), to_axis, rtol=0, atol=1e-7
        )


@pytest.mark.parametrize("branch", [0, 1])
@given(platform=platforms())
def test_rates_and_accelerations_are_the_derivatives_of_the_angles(branch, platform):
    """Against 8th-order central differences of the angles; a made-up, known line of sight."""
    angle_0, swing = np.array([0.4, -0.7]), np.array([0.3, 0.2])

    def made_up(t):
        t = np.asarray(t)[:, None]
        angle = angle_0 + swing * np.sin(0.2 * t + [0.0, 1.0])
        return boresight_of(platform, angle), angle

    step = 0.05
    offsets = np.arange(-4, 5) * step
    t = np.linspace(0.0, 20.0, 30)
    stencil = np.stack([made_up(t + o)[0] for o in offsets])
    d1 = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    d2 = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
    los = stencil[4]
    los_rate = np.tensordot(d1, stencil, 1) / step
    los_acceleration = np.tensordot(d2, stencil, 1) / step**2
    angles, reachable = axis_angles(platform, los)
    rate, acceleration = axis_motion(platform, angles[branch], los, los_rate, los_acceleration)
    margin = singular_margin_rad(platform, angles[branch], los)
    around = np.stack([axis_angles(platform, sample)[0][branch] for sample in stencil])
    around = np.unwrap(around, axis=0)
    clear = reachable & (margin > 0.2)
    # Truncation (0.05 s of a 30 s swing, 8th order) and rounding: 1e-16/h and 1e-16/h^2,
    # both magnified by 1/sin(margin) per derivative.
    np.testing.assert_allclose(
        rate[clear], (np.tensordot(d1, around, 1) / step)[clear], rtol=0, atol=1e-10
    )
    np.testing.assert_allclose(
        acceleration[clear], (np.tensordot(d2, around, 1) / step**2)[clear], rtol=0, atol=1e-9
    )
