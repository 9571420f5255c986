"""Everybody who waits is answered when the service is told to stop."""

import json
import os
import signal
import socket
import threading
from contextlib import closing
from dataclasses import replace

import httpx2 as httpx
import pytest
from databases import own_settings
from fastapi.testclient import TestClient
from hostile_cases import PLAN, PLANS, head
from job_cases import KINDS
from live_service import live_service
from sqlalchemy import text
from waiting import eventually

from app.http.app import create_app
from app.http.routes import search_routes
from app.jobs.kinds import JOB_KINDS, JobKind
from app.requests.examples import LAS_VEGAS, OPPORTUNITY_EXAMPLES
from app.store.database import open_database

PATIENT = {"Prefer": "wait=60"}


@pytest.fixture
def client(tmp_path, monkeypatch):
    """Of a service whose plans never end."""
    hanging = JobKind(
        name="plan", bounds=KINDS["rest"].bounds, work=KINDS["rest"].work, makes_plans=True
    )
    monkeypatch.setitem(JOB_KINDS, "plan", hanging)
    with TestClient(create_app(own_settings(tmp_path, workers=1))) as client:
        yield client


def stop(client) -> None:
    """As the server does it first."""
    client.portal.call(client.app.state.stopping.set)


def answered(client, ask, begun) -> object:
    """The answer to what is asked before the stop, and only then."""
    answers = []
    asking = threading.Thread(target=lambda: answers.append(ask()))
    asking.start()
    eventually(begun)
    assert not answers
    stop(client)
    asking.join(timeout=60)
    [answer] = answers
    return answer


def runs(client) -> bool:
    return bool(client.get("/v1/plans?state=running").json()["plans"])


def test_who_waits_for_a_plan_is_told_where_it_will_be(client):
    answer = answered(
        client,
        lambda: client.post("/v1/plans", json=LAS_VEGAS, headers=PATIENT),
        lambda: runs(client),
    )
    assert answer.status_code == 202
    assert client.get(answer.headers["location"]).json()["state"] == "running"


def test_streams_of_events_end(client):
    made = client.post("/v1/plans", json=LAS_VEGAS, headers={"Prefer": "respond-async"})
    seen = threading.Event()

    def follow():
        seen.set()
        return client.get(made.headers["location"] + "/events")

    answer = answered(client, follow, seen.is_set)
    assert answer.status_code == 200


def _rest(*_: object) -> None:
    KINDS["rest"].work(b"")


def test_direct_answers_are_given_up(client, monkeypatch):
    begun = threading.Event()
    real = search_routes.where_solved

    async def where_solved(request, task):
        begun.set()
        return await real(request, replace(task, work=_rest))

    monkeypatch.setattr(search_routes, "where_solved", where_solved)
    example = OPPORTUNITY_EXAMPLES["cities"][1]
    answer = answered(client, lambda: client.post("/v1/opportunities", json=example), begun.is_set)
    assert answer.status_code == 503
    assert answer.headers["content-type"] == "application/problem+json"
    assert "is being stopped" in answer.json()["detail"]
    assert int(answer.headers["retry-after"]) > 0
    assert answer.headers["x-request-id"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=["SIGTERM", "SIGINT"])
def test_who_still_sends_is_told_in_the_end(tmp_path, number):
    with live_service(tmp_path) as service:
        address = ("127.0.0.1", service.port)
        with closing(socket.create_connection(address, timeout=60)) as connection:
            told = (f"Content-Length: {len(PLAN)}", "Content-Type: application/json")
            connection.sendall(head(PLANS, *told, "Expect: 100-continue"))
            assert connection.recv(65536).startswith(b"HTTP/1.1 100 ")  # its body is waited for
            os.kill(service.pid, number)
            answer = b""
            while piece := connection.recv(65536):
                answer += piece
    status, _, rest = answer.partition(b"\r\n")
    headers, _, body = rest.partition(b"\r\n\r\n")
    assert status == b"HTTP/1.1 503 Service Unavailable"
    assert {b"retry-after: 5", b"x-content-type-options: nosniff"} <= set(
        headers.lower().split(b"\r\n")
    )
    assert "is being stopped" in json.loads(body)["detail"]
    log = service.log.read_text()
    assert "Traceback" not in log
    assert "CancelledError" not in log


def test_a_service_whose_database_another_version_migrated_ends(tmp_path):
    """By itself, at the first thing it would write, in one line and with exit code 2."""
    settings = own_settings(tmp_path)
    with live_service(tmp_path, SLEWTRACK_DATABASE_URL=settings.database_url) as service:
        assert httpx.get(f"{service.address}/v1/plans").status_code == 200
        database = open_database(settings.database_url, tmp_path)
        with database.writing() as connection:
            connection.execute(text("UPDATE alembic_version SET version_num = '2'"))
        database.close()
        answer = httpx.post(f"{service.address}/v1/plans", json=LAS_VEGAS, timeout=60.0)
        assert answer.status_code == 503
        assert "migrated by another version" in answer.json()["detail"]
        ended = os.waitid(os.P_PID, service.pid, os.WEXITED | os.WNOWAIT)
    assert (ended.si_code, ended.si_status) == (os.CLD_EXITED, 2)
    *log, last = service.log.read_text().splitlines()
    assert last == f"slewtrack: {answer.json()['detail']}"
    assert not [line for line in log if "Traceback" in line]
