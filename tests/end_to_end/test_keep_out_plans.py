"""A plan is led around the Sun, other cones and what stands in view, or refused, and judged."""

import math
from dataclasses import replace
from datetime import timedelta
from importlib.resources import files

import numpy as np
import pytest
from mask_shapes import inside, mask_corners
from scenarios import EPOCH, FREE, advised, free_plan, scenario, session
from scipy_boresight import scipy_boresight
from skyfield.api import EarthSatellite, load, load_file, wgs84

from planner.base.errors import InfeasibleSlew, NotVisible
from planner.motion.pointing.angles import axis_angles
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.platforms import ISS_HRC, FieldMask
from planner.world.rules.keep_out import KeepOut
from planner.world.scenario import FinalAngles, SlewOptions
from planner.world.targets import BodyTarget


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


@pytest.fixture(scope="module")
def cone():
    """In LVLH, which is the platform's frame here, on the way to the first session."""
    half_way = scipy_boresight(free_plan().table.position[[350]])[0]
    return KeepOut(direction_lvlh=tuple(half_way + np.array([0.05, 0.0, 0.0])), half_angle_deg=15.0)


def with_cones(*cones, **slew):
    return replace(FREE, slew=SlewOptions(keep_out=cones, **slew))


@pytest.fixture(params=["cone", "mask"])
def barred(request, cone, mask):
    """The plan's request with either in its way, by further options of its slew."""
    if request.param == "cone":
        return lambda **slew: with_cones(cone, **slew)
    return lambda **slew: masked(mask, **slew)


@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_slew_is_led_around_a_cone(cone, objective):
    plan = make_plan(with_cones(cone, objective=objective))
    assert plan.slews[0].status == "detour"
    boresight = scipy_boresight(plan.table.position)
    axis = np.array(cone.direction_lvlh) / np.linalg.norm(cone.direction_lvlh)
    away_deg = np.degrees(np.arccos(boresight @ axis))
    assert away_deg.min() >= 15.0
    (margin,) = plan.verification.keep_out
    assert 15.0 <= math.degrees(margin.away_min_rad) <= away_deg.min() + 1e-9


@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_slew_is_led_around_a_mask(mask, objective):
    plan = make_plan(masked(mask, objective=objective))
    assert plan.slews[0].status == "detour"
    assert not inside(mask_corners(mask), scipy_boresight(plan.table.position)).any()
    assert plan.verification.passed
    (margin,) = plan.verification.masks
    assert margin.name == "radiator"
    assert math.degrees(margin.away_min_rad) >= 1.5


def test_judge_rejects_the_straight_table(barred):
    report = verify(free_plan().table, barred())
    assert not report.passed
    (finding,) = report.findings
    assert finding.limit == "keep_out"
    assert "LVLH direction" in finding.detail or 'into the mask "radiator"' in finding.detail


def test_spline_flies_through_and_says_so(barred):
    plan = make_plan(barred(method="spline"))
    assert "keep_out" in [finding.limit for finding in plan.verification.findings]


# Las Vegas passes within 6 deg of nadir: 84 deg high at the closest approach.
DOWN = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (with_cones(KeepOut(direction_lvlh=tuple(DOWN), half_angle_deg=20.0)), "LVLH direction"),
        (masked(around(DOWN, 15.0)), 'inside the mask "radiator"'),
    ],
    ids=["cone", "mask"],
)
def test_target_inside_is_refused_with_when_and_a_start_that_works(asked, words):
    with pytest.raises(NotVisible, match=words) as refusal:
        make_plan(asked)
    assert refusal.value.limit == "keep_out"
    assert refusal.value.field == "sessions.0.target"
    assert EPOCH + timedelta(seconds=140) <= refusal.value.at_utc <= EPOCH + timedelta(seconds=230)
    alone = replace(asked, sessions=asked.sessions[:1])
    assert make_plan(advised(alone, refusal.value)).verification.passed


def test_sun_is_where_skyfield_sees_it():
    """The judge's least distance to the Sun's centre against Skyfield's apparent Sun."""
    report = verify(free_plan().table, with_cones(KeepOut(body="sun", half_angle_deg=5.0)))
    (margin,) = report.keep_out
    times = load.timescale(builtin=True).from_datetime(margin.at_utc)
    sky = load_file(str(files("skyfield_data") / "data" / "de421.bsp"))
    iss = EarthSatellite(FREE.orbit.line1, FREE.orbit.line2)
    sun = (sky["earth"] + iss).at(times).observe(sky["sun"]).apparent().position.km
    r_km, v_km_s = iss.at(times).position.km, iss.at(times).velocity.km_per_s
    z, y = -r_km, -np.cross(r_km, v_km_s)
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    sun_lvlh = np.array([np.cross(y, z), y, z]) @ (sun / np.linalg.norm(sun))
    row = round(margin.t_s * 5)
    away = math.acos(scipy_boresight(free_plan().table.position[[row]])[0] @ sun_lvlh)
    assert margin.t_s == pytest.approx(row / 5, abs=1e-9)
    assert margin.away_min_rad == pytest.approx(
        away, abs=2e-5
    )  # Skyfield's frame bias, polar motion
    assert wgs84.subpoint(iss.at(times)).elevation.km > 300.0


def test_sun_behind_the_earth_blinds_nobody():
    """By day hardly a direction is 170 deg from the Sun; at night all of them will do."""
    everywhere = KeepOut(body="sun", half_angle_deg=170.0)
    with pytest.raises(InfeasibleSlew, match="the Sun"):
        make_plan(with_cones(everywhere))
    night_s = 2900.0
    moon = BodyTarget(name="jupiter")
    night = replace(
        scenario(session(moon, night_s + 100.0, night_s + 130.0), epoch_s=night_s),
        slew=SlewOptions(keep_out=(everywhere,)),
    )
    plan = make_plan(night)
    assert plan.verification.passed
    assert plan.verification.keep_out[0].away_min_rad is None


@pytest.mark.parametrize("barrier", ["cone", "mask"])
def test_parked_inside_is_told_by_how_deep(barrier):
    start = scipy_boresight(free_plan().table.position[[0]])[0]
    inside_cone = with_cones(KeepOut(direction_platform=tuple(start), half_angle_deg=10.0))
    asked = inside_cone if barrier == "cone" else masked(around(start, 10.0))
    with pytest.raises(InfeasibleSlew, match=r"begins 10\.00 deg inside") as refusal:
        make_plan(asked)
    assert refusal.value.field == "initial_state.angles_deg"
    assert ("inside the mask" in refusal.value.detail) == (barrier == "mask")


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
