"""The initial state of a request that leaves it out, in part or whole, or names a plan."""

import copy
import json

import numpy as np
import pytest
from planner_values import plan_of, read_request

from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES
from planner.planning.sessions.platforms.two_axis.slew_timing import OPTIONS as SLEW_TIMING_OPTIONS
from planner.world.frames.time_scales import elapsed_s, utc_from_text, utc_text

DENVER = {"mode": "ground", "latitude_deg": 39.74, "longitude_deg": -104.98, "height_m": 1600.0}
FIRST = utc_from_text(LAS_VEGAS["sessions"][0]["start"])


def request(state=None, sessions=None, example="tle", **changes):
    document = copy.deepcopy(PLAN_EXAMPLES[example][1]) | changes
    del document["initial_state"]
    if state is not None:
        document["initial_state"] = state
    if sessions is not None:
        document["sessions"] = [
            {"target": target, "start": start, "stop": stop} for target, start, stop in sessions
        ]
    return document


def post(client, document, query=""):
    return client.post(f"/v1/plans{query}", json=document)


def ok(answer):
    assert answer.status_code == 201, answer.text
    return answer.json()


def assumed(plan):
    return {one["field"]: one["members"] for one in plan["assumed"]}


@pytest.mark.parametrize("example", ["tle", "platform"])
def test_left_out_it_is_rest_at_zero_in_time_for_the_first_slew(example):
    plan = plan_of(request(example=example))
    scenario = plan.scenario
    assert set(scenario.initial_state.angles_deg.values()) == {0.0}
    assert (plan.table.position[0] == 0.0).all()
    assert (plan.table.rate_rad_s[0] == 0.0).all()
    assert scenario.initial_state.epoch.microsecond == 0
    # Early enough for as gentle a slew as there is, wherever the target: the bound of the lead.
    [run] = plan.slews
    assert run.duration_s <= elapsed_s(FIRST, scenario.initial_state.epoch)
    assert run.duration_s == pytest.approx(
        SLEW_TIMING_OPTIONS.recommended_times * run.minimum_s, abs=0.3
    )
    told = {one.field: one.members for one in scenario.assumed}
    assert told["initial_state.epoch"] == {"epoch": utc_text(scenario.initial_state.epoch, 1)}
    assert told["initial_state.angles_deg"] == {"angles_deg": scenario.initial_state.angles_deg}


def test_what_the_answer_says_was_taken_plans_the_same():
    left_out = plan_of(request({}))
    said = {}
    for one in left_out.scenario.assumed:
        said |= one.members
    in_full = plan_of(request(said))
    assert (in_full.table.position == left_out.table.position).all()
    assert in_full.scenario.assumed == ()


@pytest.mark.parametrize(
    ("given", "row"),
    [("17:34:00.430Z", "17:34:00.4Z"), ("17:34:00.199999Z", "17:34:00.0Z"),
     ("17:34:00.999Z", "17:34:00.8Z"), ("17:34:59.9999999Z", "17:35:00.0Z")],
)  # fmt: skip
def test_an_epoch_off_the_rows_is_put_on_the_one_before(given, row):
    state = LAS_VEGAS["initial_state"] | {"epoch": f"2015-02-27T{given}"}
    scenario = read_request(request(state))
    assert scenario.initial_state.epoch == utc_from_text(f"2015-02-27T{row}")
    if given == "17:34:59.9999999Z":  # rounded to the microsecond, it is on a row
        assert scenario.assumed == ()
    else:
        [said] = scenario.assumed
        assert said.members == {"epoch": f"2015-02-27T{row}"}


def test_an_epoch_in_a_leap_second_stays_in_it():
    sessions = [
        (LAS_VEGAS["sessions"][0]["target"], "2016-12-31T23:59:59Z", "2017-01-01T00:01:00Z")
    ]
    state = LAS_VEGAS["initial_state"] | {"epoch": "2016-12-31T23:59:60.53Z"}
    later = [(target, "2017-01-01T00:00:30Z", stop) for target, _, stop in sessions]
    scenario = read_request(request(state, later))
    assert utc_text(scenario.initial_state.epoch, 1) == "2016-12-31T23:59:60.4Z"


def test_axes_at_rest_somewhere_need_no_epoch():
    plan = plan_of(request({"angles_deg": {"alpha": 40.0, "beta": -20.0}}))
    assert np.rad2deg(plan.table.position[0]) == pytest.approx([40.0, -20.0])
    assert [one.field for one in plan.scenario.assumed] == ["initial_state.epoch"]


def test_a_plan_goes_on_where_one_that_moves_ends(client):
    first = ok(post(client, request()))
    table = first["table"]
    start, stop = "2015-02-27T17:38:30Z", "2015-02-27T17:38:50Z"
    document = request({"after": first["id"]}, [(DENVER, start, stop)])
    second = ok(post(client, document))
    assert second["table"]["epoch"] == LAS_VEGAS["sessions"][0]["stop"].replace("Z", ".0Z")
    for column in ("alpha_deg", "beta_deg", "alpha_rate_deg_s", "beta_rate_deg_s"):
        assert second["table"][column][0] == pytest.approx(table[column][-1], abs=1e-9)
    assert any(abs(table[f"{axis}_rate_deg_s"][-1]) > 0.1 for axis in ("alpha", "beta"))
    said = assumed(second)["initial_state.after"]
    assert said["epoch"] == second["table"]["epoch"]
    assert post(client, document, "?dry_run=true").status_code == 200


def test_a_plan_goes_on_where_one_at_rest_ends_when_it_is_time(client):
    rest = {"angles_deg": {"alpha": -30.0, "beta": 45.0}}
    first = ok(post(client, request(final_state=rest)))
    # A pass a day later: the axes wait where they are, and the table is no day long.
    session = (LAS_VEGAS["sessions"][0]["target"], "2015-02-28T16:45:00Z", "2015-02-28T16:45:20Z")
    second = ok(post(client, request({"after": first["id"]}, [session])))
    read = read_request(request({"angles_deg": rest["angles_deg"]}, [session]))
    assert second["table"]["epoch"] == utc_text(read.initial_state.epoch, 1)
    assert [second["table"][f"{axis}_deg"][0] for axis in ("alpha", "beta")] == [-30.0, 45.0]


def test_a_plan_right_after_one_at_rest_begins_at_its_end(client):
    first = ok(post(client, request(final_state="rest")))
    session = (DENVER, "2015-02-27T17:38:50Z", "2015-02-27T17:39:10Z")
    second = ok(post(client, request({"after": first["id"]}, [session])))
    assert second["table"]["epoch"] == first["segments"][-1]["stop"].replace("00Z", "Z")
    assert second["table"]["alpha_deg"][0] == pytest.approx(first["table"]["alpha_deg"][-1])


def test_flights_have_no_end_to_go_on_after(client):
    first = ok(post(client, request()))
    flights = client.post(f"/v1/plans/{first['id']}/flights", json={"runs": 2}).json()
    problem = post(client, request({"after": flights["id"]})).json()
    assert (problem["status"], problem["field"]) == (422, "initial_state.after"), problem


def test_a_start_before_the_end_of_the_plan_is_refused(client):
    first = ok(post(client, request()))
    problem = post(client, request({"after": first["id"]})).json()
    assert problem["status"] == 422
    assert "must not come before initial_state.epoch" in problem["detail"]


@pytest.mark.parametrize(
    ("state", "status", "says"),
    [
        ({"after": "01a203fd-cbae-73f8-8276-319f76b8842c"}, 422, "there is no plan"),
        ({"after": "../../etc"}, 422, "there is no plan"),
        ({"after": ""}, 422, "there is no plan ''"),
        ({"after": "x" * 10_000}, 422, "at most 200 characters"),
        ({"after": "01a203fd\n\x00"}, 422, "U+000A, which can't be seen"),
        ({"after": 7}, 422, "string"),
        ({"after": "x", "epoch": "2015-02-27T17:34:00Z"}, 422, "leave out all but after"),
    ],
)
def test_a_plan_that_there_is_not(client, state, status, says):
    problem = post(client, request(state)).json()
    assert (problem["status"], problem["field"]) == (status, "initial_state.after"), problem
    assert says in problem["detail"]
    assert len(json.dumps(problem)) < 1500


def test_a_refused_plan_has_no_end(client):
    hidden = [(LAS_VEGAS["sessions"][0]["target"], "2015-02-27T18:36:20Z", "2015-02-27T18:36:40Z")]
    refused = post(client, request(sessions=hidden))
    plan_id = refused.headers["location"].rsplit("/", 1)[1]
    problem = post(client, request({"after": plan_id})).json()
    assert (problem["status"], problem["field"]) == (409, "initial_state.after")
    assert "refused" in problem["detail"]


def test_axes_of_another_platform_do_not_go_on(client):
    first = ok(post(client, request()))
    session = (LAS_VEGAS["sessions"][0]["target"], "2015-02-27T17:38:30Z", "2015-02-27T17:38:50Z")
    later = request({"after": first["id"]}, [session], example="platform")
    problem = post(client, later).json()
    assert problem["status"] == 422
    assert "azimuth, tilt" in problem["detail"]


def test_the_same_key_gets_the_same_plan(client):
    first = ok(post(client, request()))
    session = (DENVER, "2015-02-27T17:38:30Z", "2015-02-27T17:38:50Z")
    document = request({"after": first["id"]}, [session])
    key = {"Idempotency-Key": f"after {first['id']}"}
    once, again = (client.post("/v1/plans", json=document, headers=key) for _ in range(2))
    assert once.json()["id"] == again.json()["id"]


IDLE_END = {"final_state": "idle"}


def of_body(state, start, stop, **changes):
    """Las Vegas with a spacecraft that turns as a whole."""
    target = LAS_VEGAS["sessions"][0]["target"]
    document = request(state, [(target, start, stop)], platform="smallsat-120kg", **changes)
    del document["attitude"]
    return document


def test_a_body_goes_on_where_its_plan_ends(client):
    first = ok(post(client, of_body({}, "2015-02-27T17:36:46Z", "2015-02-27T17:36:56Z")))
    later = of_body({"after": first["id"]}, "2015-02-27T17:37:08Z", "2015-02-27T17:37:12Z")
    second = ok(post(client, later))
    assert second["table"]["epoch"] == "2015-02-27T17:36:56.0Z"
    columns = [name for name in first["table"] if name.startswith(("q_", "omega_", "alpha_"))]
    assert len(columns) == 10
    ends, begins = ([plan["table"][name] for name in columns] for plan in (first, second))
    sign = 1.0 if ends[3][-1] >= 0.0 else -1.0  # a table begins with w that isn't negative
    for name, end, begin in zip(columns, ends, begins, strict=True):
        turned = sign if name.startswith("q_") else 1.0
        assert begin[0] == pytest.approx(turned * end[-1], abs=1e-9), name
    said = assumed(second)["initial_state.after"]
    assert said.keys() == {
        "epoch", "q_body_from_eci_xyzw", "omega_body_deg_s", "alpha_body_deg_s2", "past_looks"
    }  # fmt: skip
    written_out = ok(post(client, later | {"initial_state": said}))
    assert written_out["table"]["omega_body_deg_s_x"] == second["table"]["omega_body_deg_s_x"]


@pytest.mark.parametrize("final", [{}, IDLE_END])
def test_sessions_of_the_plans_before_count_for_gaps_and_duty_cycles(client, final):
    first = of_body({}, "2015-02-27T17:36:46Z", "2015-02-27T17:36:56Z", **final)
    after = {"after": ok(post(client, first))["id"]}
    later = of_body(after, "2015-02-27T17:59:00Z", "2015-02-27T17:59:10Z", **IDLE_END)
    later["sessions"][0]["target"] = {"mode": "star", "name": "Vega"}
    duty = {"imaging_max_s": 15.0, "span_s": 5000.0}
    for rule, says in (({"min_gap_s": 5000.0}, "min_gap"), ({"duty_cycle": duty}, "duty_cycle")):
        problem = post(client, later | {"conditions": rule})
        assert problem.status_code == 422
        assert problem.json()["limit"] == says
    second = ok(post(client, later | {"conditions": {"min_gap_s": 600.0}}))
    kept = client.get(f"/v1/plans/{second['id']}/request").json()["initial_state"]["past_looks"]
    [look] = [{name: at.split(".")[0] for name, at in one.items()} for one in kept]
    assert look == {"start": "2015-02-27T17:36:46", "stop": "2015-02-27T17:36:56"}


def test_resources_go_on_with_what_the_plan_before_leaves(client):
    resources = {
        "battery": {"capacity_wh": 180.0, "idle_w": 38.0, "imaging_w": 75.0},
        "memory": {"capacity_gbit": 512.0, "imaging_gbit_s": 1.6},
        "momentum": {"capacity_n_m_s": [0.9, 0.9, 0.9], "start_n_m_s": [0.1, -0.2, 0.0]},
    }
    first = of_body({}, "2015-02-27T17:36:46Z", "2015-02-27T17:36:56Z", **IDLE_END)
    first = ok(post(client, first | {"resources": resources}))
    left = {one["name"]: one["last"] for one in first["resources"]}
    assert left["memory"] == pytest.approx(16.0)
    assert left["battery"] < 180.0
    battery, momentum = resources["battery"], resources["momentum"]
    del momentum["start_n_m_s"]
    later = {"resources": resources | {"battery": battery | {"start_wh": 170.0}}, **IDLE_END}
    later = of_body({"after": first["id"]}, "2015-02-27T17:59:00Z", "2015-02-27T17:59:10Z", **later)
    later["sessions"][0]["target"] = {"mode": "star", "name": "Vega"}
    second = ok(post(client, later))
    assert second["table"]["epoch"] == first["segments"][-1]["stop"].replace("00Z", "Z")
    kept = client.get(f"/v1/plans/{second['id']}/request").json()["resources"]
    assert kept["battery"]["start_wh"] == 170.0
    assert kept["memory"]["start_gbit"] == left["memory"]
    assert kept["momentum"]["start_n_m_s"] == [left[f"momentum_{axis}"] for axis in "xyz"]


def test_a_body_at_rest_waits_where_it_is_until_it_is_time(client):
    still = {"law": "inertial", "q_body_from_eci_xyzw": [0.5, 0.5, 0.5, 0.5]}
    platform = client.get("/v1/platforms").json()["platforms"]
    [body] = [one for one in platform if one["name"] == "smallsat-120kg"]
    resting = {"platform": body | {"idle": still, "off_nadir_max_deg": 60.0}} | IDLE_END
    first = of_body({}, "2015-02-27T17:36:46Z", "2015-02-27T17:36:56Z") | resting
    after = {"after": ok(post(client, first))["id"]}
    second = of_body(after, "2015-02-28T16:45:00Z", "2015-02-28T16:45:20Z") | resting
    table = ok(post(client, second))["table"]
    assert table["epoch"].startswith("2015-02-28T16:")
    assert [table[f"q_eci_from_body_{part}"][0] for part in "xyzw"] == pytest.approx(
        [-0.5, -0.5, -0.5, 0.5], abs=1e-9
    )


def test_a_body_on_its_idle_attitude_keeps_to_it_until_it_is_time(client):
    """Looking down it turns once an orbit and never rests; a day from there is no table."""
    platforms = client.get("/v1/platforms").json()["platforms"]
    [body] = [one for one in platforms if one["name"] == "smallsat-120kg"]
    body |= {"star_trackers": None, "exclusions": []}
    idle = {"platform": body | {"idle": {"law": "nadir"}}} | IDLE_END
    first = of_body({}, "2015-02-27T17:36:46Z", "2015-02-27T17:36:56Z") | idle
    after = {"after": ok(post(client, first))["id"]}
    times = {"start": "2015-02-28T18:21:20Z", "stop": "2015-02-28T18:21:30Z"}
    idle["sessions"] = [{"target": {"mode": "star", "name": "Vega"}, **times}]
    later = first | idle | {"initial_state": after}
    second, unnamed = ok(post(client, later)), ok(post(client, first | idle))
    assert second["table"] == unnamed["table"]
    assert second["table"]["epoch"].startswith("2015-02-28T1")
    assert assumed(second) == assumed(unnamed)
    # Another law doesn't lead on from where the body was left: that is told, as before.
    other = {"platform": body | {"idle": {"law": "nadir", "forward_body": [0.0, 1.0, 0.0]}}}
    problem = post(client, later | other).json()
    assert problem["status"] == 422
    assert "must end within 86400 s of initial_state.epoch" in problem["detail"]


def test_two_axes_have_no_attitude_to_begin_with(client):
    """Neither asked for nor as the end of a body's plan."""
    times = ("2015-02-27T17:36:46Z", "2015-02-27T17:36:56Z")
    ends = [ok(post(client, of_body({}, *times, **end)))["id"] for end in ({}, IDLE_END)]
    for state in ({"q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 1.0]}, *({"after": id} for id in ends)):
        session = (DENVER, "2015-02-27T20:38:30Z", "2015-02-27T20:38:50Z")
        problem = post(client, request(state, [session])).json()
        assert (problem["status"], problem["field"]) == (422, "initial_state.q_body_from_eci_xyzw")
        assert "only a body has it" in problem["detail"]
