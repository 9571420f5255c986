"""A plan is led around the Sun and other cones, or refused, and judged."""

import math
from dataclasses import replace
from datetime import timedelta
from importlib.resources import files

import numpy as np
import pytest
from scenarios import EPOCH, FREE, free_plan, scenario, session
from scipy_boresight import scipy_boresight
from skyfield.api import EarthSatellite, load, load_file, wgs84

from planner.base.errors import InfeasibleSlew, NotVisible
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.scenario import SlewOptions
from planner.world.targets import BodyTarget, KeepOut


@pytest.fixture(scope="module")
def cone():
    """In LVLH, which is the platform's frame here, on the way to the first session."""
    half_way = scipy_boresight(free_plan().table.position[[350]])[0]
    return KeepOut(direction_lvlh=tuple(half_way + np.array([0.05, 0.0, 0.0])), half_angle_deg=15.0)


def with_cones(*cones, **slew):
    return replace(FREE, slew=SlewOptions(keep_out=cones, **slew))


@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_slew_is_led_around(cone, objective):
    plan = make_plan(with_cones(cone, objective=objective))
    assert plan.slews[0].status == "detour"
    boresight = scipy_boresight(plan.table.position)
    axis = np.array(cone.direction_lvlh) / np.linalg.norm(cone.direction_lvlh)
    away_deg = np.degrees(np.arccos(boresight @ axis))
    assert away_deg.min() >= 15.0
    (margin,) = plan.verification.keep_out
    assert 15.0 <= math.degrees(margin.away_min_rad) <= away_deg.min() + 1e-9


def test_judge_rejects_the_straight_table(cone):
    report = verify(free_plan().table, with_cones(cone))
    assert not report.passed
    assert [finding.limit for finding in report.findings] == ["keep_out"]


def test_spline_flies_through_and_says_so(cone):
    plan = make_plan(with_cones(cone, method="spline"))
    assert "keep_out" in [finding.limit for finding in plan.verification.findings]


def test_target_inside_a_cone_is_refused_with_when():
    # Las Vegas passes within 6 deg of nadir: 84 deg high at the closest approach.
    with pytest.raises(NotVisible, match="LVLH direction") as refusal:
        make_plan(with_cones(KeepOut(direction_lvlh=(0.0, 0.0, 1.0), half_angle_deg=20.0)))
    assert refusal.value.limit == "keep_out"
    assert refusal.value.field == "sessions.0.target"
    assert EPOCH + timedelta(seconds=140) <= refusal.value.at_utc <= EPOCH + timedelta(seconds=230)
    assert refusal.value.earliest_feasible_start_utc is not None


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


def test_parked_inside_is_told_by_how_deep():
    start = scipy_boresight(free_plan().table.position[[0]])[0]
    inside = KeepOut(direction_platform=tuple(start), half_angle_deg=10.0)
    with pytest.raises(InfeasibleSlew, match=r"begins 10\.00 deg inside") as refusal:
        make_plan(with_cones(inside))
    assert refusal.value.field == "initial_state.angles_deg"
