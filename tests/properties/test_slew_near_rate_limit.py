"""Slews are found whose acceleration must be taken back at once, lest the rate pass its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from slew_cases import LIMITS, deg_state, sampled

from planner.base.errors import InfeasibleSlew
from planner.motion.slew import (
    SlewProblem,
    next_duration_s,
    optimal_slew,
    require_brakable,
    verdict,
)
from planner.motion.slew.stops import margins_on_rows

ROUNDING = 2e-9  # of the limit: degrees to radians and back, and a sum of 100 terms
RATE_MAX_DEG_S = 3.0


def critical_state(jerk_deg_s3, acceleration_deg_s2, spare_deg_s):
    """Braked with all its jerk at once, the rate comes within spare_deg_s of its limit."""
    rise = acceleration_deg_s2**2 / (2.0 * jerk_deg_s3)
    sign = np.sign(acceleration_deg_s2)
    rate = sign * (RATE_MAX_DEG_S - spare_deg_s - rise)
    return deg_state(-20.0 * sign, rate, acceleration_deg_s2)


@pytest.mark.parametrize("spare_deg_s", [0.0, 1e-3, 0.02])
@pytest.mark.parametrize(
    ("jerk_deg_s3", "acceleration_deg_s2", "duration_s"),
    [(1.0, 1.0, 140.0), (0.37, -1.0, 60.0), (0.5, 0.33, 30.0), (0.083, -0.7, 600.0)],
)
@pytest.mark.parametrize("leads", [True, False])
def test_found_at_either_end(spare_deg_s, jerk_deg_s3, acceleration_deg_s2, duration_s, leads):
    limits = replace(LIMITS, jerk_max_rad_s3=np.radians(jerk_deg_s3))
    moving = critical_state(jerk_deg_s3, acceleration_deg_s2, spare_deg_s)
    resting = deg_state(35.0)
    start, end = (moving, resting) if leads else (resting, moving.backwards())
    problem = SlewProblem(
        axis_names=("alpha",), limits=(limits,), start=(start,), end=(end,), duration_s=duration_s
    )
    solution = optimal_slew(problem, on_rows=True)
    [profile], [status] = solution.profiles, solution.status
    assert len(set(status.split(", "))) == len(status.split(", "))  # no method twice
    for values, (low, high) in zip(sampled(profile), limits.bounds, strict=True):
        assert values.min() >= low - ROUNDING * (high - low)
        assert values.max() <= high + ROUNDING * (high - low)
    wanted = np.array(
        [[one.angle_rad, one.rate_rad_s, one.acceleration_rad_s2] for one in (start, end)]
    )
    np.testing.assert_allclose(profile.end_values[:, :3], wanted, rtol=0, atol=1e-8)  # 2 mas


@pytest.mark.parametrize(
    ("state", "limit"),
    [
        (deg_state(0.0, 2.489, 1.05), "rate"),  # 2.489 + 1.05^2 / 2 = 3.04 deg/s
        (deg_state(0.0, -2.6, -0.95), "rate"),
        (deg_state(172.1, 2.0, 0.0), "angle"),  # 2^2 / 2 + 2 / 2 = 3 deg
        (deg_state(-174.0, -1.5, 0.2), "angle"),
    ],
)
def test_what_cannot_be_braked_is_refused_before_anything_else(state, limit):
    calm = deg_state(0.0)
    with pytest.raises(InfeasibleSlew) as refused:
        require_brakable(("alpha", "beta"), (calm, state), (LIMITS, LIMITS))
    assert (refused.value.axis, refused.value.limit) == ("beta", limit)
    assert refused.value.field == "initial_state"
    assert "alpha" not in refused.value.detail


@pytest.mark.parametrize("leads", [True, False])
@pytest.mark.parametrize(
    ("moving", "what"),
    [
        (deg_state(0.0, 2.55, 1.0), "its rate limit"),  # 2.55 + 1 / 2 = 3.05 deg/s
        (deg_state(172.1, 2.0, 0.0), "its hard stop"),  # 3 deg on, as above
    ],
)
def test_a_refused_slew_says_which_of_its_ends_can_not_be_braked(moving, what, leads):
    resting = deg_state(35.0)
    start, end = (moving, resting) if leads else (resting, moving.backwards())
    problem = SlewProblem(
        axis_names=("alpha",), limits=(LIMITS,), start=(start,), end=(end,), duration_s=100.0
    )
    with pytest.raises(InfeasibleSlew) as refused:
        optimal_slew(problem)
    side = "start" if leads else "end"
    assert f"alpha can't keep {what} in a slew of 100.000 s" in refused.value.detail
    assert f"its motion at the {side} can't be braked in time" in refused.value.detail


@pytest.mark.parametrize("spare_deg", [1e-6, 3e-3, 0.3])
@pytest.mark.parametrize(("jerk_deg_s3", "rate_deg_s"), [(1.0, 2.0), (2.3, -1.2), (9.0, 0.3)])
@pytest.mark.parametrize("leads", [True, False])
def test_found_where_a_stop_is_all_but_met(spare_deg, jerk_deg_s3, rate_deg_s, leads):
    limits = replace(LIMITS, jerk_max_rad_s3=np.radians(jerk_deg_s3))
    still = deg_state(0.0, abs(rate_deg_s))
    way_deg, _ = stepped_deg(still, limits)
    sign = np.sign(rate_deg_s)
    moving = deg_state(sign * (175.0 - way_deg - spare_deg), rate_deg_s)
    start, end = (moving, deg_state(35.0)) if leads else (deg_state(35.0), moving.backwards())
    problem = SlewProblem(
        axis_names=("alpha",), limits=(limits,), start=(start,), end=(end,), duration_s=140.0
    )
    [profile] = optimal_slew(problem, on_rows=True).profiles
    for values, (low, high) in zip(sampled(profile), limits.bounds, strict=True):
        assert values.min() >= low - ROUNDING * (high - low)
        assert values.max() <= high + ROUNDING * (high - low)


def refusal_of(problem):
    """None where its rows carry it within the limits."""
    try:
        violations = optimal_slew(problem, on_rows=True).violations
    except InfeasibleSlew as refused:
        return refused
    assert violations == ()
    return None


def test_where_rows_are_too_few_one_more_is_enough():
    """Slews that must brake at once, in their least time and up to a tenth of a row more."""
    rng = np.random.default_rng(3)
    refused = tried = 0
    while tried < 6:
        jerk_deg_s3, acceleration = 10.0 ** rng.uniform(-0.3, 1.0), rng.uniform(0.3, 1.0)
        limits = replace(LIMITS, jerk_max_rad_s3=np.radians(jerk_deg_s3))
        start = critical_state(jerk_deg_s3, rng.choice([-1.0, 1.0]) * acceleration, 1e-3)
        end = deg_state(rng.uniform(-150.0, 150.0))
        least_rows = next_duration_s(start, end, limits, 0.0) * 5.0
        rows = math.ceil(least_rows)
        _, spare_rad_s = margins_on_rows(start, limits)
        if rows - least_rows > 0.1 or spare_rad_s < 0.0:
            continue
        tried += 1
        problem = SlewProblem(
            axis_names=("alpha",),
            limits=(limits,),
            start=(start,),
            end=(end,),
            duration_s=rows / 5.0,
        )
        short = refusal_of(problem)
        if short is None:
            continue
        refused += 1
        assert "one row more is enough" in str(short)
        longer = replace(problem, duration_s=(rows + 1) / 5.0)
        assert optimal_slew(longer, on_rows=True).violations == ()
    assert 0 < refused < tried


def test_a_stop_forbids_what_meets_it_braked_hardest():
    rng = np.random.default_rng(12)
    tried = 0
    while tried < 40:
        limits = replace(LIMITS, jerk_max_rad_s3=np.radians(10.0 ** rng.uniform(-1.0, 1.2)))
        rate, acceleration, sign = rng.uniform(0, 3), rng.uniform(-1, 1), rng.choice([-1.0, 1.0])
        way_deg, fastest = stepped_deg(deg_state(0.0, rate, acceleration), limits, 0.01)
        _, back = stepped_deg(deg_state(0.0, -rate, -acceleration), limits, 0.01)
        if max(fastest, back) > 2.99:  # it is the rate's limit that forbids it
            continue
        tried += 1
        for spare_deg, limit in ((0.01, None), (-0.01, "angle")):
            angle_deg = 175.0 - way_deg - spare_deg
            moving = deg_state(*(sign * np.array([angle_deg, rate, acceleration])))
            assert verdict(moving, deg_state(0.0), limits, 600.0).limit == limit
            assert verdict(deg_state(0.0), moving.backwards(), limits, 600.0).limit == limit


def stepped_deg(state, limits, step_s=0.2):
    """The greatest angle and rate upwards, from samples every 0.1 ms; the jerk is chosen anew
    each step_s."""
    jerk_max = np.degrees(limits.jerk_max_rad_s3)
    q, v, a = np.degrees([state.angle_rad, state.rate_rad_s, state.acceleration_rad_s2])
    farthest, fastest, t = q, v, np.linspace(0.0, step_s, round(step_s * 1e4) + 1)
    while v > 0.0 or a > 0.0:
        jerk = max(-jerk_max, (-1.0 - a) / step_s)
        angle = q + v * t + a * t**2 / 2 + jerk * t**3 / 6
        rate = v + a * t + jerk * t**2 / 2
        farthest, fastest = max(farthest, angle.max()), max(fastest, rate.max())
        q, v, a = angle[-1], rate[-1], a + step_s * jerk
    return farthest, fastest


def test_braking_on_rows_is_what_stepping_it_shows():
    rng = np.random.default_rng(11)
    for _ in range(200):
        limits = replace(LIMITS, jerk_max_rad_s3=np.radians(10.0 ** rng.uniform(-1.0, 1.2)))
        motion = rng.uniform([-150, -3, -1], [150, 3, 1])
        up, down = (stepped_deg(deg_state(*(sign * motion)), limits) for sign in (1.0, -1.0))
        angle_deg, rate_deg_s = np.degrees(margins_on_rows(deg_state(*motion), limits))
        # 0.1 ms beside a peak the rate is off by 16 deg/s3 (1e-4)^2 / 2, the angle by less.
        assert angle_deg == pytest.approx(175.0 - max(up[0], down[0]), abs=1e-7)
        assert rate_deg_s == pytest.approx(3.0 - max(up[1], down[1]), abs=1e-7)
