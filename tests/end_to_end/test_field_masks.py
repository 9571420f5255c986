"""A plan is led around what stands in the platform's view, or refused, and judged."""

import math
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from mask_shapes import inside, mask_corners
from scenarios import EPOCH, FREE, free_plan
from scipy_boresight import scipy_boresight

from planner.base.errors import InfeasibleSlew, NotVisible
from planner.motion.pointing.angles import axis_angles
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.platforms import ISS_HRC, FieldMask
from planner.world.scenario import FinalAngles, SlewOptions
from planner.world.targets import KeepOut


def around(middle, half_width_deg, **fields):
    """A square."""
    across = np.cross(middle, [1.0, 2.0, 3.0])
    across /= np.linalg.norm(across)
    beside = np.cross(middle, across)
    size = math.tan(math.radians(half_width_deg))
    corners = [
        middle + size * (a * across + b * beside) for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))
    ]
    return FieldMask(
        name="radiator", corners_platform=tuple(map(tuple, np.array(corners).tolist())), **fields
    )


@pytest.fixture(scope="module")
def mask():
    """On the way to the first session."""
    middle = scipy_boresight(free_plan().table.position[[350]])[0]
    return around(middle, 10.0, margin_deg=1.5)


def masked(*masks, base=FREE, **slew):
    return replace(base, platform=replace(ISS_HRC, masks=masks), slew=SlewOptions(**slew))


@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_slew_is_led_around(mask, objective):
    plan = make_plan(masked(mask, objective=objective))
    assert plan.slews[0].status == "detour"
    boresight = scipy_boresight(plan.table.position)
    assert not inside(mask_corners(mask), boresight).any()
    assert plan.verification.passed
    (margin,) = plan.verification.masks
    assert margin.name == "radiator"
    assert math.degrees(margin.away_min_rad) >= 1.5


def test_judge_rejects_the_straight_table(mask):
    report = verify(free_plan().table, masked(mask))
    assert not report.passed
    (finding,) = report.findings
    assert finding.limit == "keep_out"
    assert 'into the mask "radiator"' in finding.detail


def test_spline_flies_through_and_says_so(mask):
    plan = make_plan(masked(mask, method="spline"))
    assert "keep_out" in [finding.limit for finding in plan.verification.findings]


def test_target_behind_a_mask_is_refused_with_when_and_a_start_that_works():
    # Las Vegas passes within 6 deg of nadir: 84 deg high at the closest approach.
    below = around(np.array([0.0, 0.0, 1.0]), 15.0)
    with pytest.raises(NotVisible, match='inside the mask "radiator"') as refusal:
        make_plan(masked(below))
    assert refusal.value.limit == "keep_out"
    assert refusal.value.field == "sessions.0.target"
    assert EPOCH + timedelta(seconds=140) <= refusal.value.at_utc <= EPOCH + timedelta(seconds=230)
    start_utc = refusal.value.earliest_feasible_start_utc
    moved = replace(FREE.sessions[0], start=start_utc, stop=refusal.value.feasible_stop_utc)
    plan = make_plan(masked(below, base=replace(FREE, sessions=(moved,))))
    assert plan.verification.passed


def test_cones_and_masks_are_kept_together(mask):
    """A cone on the side that the way around the mask alone takes."""
    way = make_plan(masked(mask)).table.position
    away = [np.arccos(scipy_boresight(way) @ np.mean(mask_corners(mask), axis=0))]
    beside = scipy_boresight(way[[int(np.argmin(away[0]))]])[0]
    cone = KeepOut(direction_platform=tuple(beside.tolist()), half_angle_deg=6.0)
    plan = make_plan(masked(mask, keep_out=(cone,)))
    boresight = scipy_boresight(plan.table.position)
    assert not inside(mask_corners(mask), boresight).any()
    assert np.degrees(np.arccos(boresight @ beside)).min() >= 6.0
    assert plan.verification.passed


def test_a_platform_that_begins_inside_is_told_by_how_deep():
    start = scipy_boresight(free_plan().table.position[[0]])[0]
    with pytest.raises(InfeasibleSlew, match=r"begins 10\.00 deg inside the mask") as refusal:
        make_plan(masked(around(start, 10.0)))
    assert refusal.value.field == "initial_state.angles_deg"


def test_a_mask_out_of_the_way_changes_nothing_but_its_margin():
    plan = make_plan(masked(around(np.array([0.0, 0.0, -1.0]), 40.0)))
    np.testing.assert_array_equal(plan.table.position, free_plan().table.position)
    (margin,) = plan.verification.masks
    assert math.degrees(margin.away_min_rad) > 40.0


def test_a_final_state_inside_a_mask_is_refused_as_such():
    aside = around(np.array([0.0, 0.8, 0.6]), 8.0)
    angle_rad = axis_angles(ISS_HRC, np.array([[0.0, 0.8, 0.6]])).angle_rad[0, 0]
    angles_deg = dict(zip(ISS_HRC.axis_names, np.degrees(angle_rad).tolist(), strict=True))
    final = replace(masked(aside), final_state=FinalAngles(angles_deg=angles_deg))
    with pytest.raises(InfeasibleSlew, match='inside the mask "radiator"') as refusal:
        make_plan(final)
    assert refusal.value.field == "final_state"
