"""The payload's axes are carried by both axes of any platform, and turn at their rate."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from planner.motion.pointing.angles import boresight_platform
from planner.world.platforms import ISS_HRC, TwoAxisPlatform

ROUNDING = 1e-12
numbers = st.floats(-1.0, 1.0)
angles = st.floats(-np.pi, np.pi)


@st.composite
def unit_vectors(draw):
    vector = np.array(draw(st.tuples(numbers, numbers, numbers)))
    length = np.linalg.norm(vector)
    assume(length > 0.1)
    return tuple((vector / length).tolist())


@st.composite
def platforms(draw):
    outer, inner, zero = (draw(unit_vectors()) for _ in range(3))
    assume(np.linalg.norm(np.cross(outer, inner)) > 0.05)
    assume(np.linalg.norm(np.cross(inner, zero)) > 0.05)
    return TwoAxisPlatform(
        name="any",
        outer_name="outer",
        outer_axis_platform=outer,
        outer_limits=ISS_HRC.outer_limits,
        inner_name="inner",
        inner_axis_platform=inner,
        inner_limits=ISS_HRC.inner_limits,
        zero_direction_platform=zero,
    )


def c_platform_from_payload(platform, angle_rad):
    return platform.q_payload_from_base(np.atleast_2d(angle_rad)).inv().as_matrix()[0]


def turn(axis, angle_rad):
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    return expm(angle_rad * np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))


@settings(deadline=None)
@given(platforms(), angles, angles)
def test_axes_are_those_at_zero_turned_by_both_axes(platform, a, b):
    at_zero = c_platform_from_payload(platform, [0.0, 0.0])
    turns = turn(platform.outer_axis_platform, a) @ turn(platform.inner_axis_platform, b)
    turned = c_platform_from_payload(platform, [a, b])
    np.testing.assert_allclose(turned, turns @ at_zero, rtol=0, atol=ROUNDING)
    boresight = boresight_platform(platform, np.array([[a, b]]))[0]
    np.testing.assert_allclose(turned[:, 2], boresight, rtol=0, atol=ROUNDING)


@settings(deadline=None)
@given(platforms(), angles)
def test_x_is_the_inner_axis_seen_across_the_boresight(platform, a):
    turned = c_platform_from_payload(platform, [a, 0.0])
    inner = turn(platform.outer_axis_platform, a) @ platform.inner_axis_platform
    assert abs(turned[:, 1] @ inner) < ROUNDING
    assert turned[:, 0] @ inner > 0.0


@settings(deadline=None)
@given(platforms(), st.tuples(angles, angles), st.tuples(numbers, numbers))
def test_angular_velocity_is_the_derivative_of_the_axes(platform, angle_rad, rate_rad_s):
    step_s = 1e-4
    angle, rate = np.array([angle_rad]), np.array([rate_rad_s])
    before, here, after = (
        c_platform_from_payload(platform, angle + k * step_s * rate) for k in (-1, 0, 1)
    )
    cross = here.T @ (after - before) / (2.0 * step_s)  # of omega, in payload axes
    omega_rad_s = np.array([cross[2, 1], cross[0, 2], cross[1, 0]])
    found = platform.omega_payload_rad_s(angle, rate)[0]
    # step^2/6 of the third derivative, up to 8 /s3, is 1.3e-8; rounding 1e-16/step is 1e-12
    np.testing.assert_allclose(found, omega_rad_s, rtol=0, atol=2e-8)


def test_on_the_hrc_the_axes_at_zero_are_the_platforms():
    np.testing.assert_allclose(
        c_platform_from_payload(ISS_HRC, [0.0, 0.0]), np.eye(3), rtol=0, atol=ROUNDING
    )
