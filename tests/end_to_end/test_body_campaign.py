"""A campaign of a body: every pass is planned, verified, and idle at both ends."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_body_plans import SMALLSAT

from app.requests.campaign import CAMPAIGN_READER
from app.requests.plan import read_plan_request
from app.work import campaign as campaign_work
from planner.base.errors import InvalidRequest
from planner.planning.campaigns import choose_campaign, scenario_of
from planner.planning.sessions.pipeline import make_plan
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc

CITIES = json.loads((Path(__file__).parents[2] / "examples" / "campaign_cities.json").read_text())
OF_AXES = ("attitude", "rest_angles_deg")


def body_campaign(**changes):
    asked = {name: value for name, value in CITIES.items() if name not in OF_AXES}
    return CAMPAIGN_READER.read(json.dumps(asked | {"platform": SMALLSAT} | changes).encode())


@pytest.fixture(scope="module")
def chosen():
    request = body_campaign()
    return request, choose_campaign(request)


def test_looks_are_chosen_within_their_bound(chosen):
    _, campaign = chosen
    assert 0.0 < campaign.greedy_value <= campaign.value <= campaign.bound
    looks = [look for flight in campaign.passes for look in flight.looks]
    assert max(look.off_nadir_rad for look in looks) <= np.deg2rad(SMALLSAT["off_nadir_max_deg"])
    assert all(0.0 < look.probability_in_frame <= 1.0 for look in looks)
    between_s = [
        elapsed_s(later.start_utc, flight.stop_utc)
        for flight, later in zip(campaign.passes, campaign.passes[1:], strict=False)
    ]
    assert min(between_s, default=0.0) >= 0.0


def test_passes_are_planned_from_idle_to_idle_without_a_look_lost(chosen):
    request, campaign = chosen
    for number, flight in enumerate(campaign.passes):
        plan = make_plan(scenario_of(request, flight, number))
        assert plan.verification.passed
        assert len(plan.scenario.sessions) == len(flight.looks)
        for look, session in zip(flight.looks, plan.scenario.sessions, strict=True):
            assert abs(elapsed_s(session.start, look.start_utc)) <= 1.0
            assert abs(elapsed_s(session.stop, look.stop_utc)) <= 1.0
        table = plan.table
        assert elapsed_s(flight.start_utc, table.epoch_utc) == 0.0
        assert table.t_s[-1] <= elapsed_s(flight.stop_utc, flight.start_utc) + 0.2
        # Idle is to the nadir: the camera's axis lies against the position.
        ends = Instants(table.epoch_utc, table.t_s[[0, -1]])
        ephemeris = request.orbit.ephemeris(flight.start_utc, shifted_utc(flight.stop_utc, 60.0))
        r_sat_eci_m = ephemeris.states(ends).r_sat_eci_m
        boresight_eci = Rotation.from_quat(table.position[[0, -1]]).apply([0.0, 0.0, 1.0])
        down = np.einsum("ni,ni->n", boresight_eci, -r_sat_eci_m)
        np.testing.assert_allclose(down, np.linalg.norm(r_sat_eci_m, axis=1), rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"attitude": CITIES["attitude"]}, "attitude: must be left out for smallsat"),
        ({"rest_angles_deg": {"x": 0.0}}, "rest_angles_deg: must be left out for smallsat"),
        ({"slew": {"method": "spline"}}, "slew.method: must be ocp"),
        ({"slew": {"jerk_max_deg_s3": 0.5}}, "slew.jerk_max_deg_s3: must be left out"),
        ({"slew": {"keep_out": [{"body": "sun", "half_angle_deg": 20.0}]}}, "slew.keep_out: must"),
    ],
)
def test_what_only_axes_have_is_refused(change, words):
    with pytest.raises(InvalidRequest, match=words):
        body_campaign(**change)


def test_the_request_of_a_pass_is_read_as_it_was_chosen(chosen):
    """Its slew back to idle is bounded by the room that the pass has, whatever the words said."""
    asked = {name: value for name, value in CITIES.items() if name not in OF_AXES}
    body = json.dumps(asked | {"platform": SMALLSAT, "slew": {"lead": "all"}}).encode()
    request = CAMPAIGN_READER.read(body)
    flight = chosen[1].passes[0]
    part = campaign_work._part(json.loads(body), request, 0, flight)
    scenario = read_plan_request(part.request)
    assert scenario.slew == scenario_of(request, flight, 0).slew
    assert scenario.final_state == "idle"
    assert scenario.attitude is None
