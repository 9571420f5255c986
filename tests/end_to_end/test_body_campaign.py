"""A campaign of a body: every pass is planned, verified, and idle at both ends."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from agile_bodies import smallsat
from planner_values import planned_passes
from scipy.spatial.transform import Rotation
from test_body_plans import SMALLSAT

from app.requests.campaign import CAMPAIGN_READER
from app.requests.plan import read_plan_request
from app.work import campaign as campaign_work
from planner.base.errors import InvalidRequest, NotVisible
from planner.planning.campaigns import choose_campaign, scenario_of
from planner.planning.campaigns.platforms.body import BodyFollower
from planner.planning.sessions.pipeline import make_plan
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.world.platforms.body import AzimuthRoll

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
    for flight, plan in planned_passes(request, campaign):
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
    ("of_body", "kept"),
    [
        (True, {"direction_body": [1.0, 0.0, 0.0], "away_from": "sun", "min_deg": 80.0}),
        (True, {"of": "camera", "near": "nadir", "max_deg": 25.0}),
        (False, {"of": "camera", "away_from": "sun", "min_deg": 120.0}),
        (False, {"of": "camera", "near": "nadir", "max_deg": 40.0}),
    ],
)
def test_looks_keep_directions_and_are_planned(chosen, of_body, kept):
    directions = {"conditions": CITIES["conditions"] | {"directions": [kept | {"name": "kept"}]}}
    free = chosen[0] if of_body else CAMPAIGN_READER.read(json.dumps(CITIES).encode())
    request = replace(
        free, conditions=CAMPAIGN_READER.read(json.dumps(CITIES | directions).encode()).conditions
    )
    campaign, most = choose_campaign(request), choose_campaign(free).value
    assert 0.0 < campaign.value < most
    for flight, plan in planned_passes(request, campaign):
        assert len(plan.scenario.sessions) >= len(flight.looks)


@pytest.mark.parametrize("q_xyzw", [None, (0.6, 0.0, 0.8, 0.0)])
def test_a_pass_begins_at_the_start_and_ends_by_the_stop(chosen, q_xyzw):
    """With less room about a pass than the slowest slew takes, from idle and from elsewhere."""
    request, campaign = chosen
    looks = campaign.passes[0].looks
    start = shifted_utc(looks[0].start_utc, -60.0).replace(microsecond=0)
    stop = shifted_utc(looks[-1].stop_utc, 60.0).replace(microsecond=0)
    near = replace(request, start=start, stop=stop, initial_q_body_from_eci_xyzw=q_xyzw)
    [flight] = choose_campaign(near).passes
    assert BodyFollower(near).rest_s > 60.0
    assert flight.start_utc == start
    plan = make_plan(scenario_of(near, flight, 0))
    assert plan.verification.passed
    assert len(plan.scenario.sessions) == len(flight.looks)
    assert plan.table.t_s[-1] <= elapsed_s(stop, start)
    if q_xyzw is not None:
        assert abs(plan.table.position[0] @ np.array(q_xyzw)) == pytest.approx(1.0, abs=1e-9)


def test_the_attitude_at_the_start_is_a_body_s_and_of_unit_length():
    with pytest.raises(InvalidRequest, match="unit length"):
        body_campaign(initial_q_body_from_eci_xyzw=[0.0, 0.0, 0.5, 0.5])
    of_axes = CITIES | {"initial_q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 1.0]}
    with pytest.raises(InvalidRequest, match="whose axes begin at rest_angles_deg"):
        CAMPAIGN_READER.read(json.dumps(of_axes).encode())


def test_star_trackers_are_known_at_the_roll_that_looks_before_leave(monkeypatch):
    """Of 15 passes two would be refused by the trackers: the Sun's idle attitude lies far off."""
    fast = {"limits": "magnitude", "rate_max_deg_s": 4.0, "settle_s": 2.0}
    fast |= {"acceleration_max_deg_s2": 1.0, "jerk_max_deg_s3": 1.0}
    changes = {"torque_max_n_m": None, "inertia_kg_m2": None, "exclusions": None}
    idle = {"law": "sun", "direction_body": [-1.0, 0.0, 0.0]}
    body = smallsat(agility=fast, roll={"rule": "nearest"}, idle=idle, **changes)
    listed = json.loads((Path(__file__).parents[1] / "data" / "oco3_targets.json").read_text())
    places = np.random.default_rng(20150227).permutation(np.array(listed["targets"], object))[:40]
    request = body_campaign(
        targets=[
            {
                "id": str(number),
                "target": {"mode": "ground", "latitude_deg": row[2], "longitude_deg": row[3]},
                "session_s": 40.0,
                "min_session_s": 20.0,
            }
            for number, row in enumerate(places)
        ],
        start="2015-02-27T00:00:00Z",
        stop="2015-02-27T12:00:00Z",
        conditions={"min_elevation_deg": 30.0},
    )
    request = replace(request, platform=body)
    known = choose_campaign(request)
    for flight, plan in planned_passes(request, known):
        assert len(plan.scenario.sessions) == len(flight.looks)
    with monkeypatch.context() as unknown:
        unknown.setattr(BodyFollower, "first_unheld", lambda *given: None)
        blind = choose_campaign(request)
    # Sums of worths in another order differ in their last digits.
    assert known.value < blind.value <= known.bound * (1.0 + 1e-12)
    # Of the passes that differ, those of the blind choice can't be planned as they are.
    differ = [pair for pair in enumerate(blind.passes) if pair[1] not in known.passes]
    scenarios = [scenario_of(request, flight, number) for number, flight in differ]
    with pytest.raises(NotVisible, match="star_trackers"):
        list(map(make_plan, scenarios))


def test_looks_are_planned_by_a_roll_of_their_own(chosen):
    """The judge derives it anew."""
    roll = AzimuthRoll(azimuth_deg=70.0)
    targets = tuple(replace(one, roll=roll) for one in chosen[0].targets)
    request = replace(chosen[0], targets=targets)
    campaign = choose_campaign(request)
    assert len(campaign.passes) > 0
    for flight, plan in planned_passes(request, campaign):
        assert [one.id for one in plan.scenario.sessions] == [one.target for one in flight.looks]
        assert {one.roll for one in plan.scenario.sessions} == {roll}


@pytest.mark.parametrize("kind", ["body", "two_axis"])
def test_contacts_are_chosen_beside_looks(kind):
    """By night and near the horizon, where no look may be, and worth as much wherever they are."""
    station = {"mode": "station", "latitude_deg": 37.94, "longitude_deg": -75.46}
    wallops = {"id": "Wallops", "target": station, "session_s": 240.0, "looks": 9}
    targets = [CITIES["targets"][0], wallops]
    of_axes = {"platform": CITIES["platform"]} | {
        name: CITIES[name] for name in OF_AXES if name in CITIES
    }
    request = body_campaign(targets=targets, **(of_axes if kind == "two_axis" else {}))
    campaign = choose_campaign(request)
    looks = [look for flight in campaign.passes for look in flight.looks]
    contacts = [look for look in looks if look.target == "Wallops"]
    assert len(contacts) > 3
    assert [look.value for look in contacts] == pytest.approx([1.0] * len(contacts))
    assert min(np.rad2deg(look.elevation_rad) for look in contacts) < 10.0
    assert {look.target for look in looks} == {one["id"] for one in targets}
    for flight, plan in planned_passes(request, campaign):
        sent = [one for one in plan.scenario.sessions if one.target.mode == "station"]
        assert len(sent) == sum(look in contacts for look in flight.looks)


@pytest.mark.parametrize("kind", ["body", "two_axis"])
def test_looks_of_hours_are_chosen_and_planned(kind):
    """Stars near the pole of the ISS's orbit are never behind the Earth, and ten hours have room
    for a pass of 4.5 h with either."""
    asked = dict(CITIES, start="2015-02-27T00:00:00Z", stop="2015-02-27T10:00:00Z")
    if kind == "body":
        asked = {name: value for name, value in asked.items() if name not in OF_AXES}
        asked["platform"] = SMALLSAT | {"off_nadir_max_deg": 90.0}
    asked["conditions"] = {}
    asked["targets"] = [
        {"id": f"{ra_deg:g}", "session_s": 16_200.0, "target": {
            "mode": "star", "ra_deg": ra_deg, "dec_deg": dec_deg}}
        for ra_deg, dec_deg in ((174.5, 35.2), (187.4, 39.3))
    ]  # fmt: skip
    request = CAMPAIGN_READER.read(json.dumps(asked).encode())
    campaign = choose_campaign(request)
    assert campaign.passes
    assert {one.closed_by for one in campaign.unseen} <= {"motion"}  # an axis at its stop
    assert campaign.value == pytest.approx(2.0 - len(campaign.unseen))
    for flight, plan in planned_passes(request, campaign):
        assert plan.table.t_s[-1] <= 21_600.0
        look = flight.looks[0]
        assert plan.scenario.sessions[0].id == look.target
        assert elapsed_s(look.stop_utc, look.start_utc) == pytest.approx(16_200.0)


def test_longer_looks_count_more_among_what_a_campaign_may_ask():
    star = {"mode": "star", "ra_deg": 178.0, "dec_deg": 37.0}
    targets = [{"id": f"{n}", "session_s": 18_000.0, "target": star} for n in range(9)]
    days = {"start": "2015-02-27T00:00:00Z", "stop": "2015-03-01T12:00:00Z"}
    with pytest.raises(InvalidRequest, match="finer and longer count more"):
        body_campaign(targets=targets, **days)
    assert len(body_campaign(targets=targets[:8], **days).targets) == 8


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
    document = json.loads(body)
    asked = {target["id"]: target["target"] for target in document["targets"]}
    part = campaign_work._part(document, asked, document, request, 0, flight)
    scenario = read_plan_request(part.request)
    assert scenario.slew == scenario_of(request, flight, 0).slew
    assert scenario.final_state == "idle"
    assert scenario.attitude is None
