"""An imaging session over HTTP is planned, flown steadily, handed out and refused as promised."""

import json

import netCDF4
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.requests.examples import FOUR_MODES, SPACECRAFT_EXAMPLES
from planner.output.export import EXPORTERS

PLANS = "/v1/spacecraft/plans"
STRIP = SPACECRAFT_EXAMPLES["geojson"][1]


@pytest.fixture(scope="module")
def plan(client):
    return client.made(PLANS, json=FOUR_MODES)


def test_all_that_is_asked_is_imaged(plan):
    looks = [window["request"] for window in plan["windows"]]
    assert looks == ["strip", "stereo", "stereo", "corridor", "area", "area", "area", "area"]
    assert plan["left_out"] == []
    choice = plan["choice"]
    assert choice["value"] == choice["bound"] == 9.0  # 2 + 4 + 2 + 1
    assert choice["gap_share"] == 0.0
    assert plan["verification"]["passed"]
    assert {slew["time_from"] for slew in plan["slews"]} == {None}  # all the time there is


def test_rows_begin_in_orbital_orientation(plan):
    """Row 0 is the orbit's epoch: the optical axis -Y looks at the Earth's centre."""
    q = Rotation.from_quat(plan["table"]["q_body_from_eci_xyzw"][0])
    r = np.array(FOUR_MODES["orbit"]["position_km"])
    np.testing.assert_allclose(q.apply(-r / np.linalg.norm(r)), [0.0, -1.0, 0.0], atol=1e-6)


@pytest.fixture(scope="module")
def files(client):
    """The strip in every format and as JSON, without closed-loop runs."""
    request = {**STRIP, "simulation_runs": 0}
    made = client.post(PLANS, json=request).json()
    found = {"table": made}
    for name, exporter in EXPORTERS.items():
        if name == "csv":
            answer = client.post(PLANS, json=request, headers={"Accept": exporter.media_type})
        else:
            answer = client.get(f"{PLANS}/{made['id']}/table?format={name}")
        assert answer.is_success, answer.text
        assert answer.headers["content-type"].split(";")[0] == exporter.media_type
        assert f'"One-strip{exporter.suffix}"' in answer.headers["content-disposition"]
        found[name] = answer.content
    return found


def test_the_worked_geojson_is_planned(files):
    plan = files["table"]
    assert [window["request"] for window in plan["windows"]] == ["strip"]
    assert plan["stabilisation"]["share_steady"] is None
    assert plan["table"]["t_s"][-1] == 300.0


def test_a_slew_in_least_time_says_what_found_it(client):
    least = {"objective": "minimum_time", "simulation_runs": 0}
    answer = client.post(PLANS, json={**STRIP, **least}).json()
    assert {slew["time_from"] for slew in answer["slews"]} <= {"ocp"}


def test_netcdf_by_the_reference_library(files):
    with netCDF4.Dataset("session", memory=files["netcdf"]) as read:
        [window] = files["table"]["windows"]
        kinds = read["activity"].flag_meanings.split()
        tracks = np.flatnonzero(
            (read["activity"][:] == kinds.index("track")) & (read["session"][:] == 0)
        )
        # It is on the scan's line when it has settled, before the camera is on.
        assert tracks[0] <= window["first_row"]
        assert tracks[-1] + 1 == window["last_row"]


def test_a_session_is_a_plan_like_any_other(client, files):
    """It is flown, compared with its own table, and gone on after."""
    plan = files["table"]
    flights = client.post(f"/v1/plans/{plan['id']}/flights", json={"runs": 2})
    assert flights.status_code == 201, flights.text
    assert flights.json()["sessions"][0]["gyros"]["steady"] == 1.0
    samples = {
        "request": (None, json.dumps({"plan": plan["id"]})),
        "samples": ("table.csv", files["csv"]),
    }
    compared = client.post("/v1/telemetry/comparisons", files=samples)
    assert compared.status_code == 200, compared.text
    after = {
        "platform": "agile-cmg",
        "orbit": STRIP["orbit"],
        "initial_state": {"after": plan["id"]},
        "sessions": [
            {
                "start": "2024-06-01T10:06:30Z",
                "stop": "2024-06-01T10:06:32Z",
                "target": {"mode": "ground", "latitude_deg": 38.9, "longitude_deg": -18.3},
            }
        ],
    }
    following = client.post("/v1/plans?dry_run=true", json=after)
    assert following.status_code == 200, following.text


def changed(**members):
    return {**FOUR_MODES, **members}


def strip(*positions, **members):
    line = {"type": "LineString", "coordinates": [list(position) for position in positions]}
    return {"mode": "strip", "name": "s", "geometry": line, **members}


CROSSING = [[-12.0, 20.0], [-12.0, 21.0], [-12.5, 20.5], [-11.5, 20.5]]
CASES = {
    "a mode nobody knows": (
        changed(requests=[{**strip(*CROSSING[:2]), "mode": "spiral"}]),
        "invalid-request", "requests.0.mode", "corridor",
    ),
    "a mode left out": (
        changed(requests=[{"name": "s", "geometry": None}]),
        "invalid-request", "requests.0.mode", "strip, stereo",
    ),
    "a corridor that crosses itself": (
        changed(requests=[{**strip(*CROSSING), "mode": "corridor"}]),
        "invalid-request", "requests.0.geometry", "split it",
    ),
    "no GeoJSON": (changed(requests={"features": []}), "invalid-message", None, "FeatureColl"),
    "a feature with a wrong field": (
        changed(requests={"features": [{
            "properties": {"mode": "strip", "name": "s", "colour": "red"},
            "geometry": strip(*CROSSING[:2])["geometry"],
        }]}),
        "invalid-request", "requests.0.colour", "not a field",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_refused_with_reason_and_way_out(client, name):
    request, slug, field, says = CASES[name]
    answer = client.post(PLANS, json=request)
    assert answer.status_code == 422, answer.text
    problem = answer.json()
    assert problem["type"] == f"urn:slewtrack:problem:{slug}", problem
    assert problem.get("field") == field, problem
    assert says in problem["detail"], problem


def test_an_unknown_format_is_refused(client):
    problem = client.post(f"{PLANS}?format=pdf", json=STRIP).json()
    assert problem["field"] == "query.format"
    assert client.post(PLANS, json=STRIP, headers={"Accept": "image/webp"}).status_code == 406
