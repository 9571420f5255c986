"""The times by which campaigns choose a body's sessions enclose the least that its OCP finds."""

from dataclasses import replace

import numpy as np
import pytest
from body_slew_cases import FAMILIES, draw

from planner.base.commands import COMMAND_STEP_S
from planner.motion.attitude.slew import solve_attitude_slew
from planner.planning.campaigns.platforms.body_slew_time import BodyEnvelope, body_fits

BORESIGHT = np.array([0.0, -1.0, 0.0])  # as the cases track


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [3, 12])
def test_a_time_suffices_and_a_time_is_needed(family, seed):
    problem = draw(np.random.default_rng(seed), family)
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


def first_row(problem, sign, roll_free=0.0):
    """The first row of the goal that a slew fits onto."""
    by_axis = np.ascontiguousarray(problem.limits.by_order)
    envelope = BodyEnvelope(
        problem.limits.kind == "magnitude",
        by_axis,
        np.array(problem.limits.lengths),
        by_axis.min(axis=0),
        BORESIGHT,
    )
    start = state(problem.start, 0, roll_free)
    return next(
        k + 1
        for k in range(len(problem.goal.position))
        if body_fits(
            start, state(problem.goal, k, roll_free), envelope, sign, (k + 1) * COMMAND_STEP_S
        )
    )


def state(motion, k, roll_free):
    return np.concatenate(
        [motion.position[k], motion.rate_rad_s[k], motion.acceleration_rad_s2[k], [roll_free]]
    )
