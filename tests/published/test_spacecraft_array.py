"""The gyros' momentum, envelope and torque are the paper's (Platonov, Sumarokov 2019)."""

import numpy as np
import pytest

from planner.world.platforms.cmg_array import CmgArray
from planner.world.platforms.steering import rotor_momentum, steer

ARRAY = CmgArray()
H = 60.0


def test_momentum_is_the_papers_formula():
    rng = np.random.default_rng(1)
    d = rng.uniform(-np.pi, np.pi, (50, 4))
    s, c = np.sin(d), np.cos(d)
    printed = H * np.stack([s[:, 2] + s[:, 3], s[:, 0] + s[:, 1], c.sum(axis=1)], axis=1)
    np.testing.assert_allclose(ARRAY.momentum(d), printed, atol=1e-12)  # rounding


def test_envelope_is_120_120_240():
    rng = np.random.default_rng(2)
    reached = np.abs(ARRAY.momentum(rng.uniform(-np.pi, np.pi, (200_000, 4)))).max(axis=0)
    assert np.all(reached <= [120.0, 120.0, 240.0])
    for corner in ([120, 0, 0], [0, 120, 0], [0, 0, 240]):
        assert ARRAY.in_envelope(np.array(corner, dtype=float))
        assert not ARRAY.in_envelope(1.001 * np.array(corner, dtype=float))


def test_every_momentum_of_random_gimbals_is_inside_the_envelope():
    rng = np.random.default_rng(3)
    momentum = ARRAY.momentum(rng.uniform(-np.pi, np.pi, (100_000, 4)))
    assert np.all(ARRAY.in_envelope(momentum * (1.0 - 1e-12)))


def test_gimbal_angles_invert_momentum():
    rng = np.random.default_rng(4)
    for _ in range(20):
        wanted = rng.standard_normal(3)
        wanted *= rng.uniform(0.0, 60.0) / np.linalg.norm(wanted)
        angles = ARRAY.gimbal_angles(wanted)
        np.testing.assert_allclose(ARRAY.momentum(angles), wanted, atol=1e-9)  # rounding


def test_jacobian_is_the_derivative():
    angles, step = np.array([0.3, -1.2, 2.0, 0.7]), 1e-6
    for k in range(4):
        bump = step * np.eye(4)[k]
        difference = (ARRAY.momentum(angles + bump) - ARRAY.momentum(angles - bump)) / (2 * step)
        # central difference: truncation 1e-12, rounding 60 * 1e-16 / 1e-6
        np.testing.assert_allclose(ARRAY.jacobian(angles)[:, k] * H, difference, atol=1e-7)


def test_at_least_30_n_m_anywhere_in_the_60_n_m_s_sphere():
    """Gimbals at 1 rad/s; the pseudo-inverse's split, in every direction."""
    rng = np.random.default_rng(5)
    directions = rng.standard_normal((200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for momentum in 60.0 * directions[:60]:
        split = np.linalg.pinv(ARRAY.jacobian(ARRAY.gimbal_angles(momentum)))
        torque = H / np.abs(split @ directions.T).max(axis=0)
        assert torque.min() >= 30.0  # the paper, "not less than 30 N m"


def steered(angles, wanted, null_gain):
    rates = np.zeros(4)
    steer(ARRAY.gyros()._replace(rate_max_rad_s=1.0), angles, wanted, null_gain, rates)
    return rates


def test_steering_gives_the_torque_and_null_motion_none():
    angles = np.array([0.9, -0.5, 2.6, -2.0])
    wanted = np.array([3.0, -2.0, 4.0])
    for gain in (0.0, 0.05):
        rates = steered(angles, wanted, gain)
        np.testing.assert_allclose(H * ARRAY.jacobian(angles) @ rates, wanted, atol=1e-9)


def test_null_motion_leaves_singularity():
    """Taken literally, the printed sign of xi ends in it (systems notes: 74 -> 0)."""
    angles = np.deg2rad([84.0, -85.0, 95.0, -96.0])  # both scissors almost wide open
    margins = []
    for _ in range(2000):
        margins.append(float(ARRAY.singularity_margin(angles)))
        angles = angles + 0.05 * steered(angles, np.zeros(3), 0.2)
    assert margins[0] < 0.2
    assert margins[-1] > 0.9


def test_rates_are_limited_and_the_inverse_guarded_at_a_singularity():
    flat = np.array([np.pi / 2, np.pi / 2, np.pi / 2, np.pi / 2])
    rates = steered(flat, np.array([10.0, 10.0, 10.0]), 0.02)
    assert np.all(np.isfinite(rates))
    assert np.abs(rates).max() <= 1.0 + 1e-12


def test_kernel_and_definition_agree():
    angles, out = np.array([0.1, 0.9, -2.0, 1.4]), np.zeros(3)
    rotor_momentum(ARRAY.gyros(), angles, out)
    np.testing.assert_allclose(out, ARRAY.momentum(angles), atol=1e-12)


@pytest.mark.parametrize("momentum_n_m_s", [60.0, 10.0])
def test_torque_told_for_every_direction_is_there_in_each(momentum_n_m_s):
    """The least singular value of D at full gimbal rates, by numpy; the paper's 30 N m of 60."""
    array = CmgArray(momentum_n_m_s=momentum_n_m_s)
    assert array.torque_n_m == pytest.approx(0.5 * momentum_n_m_s, rel=1e-4)
    rng = np.random.default_rng(5)
    for held in rng.standard_normal((40, 3)):
        held *= array.sphere_n_m_s / np.linalg.norm(held)
        d = array.jacobian(array.gimbal_angles(held))
        least = np.linalg.svd(d, compute_uv=False)[-1]
        assert least * momentum_n_m_s * array.rate_max_rad_s > array.torque_n_m


@pytest.mark.parametrize("axis", [0, 1])
def test_a_momentum_of_rounding_turns_no_gimbal_round(axis):
    """Which sign of 1e-16 is left of a zero component differs from processor to processor."""
    momentum_n_m_s = np.array([0.0, 0.0, -40.0])
    found = []
    for left_n_m_s in (1e-16, -1e-16):
        momentum_n_m_s[axis] = left_n_m_s
        found.append(ARRAY.gimbal_angles(momentum_n_m_s))
    np.testing.assert_allclose(*found, rtol=0, atol=1e-12)
