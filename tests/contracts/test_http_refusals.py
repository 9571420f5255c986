"""Every bad request is refused alike by the service and the command, at the field at fault."""

import json
from datetime import datetime

import pytest
from refusal_cases import CASES, Refused, request
from refusal_kinds import refusal_kinds
from typer.testing import CliRunner

from app.cli import main


def post(client, body):
    return client.post("/v1/plans", content=body, headers={"Content-Type": "application/json"})


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_service_refuses(client, case: Refused):
    answer = post(client, case.body)
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["type"] == f"urn:slewtrack:problem:{case.slug}", problem
    assert problem["status"] == 422
    assert problem["title"]
    assert problem.get("field") == case.field, problem
    assert case.says in json.dumps(problem, ensure_ascii=False), problem
    assert "Traceback" not in answer.text
    assert "NaN" not in answer.text  # no JSON: a strict client could not read the refusal


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_command_refuses(case: Refused):
    result = CliRunner().invoke(main, ["plan", "-"], input=case.body)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    line, *ways_out = result.stderr.splitlines()
    assert all(way.startswith("  ") for way in ways_out)
    assert line.startswith(f"slewtrack: {case.field}:" if case.field else "slewtrack: "), line
    assert case.says in line or case.name == "no kind", line


def test_every_field_at_fault_is_listed(client):
    document = request(("platform", "hubble"), ("sessions.0.target.latitude_deg", "north"))
    document["orbit"] = {"source": "tle", "line1": 4, "line2": 5, "line3": ""}
    problem = post(client, json.dumps(document)).json()
    assert {error["field"] for error in problem["errors"]} == {
        "orbit.line1",
        "orbit.line2",
        "orbit.line3",
        "platform",
        "sessions.0.target.latitude_deg",
    }
    values = {error["field"]: error["value"] for error in problem["errors"]}
    assert values["sessions.0.target.latitude_deg"] == "north"


def test_long_values_are_not_repeated(client):
    problem = post(client, json.dumps(request(("platform", "x" * 10_000)))).text
    assert len(problem) < 1000


def test_a_slew_refused_for_time_fits_at_the_start_it_names(client):
    document = request(("initial_state.epoch", "2015-02-27T17:36:19.4Z"))
    problem = post(client, json.dumps(document)).json()
    assert problem["axis"] in ("alpha", "beta")
    document["sessions"][0]["start"] = problem["earliest_feasible_start"]
    document["sessions"][0]["stop"] = problem["feasible_stop"]
    assert post(client, json.dumps(document)).status_code == 201


def test_a_refused_sequence_says_what_each_session_would_give_up(client):
    document = request(("on_conflict", "refuse"), example="sequence")
    problem = post(client, json.dumps(document)).json()
    assert problem["type"] == "urn:slewtrack:problem:infeasible-slew"
    assert problem["field"] == "sessions.1.start"
    modes = {offer["on_conflict"] for offer in problem["relaxations"]}
    assert modes == {"shorten_later", "shorten_earlier", "least_loss"}
    for offer in problem["relaxations"]:
        document["on_conflict"] = offer["on_conflict"]
        flown = post(client, json.dumps(document)).json()["pointing"][offer["session"]]
        asked = document["sessions"][offer["session"]]
        assert _apart_s(asked["start"], flown["start"]) == pytest.approx(offer["start_later_s"])
        assert _apart_s(flown["stop"], asked["stop"]) == pytest.approx(offer["stop_earlier_s"])


def _apart_s(earlier: str, later: str) -> float:
    return (datetime.fromisoformat(later) - datetime.fromisoformat(earlier)).total_seconds()


def test_every_refusal_has_a_name_of_its_own():
    slugs = [kind.slug for kind in refusal_kinds()]
    assert len(set(slugs)) == len(slugs)
