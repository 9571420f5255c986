"""A plan's table is handed out by itself in every registered format, and as RFC 9110 asks."""

import pytest
from refusal_cases import request

from app.requests.examples import LAS_VEGAS
from planner.output.export import EXPORTERS

# The first ten seconds of the session, to keep every format quick.
SHORT = request(
    ("initial_state.epoch", "2015-02-27T17:35:00Z"), ("sessions.0.stop", "2015-02-27T17:36:30Z")
)


def post(client, accept="*/*", query="", document=SHORT):
    return client.post(f"/v1/plans{query}", json=document, headers={"Accept": accept})


def assert_is(answer, name):
    assert answer.status_code == 201, answer.text
    assert answer.headers["content-type"].split(";")[0] == EXPORTERS[name].media_type
    suffix = EXPORTERS[name].suffix
    assert answer.headers["content-disposition"] == f'attachment; filename="Las-Vegas{suffix}"'
    assert "accept" in answer.headers["vary"].lower()


@pytest.mark.parametrize("name", EXPORTERS)
def test_every_format(client, name):
    """By its media type, but for JSON's, which is the whole answer's."""
    asked = {"query": "?format=json"} if name == "json" else {"accept": EXPORTERS[name].media_type}
    assert_is(post(client, **asked), name)


@pytest.mark.parametrize(
    ("accept", "name"),
    [
        ("*/*", None),
        ("application/json", None),
        ("application/*", None),
        ("text/csv;q=0.9, application/json;q=0.1", "csv"),
        ("text/csv;q=0.2, application/json;q=0.3", None),
        ("application/json;q=0, */*", "csv"),
        ("text/*", "csv"),
        ("application/*;q=0.1, application/x-netcdf;q=0.2", "netcdf"),
    ],
)
def test_the_weights_of_accept_decide(client, accept, name):
    answer = post(client, accept)
    if name is None:
        assert answer.headers["content-type"] == "application/json"
        assert answer.json()["state"] == "done"
    else:
        assert_is(answer, name)


@pytest.mark.parametrize("accept", ["image/gif", "application/json;q=0", "*/*;q=0"])
def test_nothing_else_is_admitted(client, accept):
    answer = post(client, accept)
    assert answer.status_code == 406
    assert "text/csv" in answer.json()["detail"]


def test_an_unknown_format_names_those_there_are(client):
    problem = post(client, query="?format=xlsx").json()
    assert problem["status"] == 422
    assert problem["field"] == "query.format"
    assert "netcdf" in problem["detail"]


def test_a_dry_run_answers_json_whatever_the_format(client):
    answer = post(client, query="?dry_run=true&format=csv")
    assert answer.status_code == 200
    assert answer.json()["valid"] is True


def test_a_table_that_failed_its_verification_is_not_handed_out(client):
    document = {**LAS_VEGAS, "slew": {"method": "spline"}}
    problem = post(client, query="?format=csv", document=document).json()
    assert problem["type"] == "urn:slewtrack:problem:unverified"
    assert problem["status"] == 422
    assert problem["limit"] == "pointing"
    whole = post(client, document=document).json()
    assert whole["state"] == "failed"
    assert whole["verification"]["passed"] is False


@pytest.mark.parametrize("name", ['a"; filename="b', "", "Ω$", "x" * 200])
def test_a_plans_name_can_not_break_the_header(client, name):
    answer = post(client, query="?format=csv", document={**SHORT, "name": name})
    assert answer.status_code == 201
    assert "set-cookie" not in answer.headers
    assert len(answer.headers["content-disposition"]) < 120
