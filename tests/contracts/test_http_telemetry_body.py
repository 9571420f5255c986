"""Telemetry of a body over HTTP and by the command: told as that of axes, refused by field."""

import json

import other_body
import pytest
from other_body import Flown, written
from test_http_telemetry import COMPARISONS, upload
from typer.testing import CliRunner

from app.cli.command import main

REQUEST = other_body.body_request(sessions=1)


@pytest.fixture(scope="module")
def plan(client):
    return client.made("/v1/plans", json=REQUEST)


@pytest.fixture(scope="module")
def content(client, plan):
    columns = client.get(f"/v1/plans/{plan['id']}/table?format=json").json()
    return written(columns, Flown(wander_arcsec=20.0, half_life_s=2.0), 1, "wxyz of body_from_eci")


@pytest.fixture(scope="module")
def told(client, plan, content):
    answer = upload(client, plan, content)
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_a_bodys_telemetry_is_told_by_its_axes(told):
    assert [*told["axes"]] == ["x", "y", "z"]
    common = told["common_offset_s"]
    assert abs(common["value"] - 0.37) < 4.0 * common["sigma"]
    assert "friction" not in json.dumps([common, told["time_offset_s"]])
    for axis in told["axes"].values():
        assert axis["gain"] is None
        assert axis["bias_unit"] == "arcsec"
        assert axis["rate_gain"]["value"] == pytest.approx(1.0, abs=0.01)
        assert axis["noise_arcsec"]["value"] == pytest.approx(5.0, rel=0.2)
    read_as = {column["name"]: column["axis"] for column in told["samples"]["columns"]}
    assert read_as["q_1"] == "q_body_from_eci_w"
    assert read_as["omega_body_deg_s_z"] == "z"


def test_json_tells_the_same_as_csv(client, plan, content, told):
    names, *rows = [line.split(",") for line in content.decode().splitlines()]
    columns = zip(*(map(float, row) for row in rows), strict=True)
    samples = dict(zip(names, map(list, columns), strict=True))
    answer = client.post(COMPARISONS, json={"plan": plan["id"], "samples": samples})
    assert answer.status_code == 200, answer.text
    assert answer.json()["axes"] == told["axes"]


def test_the_platform_found_is_pasted_into_the_next_request(client, told):
    found = {one["name"]: one for one in told["parameters"]}
    control = found["knowledge.control_sigma_arcsec"]
    assert abs(control["found"] - 20.0) < 4.0 * control["sigma"]
    assert told["platform"]["knowledge"]["control_sigma_arcsec"] == control["found"]
    again = client.post("/v1/plans", json=REQUEST | {"platform": told["platform"]})
    assert again.status_code == 201, again.text
    [budget] = again.json()["uncertainty"]
    causes = {one["cause"]: one["sigma_arcsec"] for one in budget["contributions"]}
    assert causes["attitude control"] == pytest.approx(control["found"], rel=1e-3)


def test_plan_and_flight_are_a_table_and_a_picture(client, plan, content):
    table = upload(client, plan, content, "?format=csv").text
    axes = {line.split(",")[0] for line in table.splitlines() if not line.startswith("#")}
    assert axes == {"axis", "x", "y", "z"}
    assert upload(client, plan, content, "?format=png").content.startswith(b"\x89PNG")


def test_the_command_tells_the_same(plan, content, tmp_path):
    answered, request = tmp_path / "answer.json", tmp_path / "request.json"
    answered.write_text(json.dumps(plan))
    request.write_text(json.dumps(REQUEST))
    telemetry = tmp_path / "telemetry.csv"
    telemetry.write_bytes(content.replace(b"q_1,q_2,q_3,q_4", b"QW,QX,QY,QZ", 1))
    words = ["compare", str(answered), str(telemetry), "--request", str(request)]
    parts = [f"--column=q_{n}={own}" for n, own in enumerate(("QW", "QX", "QY", "QZ"), start=1)]
    result = CliRunner().invoke(main, [*words, *parts])
    assert result.exit_code == 0, result.output
    assert "x wanders by" in result.output
    assert "x rates: bias" in result.output
    assert "knowledge.correlation_s" in result.output


CORRECTION = {
    "epoch": "2015-05-10T10:36:00Z",
    "turn_body_deg": [0.1, 0.0, 0.0],
    "covariance_deg2": [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]],
}
OFFSET = {"epoch": "2015-05-10T10:36:00Z", "offset_deg": [0.1, 0.0]}


@pytest.mark.parametrize(
    ("names", "head", "field", "words"),
    [
        ("t_s,q_1,q_2,q_3,other", {}, "samples", "q_4 hold nothing"),
        ("t_s,alpha_deg,beta_deg,q_9,other", {}, "samples", "four parts of the attitude"),
        (None, {"corrections": [CORRECTION]}, "corrections", "steers itself"),
        (None, {"image_offsets": [OFFSET]}, "image_offsets", "steers itself"),
        (None, {"identify": ["x.coulomb_deg_s2"]}, "identify", "has none"),
        (None, {"columns": {"q_5": "q_1"}}, "columns.q_5", "no column that is read"),
    ],
)
def test_what_a_body_has_not_is_refused_by_field(client, plan, content, names, head, field, words):
    if names is not None:
        old, rows = content.decode().split("\n", 1)
        content = "\n".join([names + ",a" * (old.count(",") - names.count(",")), rows]).encode()
    answer = upload(client, plan, content, **head)
    assert answer.status_code == 422, answer.text
    assert answer.json()["field"] == field
    assert words in answer.json()["detail"]


def test_telemetry_of_another_flight_is_refused(client, plan, content):
    """Its attitude stands still while the plan slews."""
    lines = content.decode().splitlines()
    still = [",".join([line.split(",")[0], "0", "0", "0", "1"]) for line in lines[1:]]
    answer = upload(client, plan, "\n".join(["t_s,q_1,q_2,q_3,q_4", *still]).encode())
    assert answer.status_code == 422
    assert "hold nothing of the plan's motion" in answer.json()["detail"]
