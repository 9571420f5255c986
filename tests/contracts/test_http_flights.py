"""Flights of a plan are a resource like the others, and the same however they are split."""

import asyncio
import json
from concurrent.futures import Future

import pytest
from job_cases import ended_with, new_job
from waiting import eventually

import slewtrack
from app.jobs.job_completion import settle
from app.jobs.kinds import FLIGHTS, JOB_KINDS, RUNS
from app.requests.examples import LAS_VEGAS
from app.requests.plan import read_plan_request
from app.store import events, jobs
from app.work import flights as flights_work
from planner.base.errors import Unreachable
from planner.inflight.flights.pipeline import fly_plan
from planner.planning.sessions.pipeline import make_plan

ASKED = {"runs": 6, "seed": 3, "moving_object": {"speed_m_s": 20.8}}
LATER = {"Prefer": "respond-async"}
NOBODY = "01a203fd-cbae-73f8-8276-319f76b8842c"
STILL = {"kind": "constant_rate", "angle_deg": 0.0, "rate_deg_s": 0.0}


@pytest.fixture(scope="module")
def plan_id(client):
    return client.post("/v1/plans", json=LAS_VEGAS).json()["id"]


@pytest.fixture(scope="module")
def flown(client, plan_id):
    answer = client.post(f"/v1/plans/{plan_id}/flights", json=ASKED)
    assert answer.status_code == 201, answer.text
    return answer


def test_what_is_pinned_is_told(flown, plan_id):
    told = flown.json()
    assert {"probability_in_frame", "probability_sharp", "contributors"} <= told.keys()
    assert (told["plan"], told["runs"], told["flown"], told["state"]) == (plan_id, 6, 6, "done")
    [session] = told["sessions"]
    low, high = session["in_frame_interval"]
    assert low <= session["probability_in_frame"] <= high
    assert session["probability_sharp"] <= session["probability_in_frame"]
    nominal = session["nominal"]
    assert nominal["held"] == nominal["frames"] == len(nominal["t_s"]) == 270
    assert nominal["moving_object_ground_m"] == pytest.approx(208.0)
    assert sum(session["misses"]["counts"]) + session["misses"]["beyond"] == 6


def test_a_drive_that_is_spent_is_told_by_its_session(client):
    """Sessions are counted from 1 where people read, as the budget's doubts are."""
    platform = client.get("/v1/platforms").json()["platforms"][0]
    for axis in ("outer", "inner"):
        stuck = {"coulomb_deg_s2": 50.0, "breakaway_deg_s2": 100.0, "torque_reserve": 1.0}
        platform[axis]["drive"] = stuck
    plan = client.post("/v1/plans", json={**LAS_VEGAS, "platform": platform})
    assert plan.status_code == 201, plan.text
    answer = client.post(f"/v1/plans/{plan.json()['id']}/flights", json={"runs": 2}).json()
    warnings = answer["warnings"]
    assert any("gives all its torque" in warning for warning in warnings)
    assert all(warning.startswith("session 1: ") for warning in warnings)


def test_a_body_is_flown_with_the_same_answer(client, flown):
    """The smallsat of the registry, whose causes are the body's own and whose lines are counted."""
    [session] = LAS_VEGAS["sessions"]
    body = LAS_VEGAS | {
        "platform": "smallsat-120kg",
        "initial_state": {"epoch": LAS_VEGAS["initial_state"]["epoch"]},
        "sessions": [session | {"start": "2015-02-27T17:36:46Z"}],
    }
    del body["attitude"]
    plan = client.post("/v1/plans", json=body)
    assert plan.status_code == 201, plan.text
    answer = client.post(f"/v1/plans/{plan.json()['id']}/flights", json=ASKED)
    assert answer.status_code == 201, answer.text
    told, of_axes = answer.json(), flown.json()
    assert told.keys() == of_axes.keys()
    assert told["sessions"][0].keys() == of_axes["sessions"][0].keys()
    causes = {one["cause"] for one in told["contributors"]}
    assert {"attitude knowledge", "attitude control", "vibration", "orbit"} <= causes
    assert not causes & {"attitude", "drive"}
    nominal = told["sessions"][0]["nominal"]
    lasts_s = nominal["t_s"][-1] - nominal["t_s"][0]
    assert nominal["frames"] == pytest.approx(10.0 * lasts_s, rel=0.01)  # ten lines a second
    assert nominal["held"] == nominal["frames"]
    assert told["warnings"] == []


def test_the_service_flies_what_python_flies(flown):
    """Parts in children of two workers, and one loop here: the same runs."""
    alone = fly_plan(make_plan(read_plan_request(json.dumps(LAS_VEGAS).encode())), 6, 3)
    told = flown.json()
    assert told["probability_in_frame"] == alone.in_frame.value
    assert told["sessions"][0]["frames_held"] == pytest.approx(alone.sessions[0].frames_held)
    assert told["sessions"][0]["miss_m"] == pytest.approx(alone.sessions[0].miss_m, rel=1e-6)
    assert [one["cause"] for one in told["contributors"]] == [
        one.cause for one in alone.contributors
    ]


def outcomes_of(part):
    return flights_work.unpacked_outcomes(flights_work.fly_part(part).document)


def test_it_is_the_same_however_it_is_split(sent):
    plan = flights_work.PLAN_TO_FLY.validate_json(sent)
    split = flights_work.prepare_flights(plan.to_bytes())
    assert len(split.parts) == 1
    by_two = [plan.to_bytes(first=first, count=2) for first in (4, 0, 2)]
    outcomes = [outcomes_of(part) for part in by_two]
    whole = outcomes_of(split.parts[0].request)
    in_order = sorted(outcomes, key=lambda part: part[0])
    for name, values in whole[1][0].columns.items():
        parts = [runs.columns[name] for _, [runs] in in_order]
        assert values.tolist() == [value for part in parts for value in part.tolist()]


@pytest.fixture(scope="module")
def sent(client, flown):
    """What the child was sent."""
    with client.app.state.database.reading() as connection:
        return jobs.request_of(connection, flown.json()["id"])


def test_it_is_kept_listed_and_followed(client, plan_id, flown):
    location = flown.headers["location"]
    assert location == f"/v1/flights/{flown.json()['id']}"
    assert client.get(location).json() == flown.json()
    for path in (f"/v1/plans/{plan_id}/flights", "/v1/flights"):
        listed = client.get(path).json()["flights"]
        assert flown.json()["id"] in [one["id"] for one in listed]
        assert listed[0]["targets"] == client.get("/v1/plans").json()["plans"][0]["targets"]
    assert client.get(f"/v1/plans/{plan_id}/flights?state=failed").json()["flights"] == []
    events = client.get(f"{location}/events").text
    assert '"stage": "runs", "done": 1, "of": 1, "percent": 100' in events
    assert events.rstrip().count('"state": "done"') == 1


def test_the_same_key_flies_once(client, plan_id):
    path = f"/v1/plans/{plan_id}/flights"
    given = {"json": {"runs": 2}, "headers": {**LATER, "Idempotency-Key": "once"}}
    first, again = (client.post(path, **given) for _ in range(2))
    assert first.status_code == again.status_code == 202
    assert first.json()["id"] == again.json()["id"]
    other = client.post(path, json={"runs": 4}, headers=given["headers"])
    assert other.status_code == 422
    assert other.json()["type"].endswith("idempotency-key-reused")


@pytest.mark.parametrize("runs", [1, 20_000])  # too few for any plan, too many of 200 s each
def test_what_is_out_of_bounds_is_refused_by_name(client, plan_id, runs):
    answer = client.post(f"/v1/plans/{plan_id}/flights", json={"runs": runs})
    assert answer.status_code == 422, answer.text
    assert answer.json()["field"] == "runs"


def test_what_can_not_fly_is_refused_plainly(client):
    motion = {"mode": "test_motion", "axes": {"alpha": STILL, "beta": STILL}}
    session = {**LAS_VEGAS["sessions"][0], "target": motion}
    test = client.post("/v1/plans", json=LAS_VEGAS | {"sessions": [session]}).json()
    answer = client.post(f"/v1/plans/{test['id']}/flights", json={})
    assert (answer.status_code, "no target" in answer.json()["detail"]) == (422, True)
    assert client.post(f"/v1/plans/{NOBODY}/flights", json={}).status_code == 404
    with client.app.state.database.writing() as connection:
        cancelled = new_job("plan", request=b"{}")
        jobs.accept(connection, cancelled)
        jobs.cancel(connection, cancelled.id)
    assert client.get(f"/v1/plans/{cancelled.id}").json()["state"] == "cancelled"
    assert client.post(f"/v1/plans/{cancelled.id}/flights", json={}).status_code == 409


def test_flights_go_with_their_plan(client):
    plan_id = client.post("/v1/plans", json=LAS_VEGAS).json()["id"]
    location = client.post(f"/v1/plans/{plan_id}/flights", json={"runs": 2}).headers["location"]
    running = client.post(f"/v1/plans/{plan_id}/flights", json={"runs": 2000}, headers=LATER)
    assert client.delete(f"/v1/plans/{plan_id}").status_code == 204
    for gone in (location, running.headers["location"], f"/v1/plans/{plan_id}/flights"):
        assert client.get(gone).status_code == 404
    assert client.post(f"/v1/plans/{plan_id}/flights", json={"runs": 2}).status_code == 404


def test_they_are_cancelled_with_all_their_parts(client, plan_id):
    location = client.post(
        f"/v1/plans/{plan_id}/flights", json={"runs": 4000}, headers=LATER
    ).headers["location"]
    eventually(lambda: '"waits_for"' in json.dumps(_events(client, location)))
    ended = client.delete(location)
    assert ended.status_code in (200, 202)
    eventually(lambda: client.get(location).json()["state"] == "cancelled")
    assert client.delete(location).status_code == 204
    assert client.get(location).status_code == 404


def _events(client, location):
    with client.app.state.database.reading() as connection:
        return [event.data for event in events.after(connection, location.rsplit("/")[-1], 0)]


def test_a_part_that_fails_is_told_of_the_whole(client, sent):
    """No probability of the runs that are left is passed off as that of all."""
    new = flights_work.prepare_flights(sent)
    database = client.app.state.database
    whole = new_job(FLIGHTS.name, options={"runs": 6, "seed": 3, jobs.NEEDS_ALL: "runs"})
    with database.writing() as connection:
        token = jobs.accept(connection, whole, 60.0)
    assert ended_with(database, FLIGHTS, token, new) == "running"
    failed: Future = Future()
    failed.set_exception(Unreachable("no way"))
    with database.writing() as connection:
        [part] = jobs.parts_of(connection, whole.id)
        settle(connection, part, RUNS, failed, 3)
    told = client.get(f"/v1/flights/{whole.id}").json()
    assert (told["state"], told["problem"]["detail"]) == ("refused", "no way")
    assert told["probability_in_frame"] is None
    assert set(JOB_KINDS) >= {"flights", "flight runs"}


def test_clients_fly_and_wait(service):
    told = []
    with slewtrack.Client(service.address) as client:
        plan_id = client.plan(LAS_VEGAS).id
        flown = client.fly(plan_id, {"runs": 2, "seed": 1}, progress=told.append)
        assert (flown.flown, flown.state) == (2, "done")
        assert 0.0 <= flown.probability_sharp <= flown.probability_in_frame <= 1.0
        assert client.wait_for_flights(flown.id).members == flown.members
        assert [job.id for job in client.flights(plan_id)] == [flown.id]
        assert flown.id in [job.id for job in client.flights()]

        async def awaited():
            async with slewtrack.AsyncClient(service.address) as there:
                again = await there.fly(plan_id, {"runs": 2, "seed": 1})
                assert len(await there.flights(plan_id)) == 2
                await there.delete_flights(again.id)
                return again

        assert asyncio.run(awaited()).sessions == flown.sessions
        client.delete_flights(flown.id)
        with pytest.raises(slewtrack.Refused):
            client.wait_for_flights(flown.id)
    assert "runs" in [progress.stage for progress in told]
