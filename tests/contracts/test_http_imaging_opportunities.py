"""The spacecraft's opportunities over HTTP are kept like a platform's, and can be planned."""

import copy
import json

import pytest
from databases import own_settings
from waiting import PatientClient

from app.http.app import create_app
from app.requests.examples import IMAGING_OPPORTUNITY_EXAMPLES, SPACECRAFT_EXAMPLES

ASKED = IMAGING_OPPORTUNITY_EXAMPLES["four modes"][1]
PATH = "/v1/spacecraft/opportunities"
GEOJSON = {"Accept": "application/geo+json"}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    settings = own_settings(tmp_path_factory.mktemp("imaging"))
    with PatientClient(create_app(settings)) as client:
        yield client


@pytest.fixture(scope="module")
def found(client):
    answer = client.post(f"{PATH}?include=view", json=ASKED)
    assert answer.status_code == 200, answer.text
    assert answer.headers["Location"] == f"{PATH}/{answer.json()['id']}"
    return answer.json()


def changed(**members):
    return copy.deepcopy(ASKED) | members


def test_passes_are_told_by_request(found):
    assert {window["target"] for window in found["windows"]} == {
        "strip",
        "stereo",
        "corridor",
        "area",
    }
    assert (found["name"], found["unseen"]) == ("Atlantic, by day", [])
    geometry = {request["name"]: request["geometry"] for request in ASKED["requests"]}
    for window in found["windows"]:
        assert window["geometry"] == geometry[window["target"]]
        assert window["rise"] <= window["whole"]["start"] < window["whole"]["stop"] <= window["set"]
        assert window["closest"]["angles_deg"].keys() == {"along", "across"}
        assert abs(window["closest"]["angles_deg"]["along"]) < 1.0  # abeam
        assert window["sky"]["culmination"]["sun_elevation_deg"] >= 10.0
        assert "branch" not in window


def test_the_session_of_each_window_can_be_planned(client, found):
    """With the very request that was searched for."""
    for window in found["windows"]:
        [asked] = [one for one in ASKED["requests"] if one["name"] == window["target"]]
        session = {"orbit": ASKED["orbit"], **window["session"], "requests": [asked]}
        plan = client.post("/v1/spacecraft/plans", json=session | {"simulation_runs": 0})
        assert plan.status_code == 201, plan.text
        assert plan.json()["left_out"] == []
        for look in plan.json()["windows"]:
            assert window["rise"] <= look["start"] < look["stop"] <= window["set"]


def test_they_are_kept_and_found(client, found):
    at = f"{PATH}/{found['id']}"
    assert client.get(f"{at}?include=view").json() == found
    assert client.get(f"{at}/request").json() == ASKED
    page = client.get(f"{at}?target=area&limit=1&include=view").json()
    assert page["windows"] == [w for w in found["windows"] if w["target"] == "area"][:1]
    [row] = client.get(f"{PATH}?target=corridor").json()["opportunities"]
    assert (row["id"], row["platform"]) == (found["id"], "agile-cmg")
    assert client.get("/v1/opportunities").json()["opportunities"] == []
    assert client.get(f"/v1/opportunities/{found['id']}").status_code == 404


def test_geojson_holds_what_was_asked_for(client, found):
    features = client.get(f"{PATH}/{found['id']}", headers=GEOJSON).json()["features"]
    for feature, window in zip(features, found["windows"], strict=True):
        assert feature["geometry"] == window["geometry"]
        assert feature["properties"]["target"] == window["target"]


def test_features_are_taken_as_in_a_plan(client):
    plan = SPACECRAFT_EXAMPLES["geojson"][1]
    members = {name: plan[name] for name in ("orbit", "start", "stop", "requests")}
    answer = client.post(PATH, json=members)
    assert answer.status_code == 200, answer.text
    names = {feature["properties"]["name"] for feature in plan["requests"]["features"]}
    assert {window["target"] for window in answer.json()["windows"]} == names


STRIP = ASKED["requests"][0]
FAR = {"type": "LineString", "coordinates": [[100.0, -20.0], [100.1, -20.4]]}


def test_what_no_pass_shows_is_listed(client):
    short = changed(requests=[STRIP | {"geometry": FAR}], stop="2024-06-01T10:20:00Z")
    answer = client.post(PATH, json=short).json()
    assert (answer["windows"], answer["unseen"]) == ([], ["strip"])


@pytest.mark.parametrize(
    ("members", "field", "says"),
    [
        ({"requests": []}, "requests", "at least one"),
        ({"requests": [STRIP, STRIP]}, "requests.1.name", "taken already"),
        ({"requests": [STRIP | {"name": "a\u202eb"}]}, "requests.0.name", "can't be seen"),
        ({"requests": [STRIP | {"name": str(n)} for n in range(1001)]}, "requests", "1000"),
        ({"requests": [STRIP | {"name": str(n)} for n in range(999)],
          "stop": "2024-06-09T10:00:00Z"},
         "requests", "ask for fewer"),
        ({"spacecraft": "hubble"}, "spacecraft", "agile-cmg"),
        ({"stop": "2024-07-03T10:00:00Z"}, "stop", "31 days"),
        ({"stop": "2024-06-01T09:00:00Z"}, "stop", "after start"),
        ({"samples": 1}, "samples", "2..1000"),
        ({"platform": "iss-hrc"}, "platform", "remove it"),
        ({"settings": {"along_max_deg": 90.0}}, "settings.along_max_deg", "0.1..60"),
        ({"requests": {"type": "FeatureCollection", "features": [{}]}}, "features.0", "geometry"),
        (
            {"orbit": ASKED["orbit"] | {"position_km": [42164.0, 0.0, 0.0],
                                        "velocity_km_s": [0.0, 3.0746, 0.0]}},
            "orbit",
            "low orbits",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_refusals_name_the_field(client, members, field, says):
    answer = client.post(PATH, json=changed(**members))
    assert answer.status_code == 422, answer.text[:300]
    problem = answer.json()
    assert problem["field"] == field, problem
    assert says in problem["detail"], problem
    assert "\n" not in problem["detail"]


def test_the_most_that_may_be_asked_takes_bounded_work(client):
    """Refused or answered within the bound, never a 500."""
    many = [STRIP | {"name": str(n)} for n in range(1000)]
    answer = client.post(PATH, json=changed(requests=many, stop="2024-06-03T10:00:00Z", samples=35))
    assert answer.status_code in (200, 422), answer.text[:300]
    assert answer.status_code == 200 or "search-ended" in json.loads(answer.text)["type"]
