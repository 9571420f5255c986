"""`slewtrack campaign` chooses, plans, reports, writes files, and refuses in one line."""

import json
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli import main
from app.requests.examples import CAMPAIGN_EXAMPLES
from app.requests.plan import read_plan_request

EXAMPLE = Path(__file__).parents[2] / "examples" / "campaign_cities.json"
CITIES = CAMPAIGN_EXAMPLES["cities"][1]


def campaign(request, *words):
    return CliRunner().invoke(main, ["campaign", "-", *map(str, words)], input=json.dumps(request))


def test_report_and_files(tmp_path):
    asked = json.loads(EXAMPLE.read_text())
    assert asked == CITIES  # the example of the pages is the one in the folder
    plans, csv, told = tmp_path / "plans", tmp_path / "looks.csv", tmp_path / "told.json"
    files = {name: tmp_path / f"looks.{name}" for name in ("csv", "geojson", "kml", "zip")}
    wanted = [word for name, path in files.items() for word in ("--export", f"{name}={path}")]
    result = campaign(asked, "--plans", plans, "--csv", csv, "--json", told, *wanted)
    assert result.exit_code == 0, result.stderr
    assert "4 looks in 2 passes" in result.stdout
    rows = [line.split(",") for line in csv.read_text().splitlines()[1:]]
    choice = json.loads(told.read_text())
    [lost] = choice["left_out"]
    assert f"left out for others: {lost['target']}" in " ".join(result.stdout.split())
    assert {row[1] for row in rows} == {wanted["id"] for wanted in asked["targets"]} - {
        lost["target"]
    }
    assert set(lost["displaced_by"]) <= {row[1] for row in rows}
    assert sum(float(row[6]) for row in rows) == pytest.approx(choice["value"])
    assert choice["greedy_value"] <= choice["value"] <= choice["bound"]
    assert files["csv"].read_bytes() == csv.read_bytes()
    features = json.loads(files["geojson"].read_text())["features"]
    assert {one["properties"]["name"] for one in features} == {row[1] for row in rows}
    assert files["kml"].read_bytes().startswith(b"<?xml")
    with zipfile.ZipFile(files["zip"]) as archive:
        assert archive.read("looks.csv") == csv.read_bytes()
        assert archive.read("pass-1-request.json") == (plans / "pass-1-request.json").read_bytes()
        assert archive.read("pass-2.csv").startswith(b"#")
    for number in (1, 2):
        plan = json.loads((plans / f"pass-{number}.json").read_text())
        assert plan["verification"]["passed"]
        resting = [plan["table"][f"{axis}_deg"] for axis in ("alpha", "beta")]
        assert all(abs(angles[row]) < 1e-9 for angles in resting for row in (0, -1))
        scenario = read_plan_request((plans / f"pass-{number}-request.json").read_bytes())
        looks = [row for row in rows if int(row[0]) == number]
        assert len(scenario.sessions) == len(looks) + 1


@pytest.mark.parametrize(
    ("change", "field", "way_out"),
    [
        ({"step_s": 0.5}, "step_s", "0.2"),
        ({"rest_angles_deg": {"alpha": 0.0}}, "rest_angles_deg", "alpha, beta"),
        ({"rest_angles_deg": {"alpha": 200.0, "beta": 0.0}}, "rest_angles_deg", "-175..175"),
        ({"slew": {"method": "spline"}}, "slew.method", "must be ocp"),
        ({"stop": "2015-04-30T00:00:00Z"}, "stop", "31 days"),
        ({"targets": []}, "targets", "at least one"),
        (
            {
                "targets": [
                    CITIES["targets"][0]
                    | {"release": "2015-02-28T00:00:00Z", "due": "2015-02-27T18:00:00Z"}
                ]
            },
            "targets.0.due",
            "after release",
        ),
        ({"targets": CITIES["targets"] * 2}, "targets", "taken already"),
    ],
)
def test_refusals_are_one_line(change, field, way_out):
    result = campaign(CITIES | change)
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert field in line
    assert way_out in line


def test_least_length_over_the_wanted_one_is_refused():
    target = CITIES["targets"][0] | {"min_session_s": 50.0}
    result = campaign(CITIES | {"targets": [target]})
    assert result.exit_code == 2
    assert "min_session_s: must lie in 1..40" in result.stderr


def test_nothing_in_sight_is_no_error():
    pole = {"mode": "ground", "latitude_deg": -89.0, "longitude_deg": 0.0}
    result = campaign(CITIES | {"targets": [{"id": "Pole", "target": pole, "session_s": 10.0}]})
    assert result.exit_code == 0, result.stderr
    told = " ".join(result.stdout.split())
    assert "can't be seen: Pole, the carrier stays below 30 deg in its sky (at most -" in told
