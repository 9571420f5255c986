"""The baseline is the paper's: its durations, its cubic, its filter, and what it breaks."""

import math

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter
from slew_cases import Case, deg_state

from planner.motion.baseline.paper_cubic import (
    cubic_profile,
    in_paper_time,
    paper_duration_s,
    paper_slew,
)
from planner.motion.slew.problem import AxisState
from planner.world.scenario import SlewOptions

UNFILTERED = SlewOptions(filter_cutoff_hz=None)


def slew(start, end, duration_s=1e3):
    return Case(start, end).problem(duration_s)


def test_duration_by_hand():
    """Eq. 12 with 2 deg/s and 0.8 deg/s2: 60/2 + |0.4 - 2|/0.8 + |2 - 0.8|/0.8 = 33.5 s."""
    problem = slew((deg_state(10, 0.4),), (deg_state(70, 0.8),))
    assert paper_duration_s(problem) == pytest.approx(33.5, abs=1e-9)
    backwards = slew((deg_state(70, 0.4),), (deg_state(10, 0.8),))
    assert paper_duration_s(backwards) == pytest.approx(30 + 3.0 + 3.5, abs=1e-9)


def test_an_axis_that_rests_waits_for_the_paper_s_duration_in_whole_rows():
    end = deg_state(70, 0.83)
    resting, moving = slew((deg_state(10),), (end,)), slew((deg_state(10, 0.4),), (end,))
    # 30 + 2/0.8 + (2 - 0.83)/0.8 = 33.9625 s
    assert in_paper_time(resting).duration_s == pytest.approx(34.0, abs=1e-9)
    assert in_paper_time(moving) is moving
    assert in_paper_time(slew((deg_state(10),), (end,), 20.0)).duration_s == 20.0


def test_cubic_matches_both_ends():
    start, end = deg_state(-12, 1.3), deg_state(48, -0.7)
    angle, rate, _, _ = cubic_profile(start, end, 33.0).evaluate(np.array([0.0, 33.0]))
    np.testing.assert_allclose(np.degrees(angle), [-12, 48], atol=1e-10)
    np.testing.assert_allclose(np.degrees(rate), [1.3, -0.7], atol=1e-10)


def random_slews(count, start_rate_deg_s, end_rate_deg_s):
    rng = np.random.default_rng(16)
    for _ in range(count):
        start, end = (
            tuple(deg_state(rng.uniform(-175, 175), rng.uniform(-rate, rate)) for _ in "ab")
            for rate in (start_rate_deg_s, end_rate_deg_s)
        )
        yield slew(start, end, paper_duration_s(slew(start, end)))


def broken(solution):
    return {v.limit for v in solution.violations} & {"angle", "rate", "acceleration"}


def test_from_rest_to_rest_it_breaks_nothing():
    for problem in random_slews(300, 0.0, 0.0):
        assert not broken(paper_slew(problem, UNFILTERED))


def test_from_moving_starts_it_breaks_limits_in_a_third_of_the_cases():
    """2 deg/s at the start, 1 deg/s of the track at the end: 32 % in the design study."""
    solutions = [paper_slew(problem, UNFILTERED) for problem in random_slews(600, 2.0, 1.0)]
    share = sum(bool(broken(solution)) for solution in solutions) / len(solutions)
    assert share == pytest.approx(0.32, abs=0.06)  # 3 sigma of 600 draws
    assert any("angle" in broken(solution) for solution in solutions)


@pytest.mark.parametrize("cutoff_hz", [2.0, 0.2])
@pytest.mark.parametrize("compensated", [True, False])
def test_filter_is_a_first_order_low_pass(cutoff_hz, compensated):
    """Against SciPy's discretised filter fed with the same cubic."""
    lag_s = 1.0 / (2.0 * math.pi * cutoff_hz)
    start, end, duration_s = deg_state(10, 0.5), deg_state(70, 0.8), 34.0
    options = SlewOptions(filter_cutoff_hz=cutoff_hz, filter_lag_compensation=compensated)
    solution = paper_slew(slew((start,), (end,), duration_s), options)
    ahead_s = lag_s if compensated else 0.0
    x = cubic_profile(
        AxisState(
            angle_rad=start.angle_rad + lag_s * start.rate_rad_s, rate_rad_s=start.rate_rad_s
        ),
        AxisState(angle_rad=end.angle_rad + ahead_s * end.rate_rad_s, rate_rad_s=end.rate_rad_s),
        duration_s,
    )
    step_s = 1e-3
    t_s = np.arange(0.0, duration_s, step_s)
    # First-order hold: exact for the straight lines between samples of a slow cubic.
    numerator, denominator, _ = cont2discrete(([1.0], [lag_s, 1.0]), step_s, method="foh")
    command = x.evaluate(t_s)[0]
    state = start.angle_rad - numerator[0, 0] * command[0]
    filtered, _ = lfilter(numerator[0], denominator, command, zi=[state])
    planned = solution.profiles[0].evaluate(t_s)[0]
    np.testing.assert_allclose(planned, filtered, rtol=0, atol=5e-9)  # 1 mas; step^2 of the hold
    assert planned[0] == pytest.approx(start.angle_rad, abs=1e-12)
    assert solution.profiles[0].evaluate(np.zeros(1))[1][0] == pytest.approx(
        start.rate_rad_s, abs=1e-12
    )


def test_filter_leaves_arcseconds_at_the_join():
    """Lag-compensated: 3.8 arcsec at 2 Hz, 242 at 0.2 Hz in the design study, as lag squared."""
    errors_arcsec = {}
    for cutoff_hz in (2.0, 0.2):
        options = SlewOptions(filter_cutoff_hz=cutoff_hz)
        left = [
            np.degrees(np.abs(paper_slew(p, options).end_error_rad).max()) * 3600
            for p in random_slews(200, 2.0, 1.0)
        ]
        errors_arcsec[cutoff_hz] = float(np.median(left))
    assert errors_arcsec[2.0] == pytest.approx(3.8, rel=0.4)  # its draws are not ours
    assert errors_arcsec[0.2] == pytest.approx(242.0, rel=0.4)
