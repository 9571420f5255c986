"""Detours keep out of moving cones and within every limit, and refusals are proven."""

import math
from dataclasses import replace

import numpy as np
import pytest
from keep_out_cases import LIMITS, away_rad, draw_cases, hermite, row_accelerations

from planner.base.errors import InfeasibleSlew
from planner.motion.detour.detour import avoid_cones
from planner.motion.detour.infeasibility_proof import OPTIONS as PROOF_OPTIONS
from planner.motion.detour.infeasibility_proof import is_unreachable
from planner.motion.pointing.keep_out import KeepOutView, MovingCone
from planner.motion.slew import AxisState, SlewProblem, optimal_slew
from planner.motion.slew.solution import obeys
from planner.world.platforms import ISS_HRC

CASES = list(draw_cases(21, 8))
IMPOSSIBLE = {7}  # of them: cone and stops leave no gap
ROUNDING = 1.0 + 1e-6  # of a limit, as the judge allows


@pytest.mark.parametrize("number", range(len(CASES)))
def test_detour_keeps_out_of_the_cone_and_within_the_limits(number):
    case = CASES[number]
    if number in IMPOSSIBLE:
        with pytest.raises(InfeasibleSlew, match="no motion within the limits"):  # proven
            avoid_cones(case.straight)
        return
    solution = avoid_cones(case.straight)
    t_s, angle, rows, rates = hermite(solution)
    assert away_rad(case, t_s, angle).min() >= case.half_angle_rad
    assert np.abs(angle).max() <= LIMITS.angle_max_rad * ROUNDING
    assert np.abs(row_accelerations(rows, rates)).max() <= LIMITS.acceleration_max_rad_s2 * ROUNDING
    # The rate in the middle of a cell.
    between = 7.5 * np.diff(rows, axis=0) - 0.25 * (rates[:-1] + rates[1:])
    assert max(np.abs(rates).max(), np.abs(between).max()) <= LIMITS.rate_max_rad_s * ROUNDING
    for values, state in zip((rows, rates), ("angle_rad", "rate_rad_s"), strict=True):
        for row, side in ((0, case.problem.start), (-1, case.problem.end)):
            wanted = [getattr(axis, state) for axis in side]
            np.testing.assert_allclose(values[row], wanted, rtol=0, atol=1e-8)  # 2 mas
    assert solution.jerk_squared_integral >= case.straight.jerk_squared_integral
    # What was flown is possible: the proof of the contrary must not find it otherwise.
    assert not is_unreachable(
        case.problem, case.problem.keep_out, solution.duration_s, PROOF_OPTIONS.cells_rad
    )


def test_starts_whose_rate_all_but_passes_its_limit_are_led_around():
    """Acceleration taken back as fast as jerk may brings the rate to its limit exactly."""
    acceleration = 0.8 * LIMITS.acceleration_max_rad_s2
    rate = LIMITS.rate_max_rad_s - acceleration**2 / (2.0 * LIMITS.jerk_max_rad_s3)
    refused = []
    for case in draw_cases(31, 6, (rate, acceleration)):
        try:
            solution = avoid_cones(case.straight)
        except InfeasibleSlew as refusal:
            refused.append(refusal.detail)
            continue
        t_s, angle, _, rates = hermite(solution)
        assert away_rad(case, t_s, angle).min() >= case.half_angle_rad
        for axis, profile in enumerate(solution.profiles):
            ends = (case.problem.start[axis], case.problem.end[axis])
            assert obeys(profile, *ends, case.problem.limits[axis])
        assert np.abs(rates).max() <= LIMITS.rate_max_rad_s * ROUNDING
    assert all("no motion within the limits" in detail for detail in refused)
    assert len(refused) == 2


def rest_to_rest(beta_from_deg, beta_to_deg, half_angle_deg, duration_s=120.0):
    """A cone about the outer axis: the boresight's angle to it depends on beta alone."""
    nodes_s = np.linspace(0.0, duration_s, 5)
    cone = MovingCone(
        about="the outer axis",
        half_angle_rad=math.radians(half_angle_deg),
        t_s=nodes_s,
        axis_platform=np.tile(ISS_HRC.axes_platform[0], (5, 1)),
        counts_rad=np.ones(5),
    )
    problem = SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=(AxisState(angle_rad=0.0), AxisState(angle_rad=math.radians(beta_from_deg))),
        end=(AxisState(angle_rad=1.0), AxisState(angle_rad=math.radians(beta_to_deg))),
        duration_s=duration_s,
        keep_out=KeepOutView(platform=ISS_HRC, cones=(cone,)),
    )
    return optimal_slew(problem, on_rows=True)


def test_a_cone_about_the_outer_axis_cuts_the_angles_in_two():
    # On the HRC sin(boresight to outer axis) = cos(beta + 5 deg): blocked is beta = 85 +- 20 deg,
    # whatever alpha does and however long it takes.
    with pytest.raises(InfeasibleSlew, match="no motion within the limits") as refusal:
        avoid_cones(rest_to_rest(0.0, 150.0, 20.0, 600.0))
    assert refusal.value.limit == "keep_out"


def test_the_refusal_names_the_cone_that_leaves_no_way():
    """Another cone, in the middle of the straight slew and entered deeper, could be passed."""
    straight = rest_to_rest(0.0, 150.0, 20.0, 600.0)
    (cone,) = straight.problem.keep_out.cones
    on_path = straight.problem.keep_out.boresight(straight.motion(np.array([230.0]))[0])
    other = replace(
        cone,
        about="a lamp",
        half_angle_rad=math.radians(25.0),
        axis_platform=np.tile(on_path, (5, 1)),
    )
    for cones in ((other, cone), (cone, other)):
        view = KeepOutView(platform=ISS_HRC, cones=cones)
        problem = replace(straight.problem, keep_out=view)
        with pytest.raises(InfeasibleSlew, match="leads around the cone about the outer axis"):
            avoid_cones(replace(straight, problem=problem))


def test_a_straight_slew_that_stays_outside_is_left_alone():
    straight = rest_to_rest(0.0, 64.0, 20.0)
    assert avoid_cones(straight) is straight


def test_without_cones_nothing_is_looked_at():
    straight = rest_to_rest(0.0, 150.0, 20.0)
    free = replace(straight, problem=replace(straight.problem, keep_out=None))
    assert avoid_cones(free) is free


@pytest.mark.parametrize(("side", "angles_deg"), [("begins", (80.0, 0.0)), ("ends", (0.0, 80.0))])
def test_ends_inside_a_cone_are_refused_by_how_deep(side, angles_deg):
    with pytest.raises(InfeasibleSlew, match=rf"{side} 15\.00 deg inside"):
        avoid_cones(rest_to_rest(*angles_deg, 20.0))


def test_a_cone_that_does_not_count_is_flown_through():
    straight = rest_to_rest(0.0, 150.0, 20.0)
    (cone,) = straight.problem.keep_out.cones
    lapsed = replace(cone, counts_rad=np.full(5, -1.0))
    view = KeepOutView(platform=ISS_HRC, cones=(lapsed,))
    straight = replace(straight, problem=replace(straight.problem, keep_out=view))
    assert avoid_cones(straight) is straight
