"""The picture for Cesium shows the ground the camera sees."""

import json
from datetime import timedelta

import erfa
import numpy as np
import pytest
from export_cases import CREATED_UTC, EXAMPLE, ISS, LAS_VEGAS, case, state_vector

from app.requests.plan import read_plan_request
from planner.output.export import EXPORTERS
from planner.planning.sessions.pipeline import make_plan
from planner.world.frames.time_scales import elapsed_s, utc_from_text
from planner.world.platforms import ISS_HRC

WGS84 = 1  # ERFA's number for it


def packets_of(plan):
    document = json.loads(EXPORTERS["czml"].write(plan, CREATED_UTC))
    return {packet["id"]: packet for packet in document}


def samples(packet):
    tagged = np.reshape(packet["position"]["cartesian"], (-1, 4))
    return tagged[:, 0], tagged[:, 1:]


@pytest.fixture(scope="module")
def las_vegas():
    plan = make_plan(read_plan_request(EXAMPLE.read_bytes()))
    return plan, packets_of(plan)


def test_the_boresight_of_a_real_plan_runs_through_its_target(las_vegas):
    """And the target, 610 m up, stands at its WGS84 place."""
    plan, packets = las_vegas
    expected_m = erfa.gd2gc(
        WGS84, np.deg2rad(LAS_VEGAS.longitude_deg), np.deg2rad(LAS_VEGAS.latitude_deg), 610.0
    )
    target_m = np.array(packets["target-0"]["position"]["cartesian"])
    np.testing.assert_allclose(target_m, expected_m, rtol=0, atol=1e-3)  # printed millimetre

    t_s, carrier_m = samples(packets["carrier"])
    _, end_m = samples(packets["boresight-end"])
    session = plan.scenario.sessions[0]
    start_s, stop_s = (elapsed_s(at, plan.table.epoch_utc) for at in (session.start, session.stop))
    tracked = (t_s >= start_s) & (t_s <= stop_s)
    along = end_m[tracked] - carrier_m[tracked]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    miss_m = np.linalg.norm(np.cross(target_m - carrier_m[tracked], along), axis=1)
    # The Earth turns by up to 465 m/s x 3 ms while light is under way; printed to 1 cm.  Were
    # the aberration left in, it would be 10 m and more.
    assert miss_m.max() < 1.5


def test_the_end_of_the_boresight_is_on_the_ellipsoid(las_vegas):
    _, end_m = samples(las_vegas[1]["boresight-end"])
    height_m = erfa.gc2gd(WGS84, end_m)[2]
    assert np.abs(height_m).max() < 0.02  # printed to 1 cm in each coordinate


def test_the_footprint_is_the_papers_frame():
    """5.36 x 3.56 km from 350 km, so many microradians from anywhere."""
    packets = packets_of(case(platform=ISS_HRC, tilt=0.3))
    t_s, carrier_m = samples(packets["carrier"])
    corners_m = []
    for number in range(4):
        at_s, corner_m = samples(packets[f"footprint-{number}"])
        np.testing.assert_array_equal(at_s, t_s)
        assert np.abs(erfa.gc2gd(WGS84, corner_m)[2]).max() < 0.02  # printed to 1 cm
        corners_m.append(corner_m - carrier_m)
    rays = [c / np.linalg.norm(c, axis=1, keepdims=True) for c in corners_m]
    half_x, half_y = 2.68 / 350.0, 1.78 / 350.0
    long = np.arccos((1.0 - half_x**2 + half_y**2) / (1.0 + half_x**2 + half_y**2))
    short = np.arccos((1.0 + half_x**2 - half_y**2) / (1.0 + half_x**2 + half_y**2))
    for (i, j), expected_rad in (((0, 1), long), ((3, 2), long), ((1, 2), short), ((0, 3), short)):
        seen_rad = np.linalg.norm(rays[i] - rays[j], axis=1)
        # aberration stretches angles by v/c = 2.6e-5; corners are printed to 1 cm of 400 km
        np.testing.assert_allclose(seen_rad, expected_rad, rtol=3e-5, atol=1e-7)


def test_the_footprint_is_available_only_while_all_of_it_is_on_the_ground():
    """Swung past the limb and back: at the ends of each interval the Earth is still in frame."""
    plan = case(platform=ISS_HRC, tilt=1.6, seconds=62)
    packets = packets_of(plan)
    spans = [span.split("/") for span in packets["footprint"]["availability"]]
    assert len(spans) > 1
    at_s, _ = samples(packets["footprint-0"])
    for start, stop in spans:
        first_s, last_s = (
            elapsed_s(utc_from_text(at), plan.table.epoch_utc) for at in (start, stop)
        )
        inside = at_s[(at_s >= first_s) & (at_s <= last_s)]
        np.testing.assert_allclose(
            np.diff(inside), 0.2, rtol=0, atol=1e-9
        )  # rounding of 0.1 s text
        assert (inside[0], inside[-1]) == (first_s, last_s)
    assert sum(len(packets[f"footprint-{k}"]["position"]["cartesian"]) for k in range(4)) == (
        4 * 4 * len(at_s)
    )


def test_the_session_is_when_the_target_is_available(las_vegas):
    plan, packets = las_vegas
    start, stop = packets["target-0"]["availability"].split("/")
    session = plan.scenario.sessions[0]
    assert (utc_from_text(start), utc_from_text(stop)) == (session.start, session.stop)


def test_orbits_without_a_name_are_unknown_to_the_messages():
    plan = case(orbit=state_vector(ISS.epoch_utc + timedelta(hours=6)))
    plan_lines = EXPORTERS["oem"].write(plan, CREATED_UTC).decode().splitlines()
    assert "OBJECT_NAME = UNKNOWN" in plan_lines
    assert "OBJECT_ID = UNKNOWN" in plan_lines
