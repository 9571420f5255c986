"""Rates of Rodrigues parameters are SciPy's; a planned slew stands beside the textbook's."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, RotationSpline

from planner.base.commands import Motion
from planner.base.mrp import MrpMotion, body_motion, mrp_state
from planner.motion.attitude.problem import BodySlewProblem
from planner.motion.attitude.slew import solve_attitude_slew
from planner.motion.attitude.track import agility_limits
from planner.spacecraft.imaging.timeline import compare
from planner.spacecraft.vehicle import AgileSpacecraft


def test_rates_of_a_rodrigues_curve_are_scipys():
    t = np.linspace(0.0, 4.0, 9)
    spline = RotationSpline(t, Rotation.random(9, rng=1) ** 0.2)
    middle = spline(2.0)
    fine = np.array([1.2, 1.35, 1.7, 1.85, 2.2, 2.4, 2.7])  # off the knots, where it jumps
    step = 1e-3

    def sigma(x):
        return (middle.inv() * spline(x)).as_mrp()

    d1 = (sigma(fine + step) - sigma(fine - step)) / (2 * step)
    d2 = (sigma(fine + step) - 2 * sigma(fine) + sigma(fine - step)) / step**2
    motion = body_motion(MrpMotion(sigma(fine), d1, d2, np.zeros_like(d1)))
    # SciPy's rates are in body axes too; differences over 1 ms are good to 1e-5
    np.testing.assert_allclose(motion.omega_body_rad_s, spline(fine, 1), atol=1e-5)
    np.testing.assert_allclose(motion.alpha_body_rad_s2, spline(fine, 2), atol=1e-4)


def test_rodrigues_rates_invert():
    random = np.random.default_rng(3)
    sigma, omega, alpha = random.uniform(-0.4, 0.4, (3, 50, 3))
    motion = body_motion(MrpMotion(*mrp_state(sigma, omega, alpha), np.zeros_like(sigma)))
    np.testing.assert_allclose(motion.omega_body_rad_s, omega, atol=1e-13)
    np.testing.assert_allclose(motion.alpha_body_rad_s2, alpha, atol=1e-13)


def at_rest(angle_deg):
    still = np.zeros((1, 3))
    return Motion(Rotation.from_euler("Z", [[angle_deg]], degrees=True).as_quat(), still, still)


def test_a_slew_stands_beside_its_baselines():
    """About a principal axis from rest the paper's turn takes angle/rate + rate/acceleration, and
    a smooth one of 18 s shakes less than the one about the Euler axis of that time."""
    body, asked = AgileSpacecraft().platform(), at_rest(20.0)
    problem = BodySlewProblem(
        start=at_rest(0.0), goal=asked, first_arrival_row=90, limits=agility_limits(body)
    )
    slew = solve_attitude_slew(problem)
    compared = SimpleNamespace(**compare(slew.motion, body))
    rate, acceleration, jerk = body.envelope.by_order_rad[:, 2].tolist()
    expected_s = math.radians(20.0) / rate + rate / acceleration
    assert compared.bang_coast_bang_s == pytest.approx(expected_s, rel=1e-3)
    assert compared.eigenaxis_s == pytest.approx(expected_s + acceleration / jerk, rel=1e-3)
    assert compared.duration_s == 18.0
    assert compared.angle_rad == pytest.approx(math.radians(20.0))
    assert compared.torque_rate_peak_n_m_s < compared.eigenaxis_torque_rate_peak_n_m_s
