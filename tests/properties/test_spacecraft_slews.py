"""Slews keep their limits and ends, and the OCP is never worse than the eigenaxis."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, RotationSpline

from planner.base.errors import InfeasibleSlew
from planner.base.mrp import MrpMotion, body_motion, mrp_state
from planner.spacecraft.slews.eigenaxis import eigenaxis_slew
from planner.spacecraft.slews.slew_choice import compare, quickest_slew, slew_onto, smooth_slew
from planner.spacecraft.slews.slew_problem import AttitudeSlewProblem, EndState
from planner.spacecraft.vehicle.definition import SlewLimits

J = np.array([800.0, 500.0, 800.0])
STILL = np.zeros(3)


def problem(angle_deg, axis, momentum=STILL, limits=None, omega=STILL, omega_end=STILL):
    begin = Rotation.from_euler("XYZ", [0.4, -1.0, 2.0])
    vector = math.radians(angle_deg) * np.array(axis) / np.linalg.norm(axis)
    return AttitudeSlewProblem(
        start=EndState(
            q_body_from_eci=begin.inv(), omega_body_rad_s=omega, alpha_body_rad_s2=STILL
        ),
        end=EndState(
            q_body_from_eci=(begin * Rotation.from_rotvec(vector)).inv(),
            omega_body_rad_s=omega_end,
            alpha_body_rad_s2=STILL,
        ),
        momentum_eci_n_m_s=momentum,
        inertia_kg_m2=J,
        limits=limits or SlewLimits(),
    )


def random_problem(seed):
    random = np.random.default_rng(seed)
    moving = seed % 2
    rates = np.deg2rad(random.uniform(-0.5, 0.5, (2, 3))) * moving
    limits = SlewLimits()
    if seed % 4 < 2:
        limits = SlewLimits(rate_axis_rad_s=math.radians(3.5), rate_rad_s=math.radians(2.0))
    return problem(
        random.uniform(2.0, 60.0),
        random.standard_normal(3),
        random.uniform(-5.0, 5.0, 3),
        limits,
        rates[0],
        rates[1],
    )


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


def test_eigenaxis_bang_coast_bang_takes_the_textbook_time():
    limits = SlewLimits()
    slew = eigenaxis_slew(problem(20.0, [0, 0, 1]), jerk=False)
    acceleration, rate = limits.torque_n_m / 800.0, limits.rate_axis_rad_s
    expected = math.radians(20.0) / rate + rate / acceleration
    assert slew.duration_s == pytest.approx(expected, rel=1e-9)


def test_eigenaxis_turn_is_a_rotation_about_one_axis():
    asked = problem(40.0, [1, 2, -1])
    slew = eigenaxis_slew(asked)
    q_body_from_eci, _ = slew.attitude_at(np.linspace(0.0, slew.duration_s, 20))
    vectors = (asked.start.q_body_from_eci * q_body_from_eci.inv()).as_rotvec()
    across = np.cross(vectors, np.array([1, 2, -1]) / math.sqrt(6.0))
    assert np.abs(across).max() < 1e-9


@pytest.mark.parametrize("seed", range(8))
def test_quickest_turn_is_never_longer_than_the_eigenaxis(seed):
    asked = random_problem(seed)
    baseline = eigenaxis_slew(asked)
    assert baseline.loads.share_of(asked.limits) <= 1.001
    slew = quickest_slew(asked)
    assert slew.duration_s <= baseline.duration_s
    assert slew.loads.share_of(asked.limits) <= 1.001


@pytest.mark.parametrize("seed", range(8, 16))
def test_smooth_turn_meets_both_ends_and_every_limit(seed):
    asked = random_problem(seed)
    seconds = 1.2 * eigenaxis_slew(asked).duration_s
    slew = smooth_slew(asked, seconds)
    assert slew.method == "ocp"
    q_body_from_eci, motion = slew.attitude_at(np.array([0.0, seconds]))
    for k, end in enumerate((asked.start, asked.end)):
        assert (q_body_from_eci[k] * end.q_body_from_eci.inv()).magnitude() < 1e-7
        np.testing.assert_allclose(motion.omega_body_rad_s[k], end.omega_body_rad_s, atol=1e-7)
        np.testing.assert_allclose(motion.alpha_body_rad_s2[k], end.alpha_body_rad_s2, atol=1e-6)
    # Limits by differences of the attitudes alone, none of the solver's formulas.
    t = np.linspace(0.0, seconds, 4001)
    fine, _ = slew.attitude_at(t)
    omega = (fine[:-1] * fine[1:].inv()).as_rotvec() / t[1]
    alpha = np.diff(omega, axis=0) / t[1]
    total = fine[1:-1].apply(asked.momentum_eci_n_m_s)
    middle = 0.5 * (omega[:-1] + omega[1:])
    torque = np.linalg.norm(J * alpha + np.cross(middle, total), axis=1)
    stored = np.linalg.norm(total - J * middle, axis=1)
    limits = asked.limits
    assert np.abs(omega).max() <= limits.rate_axis_rad_s * 1.002
    assert np.linalg.norm(omega, axis=1).max() <= limits.rate_rad_s * 1.002
    assert torque.max() <= limits.torque_n_m * 1.005  # differences over 5 ms
    assert stored.max() <= limits.momentum_sphere_n_m_s * 1.001


def test_momentum_sphere_binds():
    """With 45 N m s along Z stored, turning about Z at 1.5 deg/s would need 66."""
    inside = problem(30.0, [0, 0, 1])
    total = inside.start.q_body_from_eci.inv().apply([0.0, 0.0, -45.0])
    loaded = dataclasses.replace(inside, momentum_eci_n_m_s=total)
    slew = quickest_slew(loaded)
    assert slew.loads.momentum_n_m_s <= 60.06
    assert slew.duration_s > quickest_slew(inside).duration_s + 2.0


def test_too_short_a_turn_is_refused_with_the_time_it_needs():
    with pytest.raises(InfeasibleSlew, match=r"needs about 2[0-9]\.[0-9] s"):
        smooth_slew(problem(30.0, [0, 0, 1]), 10.0)


def test_comparison_names_both_baselines():
    asked = problem(20.0, [0, 0, 1])
    compared = compare(asked, smooth_slew(asked, 18.0))
    assert compared.bang_coast_bang_s < compared.eigenaxis_s < compared.duration_s
    assert compared.torque_rate_peak_n_m_s < compared.eigenaxis_torque_rate_peak_n_m_s


@pytest.mark.parametrize(
    ("seed", "objective", "time_from"),
    [(None, "minimum_time", "eigenaxis"), (3, "minimum_time", "ocp"), (3, "smooth", None)],
)
def test_a_turn_says_what_found_its_least_time(seed, objective, time_from):
    """About a principal axis from rest, with limits on magnitudes, nothing beats the eigenaxis."""
    magnitudes = SlewLimits(rate_axis_rad_s=math.radians(3.5), rate_rad_s=math.radians(2.0))
    asked = problem(20.0, [0, 0, 1], limits=magnitudes) if seed is None else random_problem(seed)
    slew = slew_onto(lambda _: asked, 100.0, objective)
    assert compare(asked, slew).time_from == time_from
