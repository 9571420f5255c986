"""Piecewise polynomials, their extremes, the flown Hermite and the comparison are right."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BPoly, CubicHermiteSpline, PPoly

from planner.motion.baseline.compare import compare_with_spline
from planner.motion.pointing.hermite import cubic_range, quintic_motion
from planner.motion.slew.closed_forms import JerkPhase, least_jerk_profile, profile_from_jerk
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.motion.slew.solution import AxisProfile, obeys
from planner.world.platforms import ISS_HRC, AxisLimits
from planner.world.scenario import SlewOptions

SEEDS = st.integers(0, 2**32 - 1)


@given(seed=SEEDS)
def test_values_and_extremes_agree_with_scipy(seed):
    rng = np.random.default_rng(seed)
    breakpoints = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 3.0, 6))])
    profile = AxisProfile(breakpoints_s=breakpoints, coefficients=rng.normal(size=(6, 6)))
    peer = PPoly(profile.coefficients[:, ::-1].T, breakpoints)
    t_s = np.linspace(0.0, breakpoints[-1], 20_001)
    values = profile.evaluate(t_s)
    for order in range(4):
        expected = peer.derivative(order)(t_s) if order else peer(t_s)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(values[order], expected, rtol=0, atol=1e-12 * scale)
        # The pieces jump, so each is sampled to its own end.
        pieces = [np.polynomial.Polynomial(c).deriv(order) for c in profile.coefficients]
        expected = np.concatenate(
            [
                piece(np.linspace(0.0, width, 4001))
                for piece, width in zip(pieces, np.diff(breakpoints), strict=True)
            ]
        )
        extreme = profile.extremes[order]
        # A sampled extreme misses the true one by at most a curvature's worth of half a step.
        assert extreme.greatest >= expected.max() - 1e-12 * scale
        assert extreme.greatest <= expected.max() + 1e-4 * scale
        assert extreme.least <= expected.min() + 1e-12 * scale
        assert extreme.least >= expected.min() - 1e-4 * scale


D, T = 0.4, 50.0
START, END = AxisState(angle_rad=-D), AxisState(angle_rad=D)
BANG = 64.0 * D / T**3
# 2 D from rest to rest, and the greatest rate, acceleration and jerk on the way: of a quintic in
# the middle of its one piece, of a jerk switched every T/4 where pieces meet.
MOTIONS = {
    "quintic": (
        least_jerk_profile(START, END, T),
        (3.75 * D / T, 20.0 * D / math.sqrt(3.0) / T**2, 120.0 * D / T**3),
    ),
    "bang-bang": (
        profile_from_jerk(START, [JerkPhase(T / 4.0, sign * BANG) for sign in (1, -1, -1, 1)]),
        (BANG * (T / 4.0) ** 2, BANG * T / 4.0, BANG),
    ),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize(("share", "keeps"), [(1.0 + 1e-8, True), (1.0 - 1e-8, False)])
def test_a_limit_is_kept_to_a_hundred_millionth_of_it(motion, order, share, keeps):
    profile, peaks = MOTIONS[motion]
    bounds = 2.0 * np.array([D, *peaks])
    bounds[order] *= share / 2.0
    angle, rate, acceleration, jerk = bounds.tolist()
    limits = AxisLimits(
        angle_min_rad=-angle,
        angle_max_rad=angle,
        rate_max_rad_s=rate,
        acceleration_max_rad_s2=acceleration,
        jerk_max_rad_s3=jerk,
    )
    assert obeys(profile, START, END, limits) is keeps


@given(seed=SEEDS)
def test_cubic_range_agrees_with_scipy_hermite(seed):
    rng = np.random.default_rng(seed)
    angle, rate = rng.normal(size=(9, 2)), rng.normal(scale=5.0, size=(9, 2))
    ranges = cubic_range(0.2, angle, rate)
    peer = CubicHermiteSpline(np.arange(9) / 5.0, angle, rate)
    s = np.linspace(0.0, 0.2, 401)
    for cell in range(8):
        values = (
            peer(cell / 5.0 + s),
            peer.derivative(1)(cell / 5.0 + s),
            peer.derivative(2)(cell / 5.0 + s[:-1]),
        )
        for found, sampled in zip(ranges[:2], values[:2], strict=True):
            span = np.ptp(sampled, axis=0) + 1e-9
            assert np.all(found[1][cell] >= sampled.max(axis=0) - 1e-12)
            assert np.all(found[1][cell] <= sampled.max(axis=0) + 1e-4 * span)
            assert np.all(found[0][cell] <= sampled.min(axis=0) + 1e-12)
            assert np.all(found[0][cell] >= sampled.min(axis=0) - 1e-4 * span)
        straight = values[2]
        ends = np.sort(np.stack([straight[0], 2 * straight[-1] - straight[-2]]), axis=0)
        np.testing.assert_allclose(ranges[2][:, cell], ends, rtol=0, atol=1e-8)


@given(seed=SEEDS)
def test_quintic_motion_agrees_with_scipy(seed):
    rng = np.random.default_rng(seed)
    rows_s = np.cumsum(rng.uniform(0.1, 0.4, 8))
    motion = rng.normal(size=(3, 8, 2))
    t_s = np.linspace(rows_s[0], rows_s[-1] - 1e-9, 300)
    found = quintic_motion(t_s, rows_s, *motion)
    for axis in range(2):
        peer = BPoly.from_derivatives(rows_s, motion[:, :, axis].T)
        for order in range(3):
            expected = peer.derivative(order)(t_s) if order else peer(t_s)
            np.testing.assert_allclose(
                found[order][:, axis], expected, rtol=0, atol=1e-10 * np.abs(expected).max()
            )


def test_comparison_shows_what_the_cubic_costs():
    """Rest to rest in T: the cubic's peak rate is 1.5 Δ/T, its jerk 12 Δ/T^3, the quintic's
    squared jerk 720 Δ^2/T^5 (calculus of variations)."""
    distance, T = math.radians(30.0), 60.0
    problem = SlewProblem(
        axis_names=("alpha",),
        limits=(ISS_HRC.outer_limits,),
        start=(AxisState(angle_rad=0.0),),
        end=(AxisState(angle_rad=distance),),
        duration_s=T,
    )
    options = SlewOptions(filter_cutoff_hz=None)
    comparison = compare_with_spline(optimal_slew(problem), options, None)
    spline, ocp = comparison.spline["alpha"], comparison.ocp["alpha"]
    np.testing.assert_allclose(spline.peak_rate_rad_s, 1.5 * distance / T, rtol=1e-9)
    np.testing.assert_allclose(spline.peak_acceleration_rad_s2, 6.0 * distance / T**2, rtol=1e-9)
    assert spline.peak_jerk_rad_s3 is None  # the acceleration jumps at the ends
    assert spline.jerk_squared_integral_rad2_s5 is None
    # A jerk linear on 16 spans misses the quintic's by a share of 1/16^4 of the cost.
    np.testing.assert_allclose(
        ocp.jerk_squared_integral_rad2_s5, 720.0 * distance**2 / T**5 * (1.0 + 16.0**-4), rtol=1e-6
    )
    np.testing.assert_allclose(ocp.peak_rate_rad_s, 1.875 * distance / T, rtol=2e-5)
    assert comparison.least_s < comparison.paper_s
