"""Ids, logs, metrics and probes show an operator what goes on, and nothing secret."""

import json
import re
import subprocess
import sys
import urllib.error
import urllib.request
import uuid

import pytest
from databases import own_settings
from fastapi.testclient import TestClient
from live_service import ROOT, live_service
from prometheus_client.parser import text_string_to_metric_families
from waiting import eventually

from app.http import readiness
from app.http.app import create_app
from app.http.metrics import Metrics
from app.store.database import open_database
from app.store.keys import KeyStore
from app.store.migrate import upgrade


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    return create_app(own_settings(tmp_path_factory.mktemp("observed")))


@pytest.fixture(scope="module")
def client(app):
    with TestClient(app, raise_server_exceptions=False) as client:
        yield client


@pytest.mark.parametrize("sent", ["a", "4bf92f3577b34da6a3ce929d0e0e4736", "pass-7.retry_2"])
def test_a_sane_id_is_kept(client, sent):
    answer = client.get("/v1/nothing", headers={"X-Request-ID": sent})
    assert answer.headers["x-request-id"] == sent
    assert answer.json()["instance"] in (
        f"urn:slewtrack:request:{sent}",
        f"urn:uuid:{uuid.UUID(sent)}" if len(sent) == 32 else "",
    )


@pytest.mark.parametrize("sent", ["", "a b", "x" * 65, "-a", "a\\nb", "<script>", "ä"])
def test_any_other_is_replaced(client, sent):
    answer = client.get("/healthz", headers={"X-Request-ID": sent.encode("latin-1")})
    uuid.UUID(answer.headers["x-request-id"])


def samples(client) -> dict[tuple[str, tuple[tuple[str, str], ...]], float]:
    """All of /metrics, read by Prometheus's own parser."""
    answer = client.get("/metrics")
    assert answer.headers["content-type"].startswith("text/plain; version=0.0.4")
    return {
        (sample.name, tuple(sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


def counted(found, name: str, **labels: str) -> float:
    return found.get((name, tuple(sorted(labels.items()))), 0.0)


def test_requests_are_counted_by_route_and_refusals_by_type(client):
    before = samples(client)
    client.post("/v1/plans", json={})
    client.get("/v1/nothing/1")
    client.get("/v1/nothing/2")
    client.request("BREW", "/v1/platforms")
    after = samples(client)

    def more(name: str, **labels: str) -> float:
        return counted(after, name, **labels) - counted(before, name, **labels)

    seconds = "slewtrack_http_request_seconds_count"
    assert more(seconds, method="POST", route="/v1/plans", status="422") == 1
    assert more(seconds, method="GET", route="unmatched", status="404") == 2
    assert more(seconds, method="other", route="/v1/platforms", status="405") == 1
    assert more("slewtrack_refusals_total", type="invalid-request") == 1
    assert more("slewtrack_refusals_total", type="http-404") == 2
    assert counted(after, "slewtrack_http_requests_in_flight") == 1  # this one


def test_labels_stay_few_whatever_is_asked(client):
    before = len(samples(client))
    for number in range(50):
        client.get(f"/v1/{number}?x={number}", headers={"User-Agent": str(number)})
        client.get(f"/page-files/{number}")
    families = 2  # of 404: unmatched, and the pages' files
    buckets = 20
    assert len(samples(client)) <= before + families * buckets


def test_solves_and_jobs_are_told():
    metrics = Metrics()
    metrics.solve_s.labels("plan", "done").observe(0.3)
    metrics.iterations.labels("plan").observe(17)
    metrics.count_jobs_by(lambda: {("plan", "queued"): 3, ("plan", "done"): 5, ("x", "queued"): 1})
    text = metrics.text().decode()
    assert 'slewtrack_solve_seconds_bucket{kind="plan",le="0.5",state="done"} 1.0' in text
    assert 'slewtrack_solver_iterations_bucket{kind="plan",le="20.0"} 1.0' in text
    assert 'slewtrack_jobs{kind="plan",state="done"} 5.0' in text
    assert "slewtrack_queue_depth 4.0" in text


def test_ready(client):
    # A solver that is still being warmed up isn't ready.
    answer = eventually(lambda: (a := client.get("/readyz")).status_code == 200 and a).json()
    assert {check["name"]: check["state"] for check in answer["checks"]} | {
        "earth_orientation": "ok"
    } == {"database": "ok", "solver": "ok", "earth_orientation": "ok"}
    assert answer["status"] in ("ready", "degraded")  # which the date decides


@pytest.mark.parametrize(
    ("broken", "name"), [("database_takes_writes", "database"), ("solver_answers", "solver")]
)
def test_not_ready(tmp_path, monkeypatch, caplog, broken, name):
    def fails(*_):
        raise OSError("password=hunter2 /var/lib/secret")

    monkeypatch.setattr(f"app.http.app.{broken}", fails)
    with TestClient(create_app(own_settings(tmp_path))) as client:
        answer = client.get("/readyz")
        assert client.get("/healthz").status_code == 200
    assert answer.status_code == 503
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["retry-after"]
    assert answer.json()["detail"].startswith(f"{name}: ")
    assert "secret" not in answer.text
    assert f"check': '{name}'" in str([record.__dict__ for record in caplog.records])


def test_old_earth_orientation_is_degraded_not_down(tmp_path, monkeypatch):
    ended = readiness.iers_data_end_utc().replace(year=2020)
    monkeypatch.setattr(readiness, "iers_data_end_utc", lambda: ended)
    with TestClient(create_app(own_settings(tmp_path))) as client:
        answer = eventually(lambda: (a := client.get("/readyz")).status_code == 200 and a)
    assert answer.json()["status"] == "degraded"
    assert "astropy-iers-data" in answer.text


def ask(address: str, **headers: str) -> int:
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as answer:
            return answer.status
    except urllib.error.HTTPError as refusal:
        return refusal.code


def test_the_log_tells_each_request_and_no_secret(tmp_path):
    settings = {
        "SLEWTRACK_LOG_FORMAT": "json",
        "SLEWTRACK_DATABASE_URL": "",  # a file in the folder
    }
    database = open_database("", tmp_path)
    upgrade(database)
    _, secret = KeyStore(database).create("dashboard", ["read"])
    database.close()
    with live_service(tmp_path, **settings) as service:
        bearer = {"Authorization": f"Bearer {secret}"}
        path = f"{service.address}/v1/platforms?token={secret}"
        assert ask(path, **bearer, **{"X-Request-ID": "id-7"}) == 422
        assert ask(f"{service.address}/v1/%1b%5b31m%0aforged", **bearer) == 404
        assert ask(f"{service.address}/v1/platforms", Authorization=f"Bearer {secret}x") == 401
    text = service.log.read_text()
    assert secret not in text
    assert secret.split("_", 2)[2] not in text
    assert "\x1b" not in text
    lines = text.splitlines()
    assert not [line for line in lines if "forged" in line and "%0aforged" not in line]
    [told] = [line for line in lines if "id-7" in line]
    key_id = re.match("slewtrack_([0-9a-f]+)_", secret)[1]
    record = json.loads(told)
    assert record["status"] == 422
    assert record["path"] == "/v1/platforms"
    assert record["key_id"] == key_id
    assert record["level"] == "info"
    assert all(isinstance(json.loads(line), dict) for line in lines)


def test_a_console_is_not_steered_by_what_is_logged():
    code = (
        "from app.log.logs import configure_logs, log\n"
        "configure_logs('info', 'console')\n"
        "log.info('request', path='a\\n\\x1b[31mforged', status=200)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    [line] = ran.stderr.splitlines()
    assert "status=200" in line
    assert "\x1b" not in line
