"""Slews of a whole body keep their limits at every instant, meet their ends and their bounds."""

import math
from dataclasses import replace

import numpy as np
import pytest
from body_slew_cases import FAMILIES, draw, draw_cone
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from planner.base import effort
from planner.base.commands import COMMAND_STEP_S, Motion
from planner.base.errors import InfeasibleSlew
from planner.motion.attitude.bounds import least_s, may
from planner.motion.attitude.problem import AgilityLimits, BodySlewProblem, between_rows
from planner.motion.attitude.slew import solve_attitude_slew

DENSE = 40  # a row: 5 ms
OVER = 1e-5  # of a limit: what a cubic rate and the quintic attitude differ by
TURNED_RAD = 1e-8  # 0.002 arcsec: what attitudes of rows may differ from the rates' integral


def flown(motion):
    """Rates, accelerations, jerks by 5 ms, each (n - 1, 40, 3), and 41 attitudes from each row.

    By other means than the planner's: the rate is a cubic on each row, and turned by in
    small steps.
    """
    t_s = np.arange(len(motion.position)) * COMMAND_STEP_S
    curve = CubicHermiteSpline(t_s, motion.rate_rad_s, motion.acceleration_rad_s2)
    step_s = COMMAND_STEP_S / DENSE
    middle_s = t_s[:-1, None] + (np.arange(DENSE) + 0.5) * step_s
    orders = [curve.derivative(order)(middle_s) if order else curve(middle_s) for order in range(3)]
    turned = [Rotation.from_quat(motion.position[:-1])]
    for k in range(DENSE):
        # Of the rate's change in a step a tenth of a microarcsecond is left.
        turned.append(turned[-1] * Rotation.from_rotvec(orders[0][:, k] * step_s))
    return orders, turned


def check(problem, slew):
    """Ends met, limits kept on 5 ms, attitudes the integral of rates, bounds never beaten."""
    motion, row = slew.motion, len(slew.motion.position) - 1
    there = problem.arriving_at(row)
    for side, end in ((0, there.start), (-1, there.goal)):
        miss = Rotation.from_quat(motion.position[side]).inv() * Rotation.from_quat(end.position[0])
        assert miss.magnitude() < 1e-12
        assert np.array_equal(motion.rate_rad_s[side], end.rate_rad_s[0])
        assert np.array_equal(motion.acceleration_rad_s2[side], end.acceleration_rad_s2[0])
    assert np.all(np.sum(motion.position[1:] * motion.position[:-1], axis=1) > 0.0)
    orders, turned = flown(motion)
    by_order = problem.limits.by_order
    for order, vectors in enumerate(orders):
        used = np.abs(vectors) / by_order[:, order]
        if problem.limits.kind == "magnitude" or (problem.limits.kind == "gyros" and order):
            used = np.linalg.norm(used, axis=-1)
        assert used.max() <= 1.0 + OVER, order
    miss = turned[-1].inv() * Rotation.from_quat(motion.position[1:])
    assert miss.magnitude().max() < TURNED_RAD
    halfway = Rotation.from_quat(between_rows(motion, np.array([0.5]))[0][:, 0])
    assert (turned[DENSE // 2].inv() * halfway).magnitude().max() < TURNED_RAD
    for cone in problem.cones:
        for k, attitudes in enumerate(turned):
            middle = (
                cone.centre_eci[:row] * (1 - k / DENSE) + cone.centre_eci[1 : row + 1] * k / DENSE
            )
            middle /= np.linalg.norm(middle, axis=1, keepdims=True)
            cosine = np.sum(attitudes.apply(cone.direction_body) * middle, axis=1)
            assert np.arccos(np.clip(cosine, -1, 1)).min() >= cone.half_rad - 1e-7
    assert least_s(problem) <= slew.duration_s
    assert slew.bound_rad2_s5 <= slew.cost_rad2_s5 * (1.0 + 1e-6)
    if slew.quickest_s is not None:
        assert least_s(problem) - COMMAND_STEP_S <= slew.quickest_s <= slew.duration_s + 1e-9


@pytest.mark.parametrize("family", [*FAMILIES, "resting-gyros", "pointing-gyros"])
def test_slews_of_both_objectives_keep_limits_and_ends(family):
    problem = draw(np.random.default_rng(1), family)
    quick = solve_attitude_slew(replace(problem, objective="minimum_time"))
    check(problem, quick)
    # A jerk that switches on rows only takes a row more, and 1 % of the time.
    assert quick.duration_s <= 1.01 * quick.quickest_s + 2 * COMMAND_STEP_S
    row = min(round(1.3 * quick.duration_s / COMMAND_STEP_S), problem.last_arrival_row)
    there = problem.arriving_at(row)
    smooth = solve_attitude_slew(there)
    check(there, smooth)
    # With a row more to take there is no reason for more jerk.
    if problem.is_rest_to_rest and row < problem.last_arrival_row:
        later = solve_attitude_slew(problem.arriving_at(row + 1))
        assert later.cost_rad2_s5 <= smooth.cost_rad2_s5 * 1.001


def rest_to_rest_s(angle, rate, acceleration, jerk):
    """Seven phases of constant jerk, some maybe none (Biagiotti, Melchiorri 2008, 3.4)."""
    if rate * jerk >= acceleration**2:
        ramp_s = acceleration / jerk
        rise_s = rate / acceleration + ramp_s
    else:
        ramp_s = math.sqrt(rate / jerk)
        rise_s = 2.0 * ramp_s
    if angle >= rate * rise_s:
        return angle / rate + rise_s
    if angle >= 2.0 * acceleration**3 / jerk**2:
        ramp_s = acceleration / jerk
        return ramp_s + math.sqrt(ramp_s**2 + 4.0 * angle / acceleration)
    return 4.0 * (angle / (2.0 * jerk)) ** (1.0 / 3.0)


@pytest.mark.parametrize("seed", range(2))
def test_between_rests_under_magnitudes_none_is_quicker_than_about_the_euler_axis(seed):
    problem = draw(np.random.default_rng(seed), "resting-magnitude")
    closed_s = rest_to_rest_s(float(problem.angles_rad[0]), *problem.limits.lengths)
    assert closed_s - 1e-3 * closed_s <= least_s(problem) <= closed_s + COMMAND_STEP_S
    quick = solve_attitude_slew(replace(problem, objective="minimum_time"))
    assert quick.quickest_s == pytest.approx(closed_s, rel=1e-4)
    assert quick.eigenaxis_s == pytest.approx(closed_s, rel=1e-6)
    # What the attitude turns by in between lies on the Euler axis.
    turned = Rotation.from_quat(problem.start.position[0]).inv() * Rotation.from_quat(
        quick.motion.position
    )
    axis = turned[-1].as_rotvec() / turned[-1].magnitude()
    assert np.abs(np.cross(turned.as_rotvec(), axis)).max() < 1e-4


def test_without_limits_in_reach_the_smoothest_between_rests_meets_its_bound():
    problem = draw(np.random.default_rng(4), "resting-magnitude")
    slew = solve_attitude_slew(problem)
    row = len(slew.motion.position) - 1
    angle_rad = float(problem.angles_rad[0])
    # The quintic's: 720 angle^2 / T^5; on spans of linear jerk it is a little more.
    least = 720.0 * angle_rad**2 / (row * COMMAND_STEP_S) ** 5
    if max(slew.shares) < 0.99:
        assert slew.cost_rad2_s5 == pytest.approx(least, rel=1e-3)
        assert slew.is_best == "jerk"
    assert slew.cost_rad2_s5 >= least * (1.0 - 1e-6)


@pytest.mark.parametrize(("seed", "family"), [(3, "resting-magnitude"), (5, "pointing-axis")])
def test_slews_go_around_cones(seed, family):
    rng = np.random.default_rng(seed)
    problem = draw(rng, family)
    quick = solve_attitude_slew(replace(problem, objective="minimum_time"))
    row = min(round(2.0 * quick.duration_s / COMMAND_STEP_S), problem.last_arrival_row)
    there = problem.arriving_at(row)
    free = solve_attitude_slew(there)
    cone = draw_cone(rng, free.motion.position, row + 1)
    around = replace(there, cones=(cone,))
    slew = solve_attitude_slew(around)
    check(around, slew)
    assert slew.cost_rad2_s5 >= free.cost_rad2_s5 * (1.0 - 1e-6)


def at_rest(q, rows=1):
    none = np.zeros((rows, 3))
    return Motion(np.tile(q.as_quat(), (rows, 1)), none, none)


def simple(angle_deg, rows, **changes):
    limits = AgilityLimits.of_magnitudes(math.radians(1.0), math.radians(0.2), math.radians(0.1))
    end = Rotation.from_rotvec([0.0, 0.0, math.radians(angle_deg)])
    asked = {
        "start": at_rest(Rotation.identity()),
        "goal": at_rest(end),
        "first_arrival_row": rows,
        "limits": limits,
    }
    return BodySlewProblem(**(asked | changes))


def refusal(problem):
    with pytest.raises(InfeasibleSlew) as caught:
        solve_attitude_slew(problem)
    return caught.value


def test_too_little_time_is_refused_with_the_time_it_takes():
    problem = simple(30.0, 100)
    assert not may(problem)
    assert least_s(problem) == math.inf
    why = refusal(problem)
    assert why.limit == "duration"
    # 30 deg at 1 deg/s, 5 s to reach it and 2 s for the jerk: 37 s.
    assert "needs about 37.0 s to turn by 30 deg, but 20.0 s are available" in why.detail
    assert may(simple(30.0, 185))


def test_an_end_that_breaks_a_limit_is_refused_by_its_name():
    q = Rotation.identity().as_quat()[None]
    fast = Motion(q, np.radians([[0.0, 1.2, 0.0]]), np.zeros((1, 3)))
    assert refusal(simple(30.0, 400, start=fast)).limit == "rate"
    pushed = Motion(q, np.zeros((1, 3)), np.radians([[0.0, 0.0, 0.3]]))
    assert refusal(simple(30.0, 400, goal=pushed)).limit == "acceleration"
    # 0.95 deg/s and 0.2 deg/s2 end at 1.15 deg/s however it is braked at 0.1 deg/s3.
    rising = Motion(q, np.radians([[0.0, 0.95, 0.0]]), np.radians([[0.0, 0.2, 0.0]]))
    why = refusal(simple(30.0, 400, start=rising))
    assert why.limit == "rate"
    assert "1.15 of the limit" in why.detail
    falling = Motion(q, np.radians([[0.0, 0.95, 0.0]]), np.radians([[0.0, -0.2, 0.0]]))
    assert solve_attitude_slew(simple(30.0, 400, start=falling)).duration_s == 80.0


def test_exclusions_that_an_end_or_the_way_breaks_are_refused():
    problem = simple(60.0, 400)
    along = draw_cone(np.random.default_rng(1), solve_attitude_slew(problem).motion.position, 401)
    ends = Rotation.from_quat(problem.goal.position[0]).apply(along.direction_body)
    at_end = replace(along, centre_eci=np.tile(ends, (401, 1)), name="camera from the Sun")
    why = refusal(replace(problem, cones=(at_end,)))
    assert why.limit == "exclusion"
    assert why.detail.startswith("camera from the Sun: the end of the slew lies")
    # A wall of cones in the middle of a quarter turn's arc that needs all the time there is.
    tight = simple(60.0, 336)
    x = np.array([1.0, 0.0, 0.0])
    wall = replace(
        along,
        name="tracker from the Moon",
        direction_body=x,
        centre_eci=np.tile(Rotation.from_rotvec([0, 0, math.pi / 6]).apply(x), (337, 1)),
        half_rad=math.radians(25.0),
    )
    why = refusal(replace(tight, cones=(wall,)))
    assert why.limit == "exclusion"
    assert "tracker from the Moon" in why.detail


def test_work_is_counted_and_bounded():
    problem = draw(np.random.default_rng(1), "pointing-axis")
    with effort.at_most(1e9) as whole:
        solve_attitude_slew(problem)
    assert whole.done_rows > 1000.0
    with effort.at_most(100.0) as little:
        solve_attitude_slew(problem)
    assert little.is_exhausted
