"""Slews near their limits: the lower bound of their cost, the earliest join, and the rate limit."""

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize
from slew_cases import LIMITS, NAMES, deg_state, draw_cases, least_shared_s, sampled

from planner.base.errors import InfeasibleSlew
from planner.motion.pointing.track import AxisTrack
from planner.motion.slew import (
    SlewProblem,
    next_duration_s,
    optimal_slew,
    require_brakable,
    verdict,
)
from planner.motion.slew.lower_bound import lower_bound
from planner.motion.slew.stops import margins_on_rows
from planner.planning.sessions.platforms.two_axis.earliest_join import Approach, track_states
from planner.world.scenario import SlewOptions

KNOTS = np.linspace(0.0, 1.0, 9)
CONTACTS = np.array([[0.2, 1.0, 300.0], [0.45, 0.0, -500.0], [0.7, 2.0, 20.0], [0.97, 1.0, -900.0]])


def dual_by_quadrature(prices, ends, limits, contacts):
    """The least of half the squared jerk less what prices pay, written from the start's side alone.

    prices: of the end's acceleration, rate, angle.
    """
    (q0, v0, a0), end = ends
    drift = (lambda t: q0 + v0 * t + a0 * t * t / 2.0, lambda t: v0 + a0 * t, lambda _: a0)

    def costate(tau):
        left = 1.0 - tau
        w = prices[0] + prices[1] * left + prices[2] * left**2 / 2.0
        for at, order, multiplier in contacts:
            if tau < at:
                w -= multiplier * ((at - tau) ** 2 / 2.0, at - tau, 1.0)[int(order)]
        return w

    def cheapest(tau):
        w = costate(tau)
        u = np.clip(w, *limits[3])
        return u * u / 2.0 - u * w

    owed = sum(
        multiplier * (drift[int(order)](at) - limits[int(order), 1 if multiplier > 0.0 else 0])
        for at, order, multiplier in contacts
    )
    moved = [end[2] - drift[2](1.0), end[1] - drift[1](1.0), end[0] - drift[0](1.0)]
    integral = quad(cheapest, 0.0, 1.0, points=contacts[:, 0], limit=400, epsabs=1e-9)[0]
    return integral + owed + np.dot(prices, moved)


@pytest.mark.parametrize("jerk_max", [40.0, 1e3])
def test_it_is_the_dual_at_its_best_prices(jerk_max):
    """Against quadrature and a general minimiser; they agree to what the quadrature is good for."""
    ends = np.array([[0.0, 0.4, -1.0], [1.0, -0.2, 0.5]])
    limits = np.array([[-0.5, 1.1], [-1.6, 1.6], [-9.0, 9.0], [-jerk_max, jerk_max]])
    bound, _ = lower_bound(ends, limits, CONTACTS, KNOTS, np.zeros((8, 2)))

    def less(prices):
        return -dual_by_quadrature(prices, ends, limits, CONTACTS)

    found = minimize(
        less,
        np.zeros(3),
        method="Nelder-Mead",
        options={"maxiter": 4000, "xatol": 1e-6, "fatol": 1e-9},
    )
    assert bound == pytest.approx(-2.0 * found.fun, rel=1e-5, abs=1e-4)


def test_no_motion_on_a_fine_grid_costs_less():
    """Jerk constant on 300 cells, limits kept at their ends, is a motion up to 1e-4 of a limit."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        jerk = rng.uniform(-1.0, 1.0, 300).cumsum() + rng.uniform(-10.0, 10.0)
        rate_and_angle = np.zeros((301, 3))
        for k, u in enumerate(jerk):
            q, v, a = rate_and_angle[k]
            h = 1.0 / 300.0
            rate_and_angle[k + 1] = (
                q + h * (v + h * (a / 2.0 + h * u / 6.0)),
                v + h * (a + h * u / 2.0),
                a + h * u,
            )
        limits = np.array(
            [
                *([x.min() - 1e-3, x.max() + 1e-3] for x in rate_and_angle.T),
                [jerk.min(), jerk.max()],
            ]
        )
        limits[3] = np.array([-1.0, 1.0]) * np.abs(jerk).max()
        contacts = np.column_stack(
            [rng.uniform(0.0, 1.0, 6), rng.integers(0, 3, 6), rng.normal(0.0, 50.0, 6)]
        )
        bound, _ = lower_bound(rate_and_angle[[0, -1]], limits, contacts, KNOTS, np.zeros((8, 2)))
        assert bound <= np.mean(jerk**2) * (1.0 + 1e-9)


def test_what_is_called_optimal_is_within_a_thousandth_of_it():
    for number, case in enumerate(draw_cases(seed=21, count=12)):
        problem = case.problem(least_shared_s(case) * (1.02, 1.2, 3.0)[number % 3])
        solution = optimal_slew(problem)
        for profile, status, bound in zip(
            solution.profiles, solution.status, solution.lower_bounds_rad2_s5, strict=True
        ):
            cost = profile.jerk_squared_integral
            assert bound <= cost * (1.0 + 1e-9)
            assert (status == "optimal") == (cost - bound <= 1e-3 * cost)


OPTIONS = SlewOptions()


def swinging_track(start_deg, swing_deg, angular_rate_rad_s):
    """A track with exact derivatives, fastest in the middle as a pass is."""
    t_s = np.arange(0, 1201) / 5.0
    phase = angular_rate_rad_s * (t_s - 120.0)[:, None]
    swing = np.radians(swing_deg)
    return AxisTrack(
        axis_names=NAMES,
        t_s=t_s,
        axis_states=np.stack(
            [
                np.radians(start_deg) + swing * np.sin(phase),
                swing * angular_rate_rad_s * np.cos(phase),
                -swing * angular_rate_rad_s**2 * np.sin(phase),
            ]
        ),
    )


def feasible(track, start, start_s, t_s):
    return all(
        verdict(here, there, LIMITS, t_s - start_s).profile is not None
        for here, there in zip(start, track_states(track, t_s), strict=True)
    )


@pytest.mark.parametrize(
    ("track", "start"),
    [
        (swinging_track([20, -5], [60, 20], 0.012), (deg_state(0), deg_state(0))),
        (swinging_track([-40, 30], [50, -30], 0.014), (deg_state(150, 1.0), deg_state(-60))),
        (swinging_track([60, 10], [-70, 10], 0.01), (deg_state(-160, -1.0, 0.2), deg_state(9))),
        (swinging_track([0, 0], [3, 3], 0.1), (deg_state(0.1), deg_state(-2.0, 0.1))),
    ],
)
@pytest.mark.parametrize("start_s", [0.0, 31.4])
def test_no_earlier_row_can_be_joined(track, start, start_s):
    approach = Approach(track=track, limits=(LIMITS, LIMITS), start=start, start_s=start_s)
    join = approach.earliest_join(OPTIONS)
    row = round(join.t_s * 5)
    assert join.t_s == row / 5.0
    first = math.ceil(start_s * 5 + 1)
    earlier = [k / 5.0 for k in range(first, row) if feasible(track, start, start_s, k / 5.0)]
    # A continuous slew may exist a row or two before one that rows can carry.
    assert len(earlier) <= 2
    end = join.timed.slew.motion(np.array([join.t_s - start_s]))
    for order, wanted in enumerate(track.motion(np.array([join.t_s]))):
        np.testing.assert_allclose(end[order], wanted, rtol=0, atol=1e-8)
    assert join.timed.slew.violations == ()


def test_track_out_of_reach_in_time_has_no_join():
    track = swinging_track([120, 0], [0, 0], 0.01)
    short = dataclasses.replace(track, t_s=track.t_s[:51], axis_states=track.axis_states[:, :51])
    start = (deg_state(-120), deg_state(0))
    approach = Approach(track=short, limits=(LIMITS, LIMITS), start=start, start_s=0.0)
    assert approach.earliest_join(OPTIONS) is None


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
    while tried < 4:
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
