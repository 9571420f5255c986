"""A campaign of several carriers: chosen together, planned by carrier, told by carrier."""

import csv
import json
import zlib
from pathlib import Path

import pytest
from databases import fresh_database
from job_cases import ended_with, new_job
from typer.testing import CliRunner

from app.cli import main
from app.jobs.kinds import CAMPAIGN
from app.requests.campaign import FLEET_READER, read_campaign_request
from app.requests.plan import read_plan_request
from app.store import jobs, results
from app.work.campaign import campaign_json, choose
from app.work.searches import listing_of_search
from planner.base.errors import InvalidRequest
from planner.planning.campaigns import choose_campaign

EXAMPLE = Path(__file__).parents[2] / "examples" / "campaign_fleet.json"
BODY = EXAMPLE.read_bytes()
ASKED = json.loads(BODY)
CARRIERS = {one["id"]: one for one in ASKED["carriers"]}
TARGETS = {one["id"]: one for one in ASKED["targets"]}


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    """The command's answer, its lines of looks, and the folder of its plans."""
    out = tmp_path_factory.mktemp("fleet")
    files = ("--plans", out, "--csv", out / "looks.csv", "--json", out / "told.json")
    wanted = ("--export", f"geojson={out / 'looks.geojson'}")
    result = CliRunner().invoke(main, ["campaign", str(EXAMPLE), *map(str, (*files, *wanted))])
    assert result.exit_code == 0, result.stderr
    lines = list(csv.DictReader((out / "looks.csv").read_text().splitlines()))
    return result.stdout, json.loads((out / "told.json").read_text()), lines, out


def test_each_look_is_by_a_carrier_that_may_take_it(reported):
    report, told, lines, _ = reported
    assert [one["target"] for one in told["unseen"]] == ["Reykjavik"]
    assert told["unseen"][0]["carrier"] in CARRIERS
    seen = {line["target"]: line for line in lines}
    assert {*seen} | {one["target"] for one in told["left_out"]} | {"Reykjavik"} == {*TARGETS}
    for target, line in seen.items():
        wanted = TARGETS[target]
        assert (
            wanted.get("sensor", CARRIERS[line["carrier"]]["sensor"])
            == (CARRIERS[line["carrier"]]["sensor"])
        )
        assert wanted.get("release", "") <= line["start"]
        assert line["stop"] <= wanted.get("due", "9")
        assert line["carrier"] in report
    by_carrier = {one["id"]: one for one in told["carriers"]}
    assert [*by_carrier] == [*CARRIERS]
    for carrier, one in by_carrier.items():
        own = [float(line["value"]) for line in lines if line["carrier"] == carrier]
        assert (one["looks"], one["value"]) == (len(own), pytest.approx(sum(own)))
    assert sum(one["value"] for one in told["carriers"]) == pytest.approx(told["value"])
    assert told["greedy_value"] <= told["value"] <= told["bound"]
    assert {one["platform"] for one in CARRIERS.values()} == {"iss-hrc", "smallsat-120kg"}
    assert len({line["carrier"] for line in lines}) == 3


def test_every_pass_is_planned_on_its_carrier_and_verified(reported):
    _, told, lines, out = reported
    assert told["passes"]
    for one in told["passes"]:
        number = one["number"] + 1
        plan = json.loads((out / f"pass-{number}.json").read_text())
        assert plan["verification"]["passed"]
        request = json.loads((out / f"pass-{number}-request.json").read_text())
        carrier = CARRIERS[one["carrier"]]
        assert request["orbit"] == carrier["orbit"]
        assert request["platform"] == carrier["platform"]
        assert request["name"] == f"Three carriers, {one['carrier']}, pass {number}"
        looked_at = [line["target"] for line in lines if int(line["pass"]) == number]
        sessions = read_plan_request((out / f"pass-{number}-request.json").read_bytes()).sessions
        assert [session.id for session in sessions][: len(looked_at)] == looked_at
    features = json.loads((out / "looks.geojson").read_text())["features"]
    assert {one["properties"]["carrier"] for one in features} == {*CARRIERS}


def test_together_they_do_no_worse_than_the_best_of_them_alone(reported):
    _, told, _, _ = reported
    alone = [choose_campaign(one).value for one in FLEET_READER.read(BODY).requests.values()]
    assert told["value"] >= max(alone)
    assert told["bound"] <= sum(alone) + 1.0  # each target once, but for what it costs to move


def test_the_service_tells_carriers_and_without_them_nothing_new(tmp_path):
    request = read_campaign_request(BODY)
    with fresh_database(tmp_path) as database:
        new = new_job("campaign", request=BODY, listing=listing_of_search(request))
        with database.writing() as connection:
            token = jobs.accept(connection, new, 60.0)
        ended_with(database, CAMPAIGN, token, choose(BODY))
        with database.reading() as connection:
            job = jobs.get(connection, new.id)
            document = results.document(connection, new.id)
            answer = json.loads(campaign_json(job, document, jobs.parts_of(connection, new.id)))
    assert answer["platform"] == "iss-hrc, smallsat-120kg"
    assert [one["id"] for one in answer["choice"]["carriers"]] == [*CARRIERS]
    assert {one["carrier"] for one in answer["passes"]} == {*CARRIERS}
    alone = {name: value for name, value in ASKED.items() if name != "carriers"}
    alone |= {name: CARRIERS["station"][name] for name in ("platform", "orbit", "attitude")}
    alone["targets"] = [{k: v for k, v in one.items() if k != "sensor"} for one in ASKED["targets"]]
    one = choose(json.dumps(alone).encode())
    assert all("carrier" not in part.facts for part in one.parts)
    told = json.loads(zlib.decompress(one.document))
    members = {
        "target", "because", "start", "stop", "value", "displaced_by", "displaced_value", "lacks",
    }  # fmt: skip
    assert told["left_out"]
    assert all({*left} == members for left in told["left_out"])
    assert all({*left} == members | {"carrier"} for left in answer["choice"]["left_out"])
    assert "carriers" not in told


@pytest.mark.parametrize(
    ("change", "field", "way_out"),
    [
        ({"carriers": []}, "carriers", "at least one"),
        ({"carriers": [CARRIERS["station"]] * 2}, "carriers.1.id", "taken already"),
        ({"carriers": [CARRIERS["station"] | {"id": ""}]}, "carriers.0.id", "must not be empty"),
        ({"carriers": "all"}, "carriers", "must be a list"),
        ({"platform": "iss-hrc"}, "platform", "remove it"),
        (
            {
                "carriers": [
                    *ASKED["carriers"],
                    CARRIERS["smallsat"] | {"id": "4", "attitude": {"law": "lvlh"}},
                ]
            },
            "carriers.3.attitude",
            "must be left out",
        ),
        (
            {
                "carriers": [
                    CARRIERS["station"] | {"sensor": "infrared", "rest_angles_deg": {"alpha": 0.0}}
                ]
            },
            "targets.3.sensor",
            "carriers have infrared",
        ),
        (
            {
                "carriers": [
                    *ASKED["carriers"][:2],
                    CARRIERS["station"] | {"id": "4", "rest_angles_deg": {"alpha": 0.0}},
                ]
            },
            "carriers.2.rest_angles_deg",
            "alpha, beta",
        ),
        ({"targets": [ASKED["targets"][0]] * 2}, "targets.1.id", "taken already"),
        ({"targets": [ASKED["targets"][0] | {"sensor": "radar"}]}, "targets.0.sensor",
         "colour, infrared"),
        ({"stop": "2015-04-30T00:00:00Z"}, "stop", "31 days"),
        ({"carriers": [CARRIERS["station"] | {"resource": {}}]}, "carriers.0.resource",
         "remove it"),
    ],
)  # fmt: skip
def test_a_refusal_names_the_field_of_the_request_of_all(change, field, way_out):
    with pytest.raises(InvalidRequest) as refused:
        read_campaign_request(json.dumps(ASKED | change).encode())
    told = [f"{one.field}: {one.detail}" for one in refused.value.errors]
    assert any(one.startswith(f"{field}: ") and way_out in one for one in told), told


def test_one_of_several_carriers_is_told_where_targets_are_for_it_alone():
    targets = [one | {"sensor": "infrared"} for one in ASKED["targets"]]
    told = json.loads(
        zlib.decompress(choose(json.dumps(ASKED | {"targets": targets}).encode()).document)
    )
    assert {one["carrier"] for one in (*told["unseen"], *told["left_out"])} == {"follower"}
    assert all(one.startswith("follower: ") for one in told["warnings"])


def test_a_sensor_without_carriers_is_refused():
    alone = {name: value for name, value in ASKED.items() if name != "carriers"}
    alone |= {name: CARRIERS["station"][name] for name in ("platform", "orbit", "attitude")}
    with pytest.raises(InvalidRequest, match=r"targets.2.sensor.*must be left out"):
        read_campaign_request(json.dumps(alone).encode())
