"""Kept records say what they are, are found by that, and give their requests back."""

import copy
import csv
import io
import json
import zipfile
from xml.etree import ElementTree

import pytest
from waiting import eventually

from app.requests.examples import CAMPAIGN_EXAMPLES, LAS_VEGAS, SPACECRAFT_EXAMPLES

CITIES = CAMPAIGN_EXAMPLES["cities"][1]
STRIP = SPACECRAFT_EXAMPLES["geojson"][1] | {"simulation_runs": 0}
TWO = copy.deepcopy(LAS_VEGAS) | {"name": "Ås and Vegas"}
TWO["sessions"] = [
    {**LAS_VEGAS["sessions"][0], "id": "LV-7", "name": "Las Vegas, ÖST"},
    {
        "target": {"mode": "star", "hip": 91262},
        "start": "2015-02-27T17:39:00Z",
        "stop": "2015-02-27T17:39:10Z",
    },
]


@pytest.fixture(scope="module")
def two(client):
    return client.made("/v1/plans", json=TWO)


def listed(client, query, path="/v1/plans"):
    answer = client.get(path + query)
    assert answer.status_code == 200, answer.text
    return next(members for members in answer.json().values() if isinstance(members, list))


def test_a_plan_says_what_it_is(client, two):
    summary = client.get(f"/v1/plans/{two['id']}").json()["summary"]
    assert summary == two["summary"]
    vegas, star = summary["sessions"]
    assert (summary["name"], summary["platform"]) == ("Ås and Vegas", "iss-hrc")
    assert summary["targets"] == ["Las Vegas, ÖST", "HIP 91262"]
    assert (vegas["id"], vegas["name"], vegas["mode"]) == ("LV-7", "Las Vegas, ÖST", "ground")
    assert vegas["target"] == "near Las Vegas (36.1147, -115.1728)"
    assert (star["id"], star["name"], star["best_elevation_deg"]) == (None, None, None)
    assert [vegas["start"], star["stop"]] == [summary["start"], summary["stop"]]
    budget = {one["session"]: one["probability_in_frame"] for one in two["uncertainty"]}
    assert [s["probability_in_frame"] for s in (vegas, star)] == [budget[0], budget[1]]
    assert summary["probability_in_frame"] == min(budget.values())


def test_the_best_elevation_is_that_of_the_opportunity(client, two):
    """The session holds the culmination; opportunities find that without the judge."""
    asked = {name: LAS_VEGAS[name] for name in ("platform", "orbit", "attitude")}
    asked["targets"] = [{"id": "LV", "target": LAS_VEGAS["sessions"][0]["target"]}]
    times = {"start": "2015-02-27T17:30:00Z", "stop": "2015-02-27T17:45:00Z"}
    [window] = client.post("/v1/opportunities?include=view", json=asked | times).json()["windows"]
    vegas = two["summary"]["sessions"][0]
    # The judge looks every 0.05 s: at 1 deg/s past the zenith that is 0.001 deg of the parabola.
    assert vegas["best_elevation_deg"] == pytest.approx(window["highest_deg"], abs=1e-3)
    assert vegas["best_at"][:19] == window["highest_at"][:19]
    # 1 m of a range of 401 km between the nearest and the highest instant.
    sample_m = window["closest"]["ground_sample_along_m"]
    assert vegas["ground_sample_m"] == pytest.approx(sample_m, rel=1e-5)
    assert two["summary"]["sessions"][1]["ground_sample_m"] is None


def test_lists_tell_of_it(client, two):
    [row] = listed(client, "?text=ås and")
    summary = two["summary"]
    told = ("name", "platform", "targets", "start", "stop", "probability_in_frame")
    assert {name: row[name] for name in told} == {name: summary[name] for name in told}
    assert (row["revision"], row["target_count"], row["state"]) == (1, 2, "done")
    answer = client.post(f"/v1/plans?revises={two['id']}", json=TWO)
    [second, first] = listed(client, "?text=ÅS AND")
    assert (second["revision"], second["revises"]) == (2, two["id"])
    assert (first["revision"], first["id"]) == (1, two["id"])
    client.delete(answer.headers["Location"])


def test_an_imaging_session_says_what_it_is(client):
    made_id = client.made("/v1/spacecraft/plans", json=STRIP)["id"]
    session = client.get(f"/v1/spacecraft/plans/{made_id}").json()
    summary, windows = session["summary"], session["windows"]
    assert summary["targets"] == [f["properties"]["name"] for f in STRIP["requests"]["features"]]
    for one in summary["requests"]:
        looks = [window for window in windows if window["request"] == one["request"]]
        assert one["looks"] == len(looks) > 0
        assert one["start"][:21] == looks[0]["start"][:21]
        assert one["stop"][:21] == looks[-1]["stop"][:21]
    [row] = listed(client, f"?target={summary['targets'][0]}", "/v1/spacecraft/plans")[:1]
    assert (row["platform"], row["targets"]) == ("agile-cmg", summary["targets"])


@pytest.mark.parametrize(
    ("query", "found"),
    [
        ("target=las vegas, öst", True),
        ("target=hip 91262", True),
        ("target=Ås", False),  # the plan's name, no target's
        ("target=5%25", False),
        ("text=ISS-HRC", True),
        ("text=hubble", False),
        ("state=refused", False),
        ("after=2015-02-27T17:39:09.9Z", True),
        ("after=2015-02-27T17:39:10Z", False),
        ("before=2015-02-27T17:36:20.1Z", True),
        ("before=2015-02-27T17:36:20Z", False),
        ("before=2015-02-27T18:36:20.1%2B01:00&after=2015-02-27T17:00:00Z&target=öst", True),
    ],
)
def test_it_is_found(client, two, query, found):
    assert (two["id"] in [row["id"] for row in listed(client, f"?{query}")]) is found


@pytest.mark.parametrize(
    ("query", "says"),
    [
        ("after=2015-02-27T17:39:10", "append Z"),
        ("after=2015-02-27T17:39:10+01:00", "RFC 3339"),
        ("before=yesterday", "RFC 3339"),
        ("before=", "RFC 3339"),
        ("target=", "at least 1 character"),
        ("text=%07", "can't be seen"),
        (f"text={'a' * 201}", "at most 200"),
    ],
)
def test_what_can_t_be_looked_for_is_refused(client, query, says):
    answer = client.get(f"/v1/plans?{query}")
    assert answer.status_code == 422, answer.text
    problem = answer.json()
    assert problem["field"] == "query." + query.split("=")[0]
    assert says in problem["detail"]


@pytest.mark.parametrize(
    ("path", "request_"), [("/v1/plans", TWO), ("/v1/spacecraft/plans", STRIP)], ids=["plan", "sc"]
)
def test_a_request_is_given_back_as_it_was_sent(client, path, request_):
    sent = json.dumps(request_, indent=3, ensure_ascii=False).encode() + b"\n \n"
    headers = {"Content-Type": "application/json"}
    plan = client.post(path, content=sent, headers=headers).json()
    given = client.get(f"{path}/{plan['id']}/request")
    assert given.content == sent
    assert given.headers["content-type"] == "application/json"
    again = client.post(path, content=given.content, headers=headers).json()
    assert again["provenance"]["input_sha256"] == plan["provenance"]["input_sha256"]
    assert again["table"]["t_s"] == plan["table"]["t_s"]
    tag = {"If-None-Match": given.headers["ETag"]}
    assert client.get(f"{path}/{plan['id']}/request", headers=tag).status_code == 304


def test_requests_that_were_refused_are_kept_too(client):
    late = copy.deepcopy(LAS_VEGAS) | {"name": "hurried"}
    late["initial_state"]["epoch"] = "2015-02-27T17:36:19.8Z"
    assert client.post("/v1/plans", json=late).status_code == 422
    [row] = listed(client, "?name=hurried")
    assert (row["state"], row["start"]) == ("refused", "2015-02-27T17:36:20.000Z")
    assert (row["revision"], row["probability_in_frame"]) == (None, None)
    assert client.get(f"/v1/plans/{row['id']}/request").json() == late


def test_a_campaign_and_its_passes_say_what_they_are(client):
    made_id = client.post("/v1/campaigns", json=CITIES).json()["id"]
    eventually(lambda: client.get(f"/v1/campaigns/{made_id}").json()["state"] == "done")
    assert client.get(f"/v1/campaigns/{made_id}/request").json() == CITIES
    [row] = listed(client, "?target=boston", "/v1/campaigns")
    assert row["targets"] == [target["id"] for target in CITIES["targets"]]
    assert (row["start"], row["stop"]) == ("2015-02-27T12:00:00.000Z", "2015-02-28T00:00:00.000Z")
    passes = client.get(f"/v1/campaigns/{made_id}").json()["passes"]
    flight = passes[-1]
    plan = client.get(f"/v1/plans/{flight['plan']}").json()
    ids = [look["target"] for look in flight["looks"]]
    assert [one["id"] for one in plan["summary"]["sessions"]] == [*ids, None]
    assert plan["summary"]["targets"] == ids
    asked = client.get(f"/v1/plans/{flight['plan']}/request")
    assert client.post("/v1/plans?dry_run=true", json=asked.json()).status_code == 200
    found = listed(client, f"?campaign={made_id}&target={ids[0].lower()}")
    assert flight["plan"] in [one["id"] for one in found]


def with_text(request, path, text):
    """The request with a text at a path."""
    changed = copy.deepcopy(request)
    *way, last = [int(part) if part.isdecimal() else part for part in path.split(".")]
    place = changed
    for part in way:
        place = place[part]
    place[last] = text
    return changed


@pytest.mark.parametrize(
    ("changes", "field", "says"),
    [
        ({"sessions.0.id": ""}, "sessions.0.id", "leave it out"),
        ({"sessions.0.name": ""}, "sessions.0.name", "leave it out"),
        ({"sessions.1.id": "LV-7"}, "sessions.1.id", "ids must differ"),
        ({"sessions.1.id": 7}, "sessions.1.id", "string"),
    ],
)
def test_ids_of_sessions_are_refused_by_field(client, changes, field, says):
    request = TWO
    for path, value in changes.items():
        request = with_text(request, path, value)
    problem = client.post("/v1/plans?dry_run=true", json=request).json()
    assert (problem["status"], problem["field"]) == (422, field)
    assert says in problem["detail"]


def test_looks_and_plans_of_a_campaign_are_files(client):
    """Each as a reader by others has it: csv, lxml and zipfile of the standard library."""
    asked = CITIES | {"name": "Cities, as files"}
    path = f"/v1/campaigns/{client.post('/v1/campaigns', json=asked).json()['id']}"
    eventually(lambda: client.get(path).json()["state"] == "done")
    passes = client.get(path).json()["passes"]
    looks = [(one["number"] + 1, look) for one in passes for look in one["looks"]]

    def file(media_type):
        answer = client.get(path, headers={"Accept": media_type})
        assert answer.status_code == 200, answer.text
        assert answer.headers["content-type"].startswith(media_type)
        assert 'filename="Cities-as-files.' in answer.headers["content-disposition"]
        return answer.content

    table = file("text/csv").decode()
    rows = list(csv.DictReader(io.StringIO(table)))
    assert [(int(row["pass"]), row["target"], row["start"]) for row in rows] == [
        (number, look["target"], look["start"]) for number, look in looks
    ]
    features = json.loads(file("application/geo+json"))["features"]
    place_by_id = {one["id"]: one["target"] for one in CITIES["targets"]}
    for feature, (number, look) in zip(features, looks, strict=True):
        place = place_by_id[look["target"]]
        known = [place["longitude_deg"], place["latitude_deg"], place.get("height_m", 0.0)]
        assert feature["geometry"] == {"type": "Point", "coordinates": pytest.approx(known)}
        assert feature["properties"]["name"] == look["target"]
        assert feature["properties"]["plan"] == passes[number - 1]["plan"]
    space = {"kml": "http://www.opengis.net/kml/2.2"}
    drawn = ElementTree.fromstring(file("application/vnd.google-earth.kml+xml"))
    names = [one.text for one in drawn.iterfind(".//kml:Placemark/kml:name", space)]
    assert names == [look["target"] for _, look in looks]
    archive = zipfile.ZipFile(io.BytesIO(file("application/zip")))
    assert archive.testzip() is None
    assert archive.read("looks.csv").decode() == table
    for one in passes:
        stem = f"pass-{one['number'] + 1}"
        plan = f"/v1/plans/{one['plan']}"
        exported = client.get(f"{plan}/table", params={"format": "csv"}).content
        assert archive.read(f"{stem}.csv") == exported
        assert archive.read(f"{stem}-request.json") == client.get(f"{plan}/request").content
    assert client.get(path, headers={"Accept": "image/png"}).status_code == 406


def test_a_campaign_without_plans_has_no_file(client):
    pole = {"mode": "ground", "latitude_deg": 89.0, "longitude_deg": 0.0}
    asked = CITIES | {"targets": [{"id": "pole", "session_s": 20.0, "target": pole}]}
    path = f"/v1/campaigns/{client.post('/v1/campaigns', json=asked).json()['id']}"
    eventually(lambda: client.get(path).json()["state"] == "done")
    refused = client.get(path, headers={"Accept": "text/csv"})
    assert refused.status_code == 409
    assert "0 plans made" in refused.json()["detail"]
