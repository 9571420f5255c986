"""All feasible slews are solved, within every limit at every instant, and the others refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from slew_cases import LIMITS, deg_state, draw_cases, least_shared_s, sampled

from planner.base.errors import InfeasibleSlew
from planner.motion.pointing.hermite import cubic_range
from planner.motion.slew import optimal
from planner.motion.slew.closed_forms import profile_lasting
from planner.motion.slew.feasibility import next_duration_s
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem

SLACKS = (1.0, 1.003, 1.009, 1.011, 1.05, 1.2, 1.7, 3.0, 5.0)
ROUNDING = 2e-9  # of the limit: degrees to radians and back, and a sum of 100 terms


def assert_flown(profile, start, end):
    """From one state to the other, and within the limits at every millisecond."""
    motion = sampled(profile)
    for values, (low, high) in zip(motion, LIMITS.bounds, strict=True):
        slack = ROUNDING * (high - low) / 2.0
        assert values.min() >= low - slack
        assert values.max() <= high + slack
    for values, name, tolerance in zip(
        motion,
        ("angle_rad", "rate_rad_s", "acceleration_rad_s2"),
        (1e-8, 1e-9, 1e-9),  # of the angle 2 mas, 1/300 of a camera pixel
        strict=False,
    ):
        assert values[0] == pytest.approx(getattr(start, name), abs=tolerance)
        assert values[-1] == pytest.approx(getattr(end, name), abs=tolerance)


def test_100_random_slews_are_all_solved_within_limits():
    for number, case in enumerate(draw_cases(seed=100, count=100)):
        slack = SLACKS[number % len(SLACKS)]
        duration_s = least_shared_s(case) * slack
        gaps = [
            next_duration_s(start, end, LIMITS, duration_s) > duration_s * (1.0 + 1e-9)
            for start, end in zip(case.start, case.end, strict=True)
        ]
        assert not any(gaps)  # none of these draws falls into a gap: nothing is skipped
        solution = optimal_slew(case.problem(duration_s))
        assert solution.duration_s == pytest.approx(duration_s, rel=1e-9)
        assert solution.violations == ()
        for axis, profile in enumerate(solution.profiles):
            assert_flown(profile, case.start[axis], case.end[axis])


def test_a_slew_proven_to_exist_is_made_although_the_solver_fails(monkeypatch):
    monkeypatch.setattr(optimal, "find_smoothest", lambda *_, **__: None)
    fallen_back = 0
    for case in draw_cases(seed=10, count=30):
        solution = optimal_slew(case.problem(1.2 * least_shared_s(case)))
        fallen_back += solution.status.count("feasible, not the smoothest")
        for axis, profile in enumerate(solution.profiles):
            assert_flown(profile, case.start[axis], case.end[axis])
    assert fallen_back > 10


def test_with_hours_to_spare_an_axis_rests_where_it_began():
    start, end = deg_state(10.0, 1.0, 0.2), deg_state(-40.0, -0.5)
    profile = profile_lasting(start, end, LIMITS, 7200.0)
    assert profile.duration_s == pytest.approx(7200.0, rel=1e-9)
    assert_flown(profile, start, end)
    angle, rate, _, _ = profile.evaluate(np.array([3600.0]))
    assert angle[0] == pytest.approx(start.angle_rad, abs=1e-9)
    assert rate[0] == 0.0


def test_an_axis_that_takes_hours_takes_its_least_time_and_no_less():
    """Ruckig counts no more than 7600 s in seconds.  A trapezium of rates takes D/v + v/a + a/j."""
    limits = replace(
        LIMITS,
        rate_min_rad_s=0.0,
        rate_max_rad_s=1e-4,
        acceleration_max_rad_s2=1e-6,
        jerk_max_rad_s3=1e-7,
    )
    start, end = AxisState(angle_rad=0.0), AxisState(angle_rad=1.0)
    for at_least_s in (0.0, 1000.0):
        least_s = next_duration_s(start, end, limits, at_least_s)
        assert least_s == pytest.approx(1e4 + 100.0 + 10.0, rel=1e-9)


@pytest.mark.parametrize("rate_deg_s", [0.0, 0.018])
def test_a_slow_axis_takes_over_an_hour_and_is_told_what_it_lacks(rate_deg_s):
    """100 deg at 0.02 deg/s take 5,000 s from rest, and what gathering the rate takes."""
    limits = replace(LIMITS, rate_min_rad_s=0.0, rate_max_rad_s=math.radians(0.02))
    problem = SlewProblem(
        axis_names=("alpha",),
        limits=(limits,),
        start=(deg_state(0.0, rate_deg_s),),
        end=(deg_state(100.0),),
        duration_s=7200.0,
    )
    solution = optimal_slew(problem)
    assert solution.status == ("optimal",)
    for short_s in (4000.0, 4999.8):
        with pytest.raises(InfeasibleSlew, match=rf"5000\.\d+ s to slew but {short_s:.3f} s are"):
            optimal_slew(replace(problem, duration_s=short_s))


def test_too_short_a_time_is_refused_and_the_named_time_works():
    for number, case in enumerate(draw_cases(seed=7, count=36)):
        least_s = least_shared_s(case)
        share = (0.3, 0.8, 0.97)[number % 3]
        with pytest.raises(InfeasibleSlew) as refused:
            optimal_slew(case.problem(least_s * share))
        assert refused.value.axis in ("alpha", "beta")
        assert refused.value.limit == "duration"
        assert "needs" in str(refused.value)
        assert optimal_slew(case.problem(least_s)).violations == ()


def rows_carry(solution, rows, limits=LIMITS, off_arcsec=0.1, rounding=ROUNDING):
    """Per axis, whether the Hermite of its rows keeps the limits and off_arcsec of the plan."""
    t_s = np.arange(rows + 1) / 5.0
    angle, rate, _, _ = solution.motion(t_s)
    carried = np.ones(angle.shape[1], dtype=bool)
    for (least, greatest), (low, high) in zip(
        cubic_range(0.2, angle, rate), limits.bounds, strict=True
    ):
        slack = rounding * (high - low)
        carried &= (least.min(axis=0) >= low - slack) & (greatest.max(axis=0) <= high + slack)
    # The Hermite by its definition, at places the planner doesn't sample.
    for s in (0.21, 0.5, 0.83):
        planned = solution.motion(t_s[:-1] + 0.2 * s)[0]
        hermite = (
            (1 + 2 * s) * (1 - s) ** 2 * angle[:-1]
            + s**2 * (3 - 2 * s) * angle[1:]
            + 0.2 * s * (1 - s) ** 2 * rate[:-1]
            - 0.2 * s**2 * (1 - s) * rate[1:]
        )
        carried &= np.degrees(np.abs(hermite - planned).max(axis=0)) * 3600.0 <= off_arcsec
    return carried


def test_rows_carry_the_slew_within_limits_and_to_a_tenth_of_an_arcsecond():
    repaired = left_alone = 0
    for number, case in enumerate(draw_cases(seed=9, count=36)):
        slack = (1.0, 1.02, 1.2, 2.0)[number % 4]
        rows = math.ceil(least_shared_s(case) * slack * 5.0) + 1
        smoothest = optimal_slew(case.problem(rows / 5.0))
        solution = optimal_slew(case.problem(rows / 5.0), on_rows=True)
        assert rows_carry(solution, rows).all()
        repaired += sum("rows" in status for status in solution.status)
        for axis in np.flatnonzero(rows_carry(smoothest, rows, off_arcsec=0.09, rounding=0.0)):
            for part in ("breakpoints_s", "coefficients"):
                flown, free = (
                    getattr(solution.profiles[axis], part),
                    getattr(smoothest.profiles[axis], part),
                )
                np.testing.assert_array_equal(flown, free)
            left_alone += 1
    assert min(repaired, left_alone) > 0  # otherwise this test tests nothing


@pytest.mark.parametrize("duration_s", [1.0, 1.6, 2.4])
def test_rows_carry_a_short_slew_whose_jerk_changes_much_from_row_to_row(duration_s):
    """A quintic D from rest to rest: its fourth derivative, 360 D/T^4 at either end, takes the
    Hermite of its rows (0.2 s)^4/384 of that away, 0.84, 0.33 and 0.15 arcsec."""
    limits = replace(LIMITS, jerk_max_rad_s3=np.radians(10.0))
    distance_rad = 0.9 * limits.acceleration_max_rad_s2 * duration_s**2 / (10.0 / math.sqrt(3.0))
    problem = SlewProblem(
        axis_names=("alpha",),
        limits=(limits,),
        start=(AxisState(angle_rad=0.3),),
        end=(AxisState(angle_rad=0.3 + distance_rad),),
        duration_s=duration_s,
    )
    smoothest = optimal_slew(problem)
    rows = round(duration_s * 5.0)
    assert not rows_carry(smoothest, rows, limits).any()
    assert rows_carry(optimal_slew(problem, on_rows=True), rows, limits).all()
