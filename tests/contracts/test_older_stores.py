"""Is what an older version stored still read, listed and exported, as the schema says?"""

import gzip
import json
import sqlite3
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from waiting import PatientClient

from app.http.app import create_app
from app.settings import Settings
from planner.export import EXPORTERS
from planner.spacecraft.export import IMAGING_EXPORTERS

STORED = Path(__file__).parents[1] / "data" / "store" / "written_by_4cb22da.sqlite3.gz"
LONG_NAME = "\u202eLas\x07 " + "Vegas " * 1_000_000
FORMATS = {"plans": EXPORTERS, "spacecraft/plans": IMAGING_EXPORTERS}
VIEWS = {"plans": "PlanViewResponse", "spacecraft/plans": "SpacecraftViewResponse"}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("older")
    stored = folder / "slewtrack.sqlite3"
    stored.write_bytes(gzip.decompress(STORED.read_bytes()))
    with sqlite3.connect(stored) as connection:  # what versions before that one let in
        connection.execute("UPDATE jobs SET name = ? WHERE state = 'refused'", (LONG_NAME,))
    connection.close()
    with PatientClient(create_app(Settings(data_dir=folder, database_url=""))) as client:
        yield client


def got(client, path):
    answer = client.get(f"/v1/{path}")
    assert answer.status_code == 200, answer.text
    return answer.json()


def wrong(client, schema, document):
    components = client.app.openapi()["components"]
    check = Draft202012Validator(
        {"$ref": f"#/components/schemas/{schema}", "components": components}
    )
    return [error.message for error in check.iter_errors(document)]


def test_campaign_whose_targets_without_a_look_were_ids(client):
    [listed] = got(client, "campaigns")["campaigns"]
    campaign = got(client, f"campaigns/{listed['id']}")
    assert wrong(client, "CampaignResponse", campaign) == []
    choice = campaign["choice"]
    for name, target in (("unseen", "Reykjavik"), ("left_out", "San Francisco")):
        [one] = choice[name]
        assert one.pop("target") == target
        assert set(one.values()) == {None}
    [flight] = campaign["passes"]
    assert [look["value"] for look in flight["looks"]] == [2.0, 0.5, 3.0]
    assert campaign["planned"]["value"] == choice["value"] == 5.5


@pytest.mark.parametrize(
    ("resource", "schema", "made"),
    [("plans", "PlanResponse", 2), ("spacecraft/plans", "SpacecraftPlanResponse", 1)],
)
def test_plans_are_read_and_exported(client, resource, schema, made):
    [campaign] = got(client, "campaigns")["campaigns"]
    listed = got(client, resource)["plans"]
    if resource == "plans":
        listed += got(client, f"plans?campaign={campaign['id']}")["plans"]
    done = [one["id"] for one in listed if one["state"] == "done"]
    assert len(done) == made
    for plan_id in done:
        plan = got(client, f"{resource}/{plan_id}")
        assert wrong(client, schema, plan) == []
        assert got(client, f"{resource}/{plan_id}/table") == plan["table"]
        for name in FORMATS[resource]:
            file = client.get(f"/v1/{resource}/{plan_id}/table?format={name}")
            assert file.status_code == 200, file.text
            assert file.content
        view = got(client, f"{resource}/{plan_id}/view")
        assert wrong(client, VIEWS[resource], view) == []


def test_lists_tell_of_what_was_stored(client):
    [session] = got(client, "spacecraft/plans")["plans"]
    assert (session["platform"], session["targets"]) == ("agile-cmg", ["strip"])
    assert session["start"] == "2024-06-01T10:01:00.000Z"
    [campaign] = got(client, "campaigns")["campaigns"]
    assert campaign["targets"][:2] == ["Las Vegas", "Los Angeles"]
    assert (campaign["target_count"], campaign["stop"]) == (5, "2015-02-27T17:50:00.000Z")
    [flight] = got(client, f"plans?campaign={campaign['id']}&target=LOS ANG")["plans"]
    assert flight["targets"] == ["Los Angeles", "double of the first", "Las Vegas"]
    assert 0.0 < flight["probability_in_frame"] <= 1.0
    assert flight["revision"] == 1
    assert got(client, "plans?after=2015-02-27T17:36:29.9Z&before=2015-02-27T18:00:00Z")["plans"]
    assert got(client, "plans?after=2015-02-27T17:36:31Z")["plans"] == []


def test_plans_say_what_they_are(client):
    [listed] = got(client, "plans?text=carried")["plans"]
    plan = got(client, f"plans/{listed['id']}")
    [session] = plan["summary"]["sessions"]
    assert session["target"] == "36.1147, -115.1728"
    assert session["start"] == plan["pointing"][0]["start"]
    assert session["probability_in_frame"] == plan["uncertainty"][0]["probability_in_frame"]
    assert plan["summary"]["platform"] == "iss-hrc"
    [imaging] = got(client, "spacecraft/plans")["plans"]
    session = got(client, f"spacecraft/plans/{imaging['id']}")
    [strip], [window] = session["summary"]["requests"], session["windows"]
    assert strip == {
        "request": "strip",
        "mode": "strip",
        "looks": 1,
        "start": window["start"],
        "stop": window["stop"],
    }


@pytest.mark.parametrize("resource", ["plans", "spacecraft/plans", "campaigns"])
def test_requests_are_given_back_and_taken_again(client, resource):
    [listed, *_] = got(client, resource)[resource.rsplit("/")[-1]]
    asked = client.get(f"/v1/{resource}/{listed['id']}/request")
    again = client.post(f"/v1/{resource}?dry_run=true", json=json.loads(asked.content))
    assert again.status_code == 200, again.text


def test_refusal_is_read(client):
    [refused] = got(client, "plans?state=refused")["plans"]
    assert refused["name"] == ("Las " + "Vegas " * 50)[:200]
    told = got(client, f"plans/{refused['id']}")
    assert wrong(client, "JobResponse", told) == []
    assert told["problem"]["earliest_feasible_start"] == "2015-02-27T17:36:38.400Z"
