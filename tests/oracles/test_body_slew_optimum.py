"""Quickest slews of a whole body beside the least time that another, finer transcription finds."""

from dataclasses import replace

import numpy as np
import pytest
from body_slew_cases import draw
from body_slew_reference import reference_least_s

from planner.base.commands import COMMAND_STEP_S
from planner.motion.attitude.bounds import least_s
from planner.motion.attitude.slew import solve_attitude_slew

LONGER = 1.02  # of the reference's: the aim


# Each kind of limits and each kind of ends once; all four families: bench/body_slew.py.
@pytest.mark.parametrize("family", ["resting-magnitude", "pointing-axis"])
def test_no_other_slew_is_two_percent_quicker(family):
    problem = replace(draw(np.random.default_rng(1), family), objective="minimum_time")
    slew = solve_attitude_slew(problem)
    found_s = reference_least_s(problem, slew)
    assert found_s is not None
    assert slew.quickest_s <= LONGER * found_s
    # On rows, and with a jerk that switches on these alone: a row or two more.
    assert slew.duration_s <= LONGER * found_s + 2 * COMMAND_STEP_S
    # Limits at instants alone let the reference be a little quicker than any slew.
    assert least_s(problem) <= found_s * (1.0 + 1e-3) + COMMAND_STEP_S
