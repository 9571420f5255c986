"""The times by which campaigns choose a body's sessions enclose the least that its OCP finds."""

from dataclasses import replace

import numpy as np
import pytest
from body_slew_cases import draw
from scipy.spatial.transform import Rotation

from planner.base.commands import COMMAND_STEP_S, Motion
from planner.motion.attitude.problem import AgilityLimits, BodySlewProblem
from planner.motion.attitude.slew import solve_attitude_slew
from planner.planning.campaigns.platforms.body_slew_time import BodyEnvelope, body_fits

BORESIGHT = np.array([0.0, -1.0, 0.0])  # as the cases track


@pytest.mark.parametrize("family", ["resting-magnitude", "pointing-axis", "resting-gyros"])
def test_a_time_suffices_and_a_time_is_needed(family):
    problem = draw(np.random.default_rng(3), family)
    rows = {sign: first_row(problem, sign) for sign in (-1.0, 1.0)}
    quickest = solve_attitude_slew(replace(problem, objective="minimum_time"))
    found = round(quickest.duration_s / COMMAND_STEP_S)
    assert rows[-1.0] <= found <= rows[1.0]
    if family == "resting-magnitude":  # the turn about the Euler axis is the optimum
        assert rows[1.0] - rows[-1.0] <= 3


def test_a_free_roll_is_taken_as_the_shortest_turn_of_the_boresight():
    """Between the same two targets the roll that is left free is never slower, by the bound."""
    problem = draw(np.random.default_rng(5), "pointing-magnitude")
    given, free = (first_row(problem, -1.0, roll_free=is_free) for is_free in (0.0, 1.0))
    assert free <= given
    assert first_row(problem, 1.0, roll_free=1.0) <= first_row(problem, 1.0)


@pytest.mark.parametrize("seed", range(2))
def test_no_flown_motion_is_called_too_quick(seed):
    """Rates at corners of their box, switched at once, among them those that go round a loop to
    turn about its axis as well: what was flown can't be proven impossible in as long."""
    random = np.random.default_rng(seed)
    rates_rad_s = random.uniform(0.01, 0.05, 3)
    limits = AgilityLimits(
        kind="axis",
        rate_rad_s=rates_rad_s,
        acceleration_rad_s2=np.full(3, 1e4),
        jerk_rad_s3=np.full(3, 1e9),
    )
    loop = np.array([[1, 1, 1], [1, -1, 1], [1, -1, -1], [1, 1, -1]], float)
    for number in range(60):
        lasts_s = random.uniform(1.0, 40.0)
        signs = np.roll(loop, number % 3, axis=1) * random.choice([-1.0, 1.0], 3)
        if number % 2:
            signs = random.choice([-1.0, 0.0, 1.0], (random.integers(1, 7), 3))
        step_s = lasts_s / len(signs)
        flown = Rotation.identity()
        for rate_rad_s in signs * rates_rad_s:
            flown *= Rotation.from_rotvec(rate_rad_s * step_s)
        problem = BodySlewProblem(
            start=Motion(np.array([[0.0, 0.0, 0.0, 1.0]]), *np.zeros((2, 1, 3))),
            goal=Motion(flown.as_quat()[None], *np.zeros((2, 1, 3))),
            first_arrival_row=1,
            limits=limits,
        )
        assert fits(problem, 0, -1.0, lasts_s + 1e-3)  # 1e-3 s to reach a rate and leave it
        # One axis alone must turn its way at the greatest rate.
        about = np.eye(3)[number % 3]
        turn_rad = rates_rad_s @ about * lasts_s
        alone = Rotation.from_rotvec(turn_rad * about).as_quat()[None]
        quick = replace(problem, goal=Motion(alone, *np.zeros((2, 1, 3))))
        # Loops of half a radian's length give an eighth of it at most.
        if lasts_s * rates_rad_s.max() < 0.5:
            assert not fits(quick, 0, -1.0, 0.85 * lasts_s)


def first_row(problem, sign, roll_free=0.0):
    """The first row of the goal that a slew fits onto."""
    return next(
        k + 1
        for k in range(len(problem.goal.position))
        if fits(problem, k, sign, (k + 1) * COMMAND_STEP_S, roll_free)
    )


def fits(problem, k, sign, available_s, roll_free=0.0):
    by_axis = np.ascontiguousarray(problem.limits.by_order)
    envelope = BodyEnvelope(
        by_axis,
        np.array(problem.limits.round_orders),
        np.array(problem.limits.lengths),
        by_axis.min(axis=0),
        BORESIGHT,
    )
    ends = state(problem.start, 0, roll_free), state(problem.goal, k, roll_free)
    return body_fits(*ends, envelope, sign, available_s)


def state(motion, k, roll_free):
    return np.concatenate(
        [motion.position[k], motion.rate_rad_s[k], motion.acceleration_rad_s2[k], [roll_free]]
    )
