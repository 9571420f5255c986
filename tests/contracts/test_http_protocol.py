"""The service keeps to HTTP and RFC 9457 whatever a client sends."""

import json
import uuid

import pytest
from fastapi.testclient import TestClient
from waiting import PatientClient, eventually

from app.http.app import create_app
from app.http.routes import plan_routes
from app.requests.examples import LAS_VEGAS
from app.settings import Settings

JSON = {"Content-Type": "application/json"}
BODY = json.dumps(LAS_VEGAS)


@pytest.fixture(scope="module")
def client():
    with PatientClient(create_app(), raise_server_exceptions=False) as client:
        yield client


def assert_problem(answer, status: int) -> dict:
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert list(problem)[:5] == ["type", "title", "status", "detail", "instance"]  # RFC 9457, 3.1
    assert problem["status"] == status
    uuid.UUID(problem["instance"].removeprefix("urn:uuid:"))
    return problem


@pytest.mark.parametrize(
    ("asked", "meant"),
    [
        ("/v1/plan", "did you mean /v1/plans? "),
        ("/v1/plans/01a203fd-cbae-73f8-8276-319f76b8842c/comparisons", "/v1/telemetry/comparisons"),
        ("/v1/plans/01a203fd-cbae-73f8-8276-319f76b8842c/tables", "mean /v1/plans/{id}/table? "),
        ("/qqqq", "; /docs"),
    ],
)
def test_unknown_address(client, asked, meant):
    detail = assert_problem(client.get(asked), 404)["detail"]
    assert meant in detail
    assert detail.endswith("/docs lists what there is")


def test_unknown_method(client):
    answer = client.put("/v1/plans")
    assert_problem(answer, 405)
    assert answer.headers["allow"] == "GET, HEAD, POST"


@pytest.mark.parametrize("accept", ["text/csv", "application/json;q=0", "text/*, image/png"])
def test_answers_only_json(client, accept):
    assert_problem(client.get("/v1/platforms", headers={"Accept": accept}), 406)


@pytest.mark.parametrize("accept", ["text/html", "image/*", "application/json;q=0", "", "*/*"])
@pytest.mark.parametrize("path", ["/healthz", "/readyz", "/metrics"])
def test_probes_and_metrics_answer_whatever_is_accepted(client, accept, path):
    """As monitors and load balancers ask, which look at the status only."""
    plain = eventually(lambda: (told := client.get(path)).status_code == 200 and told)
    answer = client.get(path, headers={"Accept": accept})
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == plain.headers["content-type"]


@pytest.mark.parametrize(
    "accept", ["*/*", "application/*;q=0.1", "text/html, Application/JSON ; q=0.5"]
)
def test_admits_what_rfc_9110_lets_a_client_say(client, accept):
    assert client.get("/v1/platforms", headers={"Accept": accept}).status_code == 200


@pytest.mark.parametrize("media_type", ["", "text/plain", "application/x-www-form-urlencoded"])
def test_reads_only_json(client, media_type):
    answer = client.post("/v1/plans", content=BODY, headers={"Content-Type": media_type})
    assert "Content-Type: application/json" in assert_problem(answer, 415)["detail"]


def test_a_charset_is_no_obstacle(client):
    headers = {"Content-Type": "application/json; charset=utf-8"}
    assert client.post("/v1/plans?dry_run=true", content=BODY, headers=headers).status_code == 200


def chunks():
    for _ in range(20):
        yield b" " * 100


@pytest.mark.parametrize("content", [b" " * 1001, chunks()], ids=["length declared", "chunked"])
def test_too_long_a_body(content):
    with TestClient(create_app(Settings(max_body_bytes=1000))) as client:
        problem = assert_problem(client.post("/v1/plans", content=content, headers=JSON), 413)
    assert "1000 bytes" in problem["detail"]


def test_the_whole_oem_of_nasa_passes_the_default_limit(client):
    # 1.2 MB, the size of NASA's 15-day OEM of the ISS in XML; what is in it is not the question.
    body = json.dumps({"orbit": {"source": "oem", "content": "<ndm>" * 250_000}})
    assert_problem(client.post("/v1/plans", content=body, headers=JSON), 422)


def test_a_bug_says_nothing_of_itself(client, monkeypatch, caplog):
    def broken(*_):
        raise RuntimeError("secret /etc/passwd")

    monkeypatch.setattr(plan_routes, "whole_answer", broken)
    answer = client.post("/v1/plans", content=BODY, headers=JSON)
    problem = assert_problem(answer, 500)
    assert problem["title"] == "Internal Server Error"
    assert "secret" not in answer.text
    assert "Runtime" not in answer.text
    [record] = [record for record in caplog.records if record.levelname == "ERROR"]
    assert uuid.UUID(record.request_id).urn == problem["instance"]  # the log has the rest
    assert "secret" in caplog.text
