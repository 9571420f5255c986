"""Work that is cancelled while a client waits for it answers 409, whatever it was to make."""

import threading
from dataclasses import replace

import pytest
from databases import own_settings
from job_cases import KINDS
from starlette.testclient import TestClient
from waiting import eventually

from app.http.app import create_app
from app.jobs.kinds import JOB_KINDS
from app.requests.examples import CAMPAIGN_EXAMPLES, FOUR_MODES, LAS_VEGAS

# By kind: where it is posted, where it is kept, and a request.
POSTS = {
    "plan": ("/v1/plans", "/v1/plans", LAS_VEGAS),
    "spacecraft": ("/v1/spacecraft/plans", "/v1/spacecraft/plans", FOUR_MODES),
    "campaign": ("/v1/campaigns", "/v1/campaigns", CAMPAIGN_EXAMPLES["cities"][1]),
    "flights": ("/v1/plans/{plan}/flights", "/v1/flights", {"runs": 4}),
}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with TestClient(create_app(own_settings(tmp_path_factory.mktemp("waiting"), workers=1))) as one:
        yield one


@pytest.fixture(scope="module")
def plan_id(client):
    return client.post("/v1/plans", json=LAS_VEGAS, headers={"Prefer": "wait=60"}).json()["id"]


@pytest.mark.parametrize("kind", POSTS)
def test_cancelled_while_waited_for(client, plan_id, monkeypatch, kind):
    never_ends = replace(JOB_KINDS[kind], bounds=KINDS["rest"].bounds, work=KINDS["rest"].work)
    monkeypatch.setitem(JOB_KINDS, kind, never_ends)
    path, kept, request = POSTS[kind]
    answers = []

    def post():
        asked = path.format(plan=plan_id)
        answers.append(client.post(asked, json=request, headers={"Prefer": "wait=60"}))

    def running():
        listed = client.get(f"{kept}?state=running").json()
        return next(iter(listed.values()))

    waits = threading.Thread(target=post)
    waits.start()
    assert eventually(running)
    [job] = running()
    assert client.delete(f"{kept}/{job['id']}").status_code in (200, 202)
    waits.join(timeout=60)
    [answer] = answers
    assert answer.status_code == 409, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert "cancelled while it was waited for" in answer.json()["detail"]


@pytest.mark.parametrize("kind", ["campaign", "flights"])
def test_how_far_it_is_needs_no_second_reading(client, plan_id, kind):
    path, kept, request = POSTS[kind]
    later = {"Prefer": "respond-async"}
    made = client.post(path.format(plan=plan_id), json=request, headers=later)
    assert made.headers["location"].startswith(kept)
    location = made.headers["location"]
    eventually(lambda: client.get(location).json()["state"] == "done")
    tag = client.get(location).headers["etag"]
    again = client.get(location, headers={"If-None-Match": tag})
    assert (again.status_code, again.content) == (304, b"")
