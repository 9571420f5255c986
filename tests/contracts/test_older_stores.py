"""Is what an older version stored still read, listed and exported, as the schema says?"""

import gzip
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from waiting import PatientClient

from app.http.app import create_app
from app.settings import Settings
from planner.export import EXPORTERS
from planner.spacecraft.export import IMAGING_EXPORTERS

STORED = Path(__file__).parents[1] / "data" / "store" / "written_by_4cb22da.sqlite3.gz"
FORMATS = {"plans": EXPORTERS, "spacecraft/plans": IMAGING_EXPORTERS}
VIEWS = {"plans": "PlanViewResponse", "spacecraft/plans": "SpacecraftViewResponse"}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("older")
    (folder / "slewtrack.sqlite3").write_bytes(gzip.decompress(STORED.read_bytes()))
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


def test_refusal_is_read(client):
    [refused] = got(client, "plans?state=refused")["plans"]
    told = got(client, f"plans/{refused['id']}")
    assert wrong(client, "JobResponse", told) == []
    assert told["problem"]["earliest_feasible_start"] == "2015-02-27T17:36:38.400Z"
