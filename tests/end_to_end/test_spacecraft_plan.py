"""A session comes out whole: four modes planned, judged, flown steadily, bad input refused."""

import dataclasses
import math
import re
import sys
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[1] / "oracles"))
from spacecraft_cases import EPOCH, area, four_modes, line, positions, session

from planner.base import effort
from planner.base.errors import InfeasibleSlew, SearchEnded, Unreachable
from planner.spacecraft.plan import plan_imaging
from planner.spacecraft.requests import (
    CorridorRequest,
    GeoLineString,
    GeoPolygon,
    SpacecraftSettings,
    StripRequest,
)
from planner.spacecraft.verification import verify_table
from planner.world.frames.geodesy import itrf_from_geodetic


@pytest.fixture(scope="module")
def plan():
    return plan_imaging(session(four_modes(), 640.0, simulation_runs=4))


def test_everything_asked_for_is_imaged_and_the_judge_agrees(plan):
    assert plan.left_out == ()
    assert plan.verification.passed
    looks = [window.request for window in plan.windows]
    assert looks == ["strip", "stereo", "stereo", "corridor", "area", "area", "area", "area"]


def test_rates_hold_a_thousandth_of_a_degree_a_second_in_every_run(plan):
    report = plan.stabilisation
    assert report.runs == 4
    assert report.share_steady == 1.0  # the paper's promise
    for flown in report.windows:
        assert flown.spare_s > 0.0
        assert flown.smear_px < 0.1
        assert 0.0 < flown.momentum_margin_n_m_s < 60.0
        assert flown.gimbal_margin > 0.5


def test_a_session_flies_as_many_runs_as_it_may_and_says_so(monkeypatch):
    strip = session(four_modes()[:1], 300.0, simulation_runs=100)
    monkeypatch.setattr(effort, "PLAN", 100_000)
    plan = plan_imaging(strip)
    assert 1 <= plan.stabilisation.runs < 50
    assert f"{plan.stabilisation.runs} of the 100 dispersed runs were flown" in plan.warnings[-1]


@pytest.mark.parametrize("bound", [100, 3_000])
def test_a_session_whose_work_ends_before_a_plan_is_refused(monkeypatch, bound):
    monkeypatch.setattr(effort, "PLAN", bound)
    with pytest.raises(SearchEnded, match="asked of this session takes more work"):
        plan_imaging(session(four_modes()[:1], 300.0, simulation_runs=0))


def test_what_no_pass_can_scan_is_refused_at_once():
    """63 legs to and fro; once minutes of work."""
    (east, north), *_ = line(300.0).coordinates
    zigzag = tuple((east + 0.3 * (k % 2), north + 0.05 * k) for k in range(64))
    hopeless = CorridorRequest(name="zigzag", geometry=GeoLineString(coordinates=zigzag))
    with effort.at_most(effort.PLAN) as work, pytest.raises(Unreachable):
        plan_imaging(session([hopeless], 640.0))
    assert work.done_rows < 0.15 * effort.PLAN


def test_limits_hold_between_rows(plan):
    verified = plan.verification
    assert verified.rate_max_deg_s.max() <= 1.58 * 1.002
    at_rows_deg_s = np.rad2deg(np.abs(plan.table.rate_rad_s).max(axis=0))
    assert np.all(verified.rate_max_deg_s >= at_rows_deg_s - 1e-12)  # of each axis, and rounding
    assert verified.torque_max_n_m <= 15.0 * 1.002
    assert verified.momentum_mismatch_n_m_s < 0.02


def test_every_turn_stands_beside_its_baselines(plan):
    onto = [slew.onto for slew in plan.slews]
    assert onto == [0, None, 1, 2, 3, 4, 5, 6, 7, None]  # it waits in orbital orientation
    for slew in plan.slews:
        assert slew.duration_s >= 0.95 * slew.eigenaxis_s
        assert slew.bang_coast_bang_s < slew.eigenaxis_s
        assert slew.torque_rate_peak_n_m_s < slew.eigenaxis_torque_rate_peak_n_m_s


def judge(plan, **changes):
    """The verdict where table, windows or request are others than the plan's."""
    asked = {"table": plan.table, "windows": plan.windows, "request": plan.request, **changes}
    return verify_table(report=plan.whole.verification, **asked)


def only(verification, words):
    """The one finding of a table that failed, which says so."""
    (finding,) = verification.findings
    assert not verification.passed
    assert words in finding


def test_a_scan_at_another_speed_than_asked_is_found(plan):
    strip = dataclasses.replace(plan.request.requests[0], scan_speed_m_s=60e3 / 11.0 * 1.002)
    asked = dataclasses.replace(plan.request, requests=(strip, *plan.request.requests[1:]))
    only(judge(plan, request=asked), "scan speed off by")


def test_an_image_that_drifts_across_the_columns_is_found(plan):
    """2e-4 rad about the optical axis: the scanned line stays, gyros hold 0.012 N m s amiss."""
    table, about_y = plan.table, Rotation.from_rotvec([0.0, 2e-4, 0.0])
    other = dataclasses.replace(
        table,
        position=(Rotation.from_quat(table.position) * about_y).as_quat(),
        rate_rad_s=about_y.inv().apply(table.rate_rad_s),
        acceleration_rad_s2=about_y.inv().apply(table.acceleration_rad_s2),
    )
    turned = judge(plan, table=other)
    assert len(turned.findings) == len(plan.windows)
    assert all("the image drifts by" in finding for finding in turned.findings)


def every(verification, words):
    """All findings of a table that failed say so."""
    assert verification.findings
    assert all(words in finding for finding in verification.findings), verification.findings


def look_within(monkeypatch, **changes):
    """A spacecraft whose camera looks within another box, whatever is asked for."""
    asked_for = SpacecraftSettings.applied_to

    def other(settings, spacecraft):
        return dataclasses.replace(asked_for(settings, spacecraft), **changes)

    monkeypatch.setattr(SpacecraftSettings, "applied_to", other)


@pytest.mark.parametrize("way", ["across", "along"])
def test_looking_farther_aside_than_the_camera_may_is_found(plan, monkeypatch, way):
    look_within(monkeypatch, **{f"{way}_max_deg": 0.1})
    every(judge(plan), f"deg {way} the track")


@pytest.mark.parametrize("way", ["across", "along"])
def test_the_last_part_of_a_tick_may_look_a_fifth_of_a_degree_farther(plan, monkeypatch, way):
    most_deg = max(getattr(window, f"{way}_deg") for window in plan.verification.windows)
    look_within(monkeypatch, **{f"{way}_max_deg": most_deg - 0.19})
    assert judge(plan).passed


def test_a_line_scanned_beside_the_one_asked_for_is_found(plan):
    """2e-5 deg of latitude, 2.2 m."""
    strip = plan.request.requests[0]
    moved = [(p[0], p[1] + 2e-5, *p[2:]) for p in strip.geometry.coordinates]
    there = dataclasses.replace(
        strip, geometry=dataclasses.replace(strip.geometry, coordinates=tuple(moved))
    )
    asked = dataclasses.replace(plan.request, requests=(there, *plan.request.requests[1:]))
    only(judge(plan, request=asked), "beside the line asked for")


@pytest.mark.parametrize("end", [0, -1])
def test_a_scan_that_begins_before_the_line_or_runs_on_past_it_is_found(plan, end):
    """By 5 km of 60, less than a second."""
    strip = plan.request.requests[0]
    longitude_rad, latitude_rad = np.deg2rad(strip.geometry.coordinates).T[:2]
    ends_itrf_m = itrf_from_geodetic(latitude_rad, longitude_rad, 0.0)
    ends_itrf_m[end] += (ends_itrf_m[-1 - end] - ends_itrf_m[end]) / 12.0
    shorter = GeoLineString(coordinates=positions(ends_itrf_m))
    asked = dataclasses.replace(
        plan.request,
        requests=(dataclasses.replace(strip, geometry=shorter), *plan.request.requests[1:]),
    )
    only(judge(plan, request=asked), "beside the line asked for")


def test_a_look_left_out_is_found(plan):
    only(judge(plan, windows=(plan.windows[0], *plan.windows[2:])), "looks instead of")


def test_an_area_that_lacks_any_strip_is_found(plan):
    strips = [one for one in plan.windows if one.request == "area"]
    assert len(strips) > 3
    for lacking in strips:
        rest = [one for one in plan.windows if one is not lacking]
        only(judge(plan, windows=tuple(rest)), "outside the strips")


@pytest.mark.parametrize("rows", [slice(None, -1), slice(1, None)])
def test_a_table_that_does_not_span_its_session_is_found(plan, rows):
    table = plan.table
    cut = dataclasses.replace(
        table,
        epoch_utc=table.epoch_utc + timedelta(seconds=0.2 * (rows.start or 0)),
        position=table.position[rows],
        rate_rad_s=table.rate_rad_s[rows],
        acceleration_rad_s2=table.acceleration_rad_s2[rows],
    )
    only(judge(plan, table=cut), f"needs rows 0 to {len(table.position) - 1}")


def test_the_plan_of_a_session_tells_how_near_its_gyros_come_to_their_limits(plan):
    """Judged as of any plan of a body with gyros; what the front tells of them is the same."""
    margins = {one.name: one for one in plan.whole.verification.gyros}
    assert margins["torque"].extreme == plan.verification.torque_max_n_m > 1.0
    assert margins["singularity"].margin == plan.verification.gimbal_margin > 0.5
    assert all(one.margin > 0.0 for one in margins.values())
    h_n_m_s = plan.request.definition().craft.array.momentum(np.hsplit(plan.table.extra_rad, 2)[0])
    at_rows_n_m_s = np.linalg.norm(h_n_m_s, axis=1).max()
    assert margins["momentum"].extreme == pytest.approx(at_rows_n_m_s, abs=0.05)


def test_too_far_aside_is_refused_with_where_it_is():
    far = StripRequest(name="far", geometry=line(100.0, across_km=900.0))
    with pytest.raises(Unreachable, match=r"4[0-9]\.\d deg across|5[0-9]\.\d deg across") as why:
        plan_imaging(session([far], 240.0))
    assert why.value.field == "requests.0"
    assert why.value.at_utc is not None


def test_a_window_too_short_is_refused_with_the_nearest_that_works():
    strip = StripRequest(
        name="strip",
        geometry=line(100.0),
        window_start=EPOCH + timedelta(seconds=95.4),
        window_stop=EPOCH + timedelta(seconds=100),
    )
    with pytest.raises(Unreachable, match="window") as why:
        plan_imaging(session([strip], 240.0))
    assert why.value.field == "requests.0"
    opens, closes = why.value.earliest_feasible_start_utc, why.value.feasible_stop_utc
    # 60 km at 60/11 km/s, in whole cycles; around the window asked for, on the grid of 2 s.
    assert (closes - opens).total_seconds() == pytest.approx(11.0, abs=0.2)
    assert opens <= strip.window_start
    assert closes >= strip.window_stop
    strip = dataclasses.replace(strip, window_start=opens, window_stop=closes)
    assert plan_imaging(session([strip], 240.0, simulation_runs=0)).verification.passed


def test_no_time_to_turn_is_refused_with_the_session_it_takes():
    strip = StripRequest(name="strip", geometry=line(10.0), start=EPOCH + timedelta(seconds=3))
    with pytest.raises(InfeasibleSlew, match=r"works: 'strip' .* in a session from") as why:
        plan_imaging(session([strip], 240.0))
    start = why.value.earliest_feasible_start_utc
    assert why.value.field == "requests.0"
    assert abs((start - strip.start).total_seconds()) <= 1.0  # nearest on a grid of 2 s


def test_momentum_that_leaves_no_room_to_turn_is_refused():
    """59 of 60 N m s leave 1 for 800 kg m^2: 0.07 deg/s, what orbital orientation takes."""
    settings = SpacecraftSettings(momentum_n_m_s=(0.0, 0.0, 59.0))
    strip = StripRequest(name="strip", geometry=line(100.0))
    with pytest.raises(InfeasibleSlew, match=r"store 59\.0 N m s.*works: 45 N m s"):
        plan_imaging(session([strip], 240.0, settings=settings))


def test_a_stereo_pair_begins_when_asked():
    start = EPOCH + timedelta(seconds=180.4)
    pair = dataclasses.replace(four_modes()[1], start=start)
    plan = plan_imaging(session([pair], 420.0, simulation_runs=0))
    assert plan.windows[0].first_row == 902
    assert plan.verification.passed


def test_looks_are_as_far_apart_as_asked_around_the_moment_of_passing():
    pair = dataclasses.replace(four_modes()[1], gap_s=100.0)
    plan = plan_imaging(session([pair], 420.0, simulation_runs=0))
    first, second = plan.windows
    assert second.first_row - first.first_row == 500
    ahead_deg, behind_deg = (window.along_deg for window in plan.verification.windows)
    assert abs(ahead_deg - behind_deg) < 1.0  # a second's flight: the Earth turns meanwhile
    other = dataclasses.replace(pair, gap_s=101.0)
    asked = dataclasses.replace(plan.request, requests=(other,))
    only(judge(plan, request=asked), "looks 100.0 s apart, not 101 s")


def test_looks_too_far_apart_for_the_camera_are_refused_with_what_to_ask():
    pair = dataclasses.replace(four_modes()[1], gap_s=200.0)
    with pytest.raises(Unreachable, match="smaller gap_s"):
        plan_imaging(session([pair], 420.0))


def test_one_look_is_taken_from_nearest_overhead():
    plan = plan_imaging(session([StripRequest(name="s", geometry=line(150.0))], 300.0))
    assert plan.verification.windows[0].along_deg < 2.0  # candidates stand 2 s, 1.3 deg, apart


def corner():
    """A leg along the track and one across it."""
    start, end = line(150.0).coordinates
    return GeoLineString(coordinates=(start, end, (end[0] + 0.5, end[1])))


@pytest.mark.parametrize(
    "geometry",
    [line(200.0, azimuth_deg=90.0), line(200.0, azimuth_deg=180.0), corner()],
    ids=["across", "against", "corner"],
)
def test_a_corridor_lies_at_any_angle_to_the_track(geometry):
    """A slew about the vertical may take longer than any from ahead to the side."""
    corridor = CorridorRequest(name="corridor", geometry=geometry)
    plan = plan_imaging(session([corridor], 400.0, simulation_runs=1))
    assert max(slew.angle_rad for slew in plan.slews) > math.radians(70.0)
    assert plan.stabilisation.share_steady == 1.0


def test_momentum_beyond_the_sphere_is_refused_with_how_much_would_do():
    settings = SpacecraftSettings(momentum_n_m_s=(50.0, 40.0, 0.0))
    request = session([area(100.0)], 240.0, settings=settings)
    with pytest.raises(InfeasibleSlew, match=r"unload at least 10\.2 .*works: \d+ N m s") as why:
        plan_imaging(request)
    assert why.value.field == "settings.momentum_n_m_s"
    share = int(re.search(r"works: (\d+) N", why.value.detail)[1]) / np.hypot(50.0, 40.0)
    settings = SpacecraftSettings(momentum_n_m_s=(50.0 * share, 40.0 * share, 0.0))
    less = dataclasses.replace(request, settings=settings, simulation_runs=0)
    assert plan_imaging(less).verification.passed


def test_self_crossing_corridors_are_refused():
    with pytest.raises(ValueError, match=r"leg 0 and leg 2 meet.*0 to 2 and 2 to 3"):
        GeoLineString(coordinates=((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)))
    with pytest.raises(ValueError, match="crosses itself"):  # over the antimeridian too
        GeoLineString(coordinates=((179.5, 0.0), (-179.5, 1.0), (-179.5, 0.0), (179.5, 1.0)))
    GeoLineString(coordinates=((179.5, 0.0), (-179.5, 0.5), (-178.9, 0.0), (-179.5, -0.5)))
    GeoLineString(coordinates=((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)))  # one parallel


def test_rings_that_enclose_nothing_or_cross_themselves_are_refused():
    with pytest.raises(ValueError, match="side 0 and side 2 meet"):
        ring((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0))
    with pytest.raises(ValueError, match="encloses 0 km2"):
        ring((0.0, 0.0), (0.5, 0.5), (1.0, 1.0))
    with pytest.raises(ValueError, match="1 and 2 of the ring are the same"):
        ring((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    u = ((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (2.0, 2.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0))
    ring(*u, (0.0, 2.0))  # both tops on one parallel
    ring((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0))
    ring((179.5, 0.0), (-179.5, 0.0), (-179.5, 1.0), (179.5, 1.0))  # over the antimeridian
    ring((0.0, 0.0), (0.009, 0.0), (0.009, 0.0101), (0.0, 0.0101))  # 1.00 by 1.12 km


def ring(*corners):
    return GeoPolygon(coordinates=((*corners, corners[0]),))


def test_a_session_that_shakes_says_so(plan):
    shaken = dataclasses.replace(plan.stabilisation, share_steady=0.5)
    (warning,) = shaken.warnings
    assert "50% of the imaging intervals were steady within 0.001 deg/s" in warning
    assert not plan.stabilisation.warnings
