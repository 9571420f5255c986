"""Plans are kept, found, followed, replaced and removed over HTTP as the contract promises."""

import json
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from child_work import Notes
from databases import own_settings
from job_cases import KINDS, new_job
from refusal_cases import SHORT, request
from waiting import PatientClient, eventually

from app.http.app import create_app
from app.jobs.kinds import JOB_KINDS, JobKind
from app.requests.plan import read_plan_request
from app.store import audit, jobs, plans
from app.store.packed import unpack
from planner.output.export import EXPORTERS
from planner.planning.sessions.pipeline import make_plan

PLANS = "/v1/plans"
LATER = {"Prefer": "respond-async"}


@pytest.fixture(scope="module")
def plan(client):
    return client.made(PLANS, json=SHORT)


@pytest.fixture
def busy(tmp_path, monkeypatch):
    """A service with one place, whose plans never end, and where their processes note themselves.

    Its data are its own: a plan that never ends would keep the others' places.
    """
    file = tmp_path / "notes"
    work = KINDS["rest"].work
    hanging = JobKind(name="plan", bounds=KINDS["rest"].bounds, work=work, makes_plans=True)
    monkeypatch.setitem(JOB_KINDS, "plan", hanging)
    settings = own_settings(tmp_path, workers=1, queue_max=1)
    with PatientClient(create_app(settings)) as client:
        yield client, Notes(file)


def located(answer):
    assert answer.status_code == 202, answer.text
    return answer.headers["location"]


def ended(client, location):
    def end():
        told = client.get(location).json()
        return told if told["state"] not in ("queued", "running") else None

    return eventually(end)


def cancelled(client, location):
    """At once, or as soon as the process that is just being made for it is there."""
    answer = client.delete(location)
    assert answer.status_code in (200, 202)
    assert (answer.json()["state"] == "cancelled") == (answer.status_code == 200)
    return ended(client, location)["state"] == "cancelled"


def test_a_plan_is_read_again_as_it_was_answered(client, plan):
    again = client.get(f"{PLANS}/{plan['id']}")
    assert again.status_code == 200
    assert again.json() == plan
    assert (plan["revision"], plan["revises"]) == (1, None)


def test_the_stored_table_is_the_planned_one_to_the_bit(client, plan):
    table = planned_here(json.dumps(SHORT)).table
    with client.app.state.database.reading() as connection:
        stored = plans.get(connection, jobs.get(connection, plan["id"]))
    columns = unpack(stored.table_columns).columns
    assert columns["position"].tobytes() == np.ascontiguousarray(table.position).tobytes()
    assert columns["rate_rad_s"].tobytes() == np.ascontiguousarray(table.rate_rad_s).tobytes()
    rows = len(table.position)
    assert len(stored.table_columns) < 16 * rows  # half of the four doubles of a row


def test_a_plan_never_changes_so_need_not_be_sent_twice(client, plan):
    location = f"{PLANS}/{plan['id']}"
    as_it_is = {"Accept-Encoding": "identity"}
    tag = client.get(location, headers=as_it_is).headers["etag"]
    assert client.get(location).headers["cache-control"] == "private, no-cache"
    for known in (tag, f'"other", {tag.removeprefix("W/")}', "*"):
        answer = client.get(location, headers=as_it_is | {"If-None-Match": known})
        assert (answer.status_code, answer.content) == (304, b"")
        assert answer.headers["etag"] == tag
    assert client.get(location, headers={"If-None-Match": '"other"'}).status_code == 200


@pytest.mark.parametrize("name", EXPORTERS)
def test_a_stored_table_is_written_as_its_plan_is(client, plan, name):
    """The formats themselves are held to other libraries elsewhere."""
    answer = client.get(f"{PLANS}/{plan['id']}/table?format={name}")
    assert answer.status_code == 200, answer.text
    assert answer.content == written(client, plan, SHORT, name)
    assert answer.headers["content-type"].split(";")[0] == EXPORTERS[name].media_type
    suffix = EXPORTERS[name].suffix
    assert answer.headers["content-disposition"] == f'attachment; filename="Las-Vegas{suffix}"'
    tag = {"If-None-Match": answer.headers["etag"]}
    assert client.get(f"{PLANS}/{plan['id']}/table?format={name}", headers=tag).status_code == 304


@cache
def planned_here(text):
    """A plan that was never stored."""
    return make_plan(read_plan_request(text.encode()))


def written(client, plan, document, name):
    """The file of a plan that was never stored, as of the same moment."""
    fresh = planned_here(json.dumps(document))
    with client.app.state.database.reading() as connection:
        planned_utc = plans.get(connection, jobs.get(connection, plan["id"])).planned_utc
    return EXPORTERS[name].write(fresh, planned_utc)


def test_a_table_without_a_format_is_that_of_the_answer(client, plan):
    location = f"{PLANS}/{plan['id']}/table"
    assert client.get(location).json() == plan["table"]
    assert client.get(location, headers={"Accept": "text/csv"}).text.startswith("# slewtrack")
    assert client.get(location, headers={"Accept": "image/webp"}).status_code == 406


def test_sessions_cut_short_are_exported_as_flown(client):
    document = request(example="sequence")
    plan = client.post(PLANS, json=document).json()
    assert any("least_loss" in warning for warning in plan["warnings"])
    answer = client.get(f"{PLANS}/{plan['id']}/table?format=czml")
    assert answer.content == written(client, plan, document, "czml")


def test_the_list_is_in_pages_the_latest_first(client):
    name = "listed here only"
    ids = [client.post(PLANS, json={**SHORT, "name": f"{name} {k}"}).json()["id"] for k in range(3)]
    first = client.get(PLANS, params={"limit": 2, "name": name}).json()
    assert [one["id"] for one in first["plans"]] == [ids[2], ids[1]]
    second = client.get(PLANS, params={"limit": 2, "name": name, "cursor": first["next"]}).json()
    assert [one["id"] for one in second["plans"]] == [ids[0]]
    assert second["next"] is None
    assert client.get(PLANS, params={"state": "failed", "name": name}).json()["plans"] == []
    assert client.get(PLANS, params={"name": "100%_"}).json()["plans"] == []


def test_passes_of_a_campaign_are_listed_under_its_id_only(client, tmp_path, plan):
    whole = new_job("campaign", tmp_path)
    passes = [new_job("plan", tmp_path, name="pass", parent_id=whole.id) for _ in range(2)]
    with client.app.state.database.writing() as connection:
        for job in (whole, *passes):
            jobs.accept(connection, job, lease_s=3600.0)  # another service's, so nobody plans it

    def ids(**query):
        return [one["id"] for one in client.get(PLANS, params=query).json()["plans"]]

    assert plan["id"] in ids()
    latest, first = sorted((job.id for job in passes), reverse=True)
    assert not {latest, first} & set(ids())
    assert ids(campaign=whole.id) == [latest, first]
    assert ids(campaign=whole.id, cursor=latest) == [first]
    assert ids(campaign=plan["id"]) == []


@pytest.mark.parametrize(
    "query", ["limit=0", "limit=201", "cursor=x", "state=lost", "name=", "nmae=x", "campaign=x"]
)
def test_a_list_asked_for_wrongly_is_refused(client, query):
    answer = client.get(f"{PLANS}?{query}")
    assert answer.status_code == 422
    assert answer.json()["field"] == "query." + query.split("=")[0]


def test_a_refused_plan_stays_readable(client):
    below = request(("sessions.0.target.latitude_deg", -36.0))
    answer = client.post(PLANS, json=below)
    assert answer.status_code == 422
    job = client.get(answer.headers["location"]).json()
    assert job["state"] == "refused"
    assert {**answer.json(), "instance": ""} == {
        name: value
        for name, value in {**job["problem"], "instance": ""}.items()
        if value not in (None, [])
    }
    assert client.get(f"{answer.headers['location']}/table").status_code == 409


def test_what_cannot_be_read_is_not_kept(client):
    answer = client.post(PLANS, json={"name": "nothing"})
    assert answer.status_code == 422
    assert "location" not in answer.headers


@pytest.mark.parametrize(
    ("prefer", "applied"),
    [
        ("respond-async", "respond-async"),
        ("wait=0", "wait=0"),
        ('handling=lenient, Wait = "0"', "wait=0"),
        ("respond-async, wait=10", "respond-async"),
    ],
)
def test_who_does_not_want_to_wait_is_told_where(client, prefer, applied):
    asked = {"json": SHORT, "headers": {"Prefer": prefer, "Idempotency-Key": f"told {prefer}"}}
    answer = client.post(PLANS, **asked)
    assert answer.headers["preference-applied"] == applied
    assert "Prefer" in answer.headers["vary"]
    assert ended(client, located(answer))["state"] == "done"
    assert located(client.post(PLANS, **asked)) == located(answer)  # made or not


def test_nobody_waits_longer_than_a_minute(client):
    answer = client.post(PLANS, json=SHORT, headers={"Prefer": "wait=600"})
    assert answer.headers["preference-applied"] == "wait=60"


@pytest.mark.parametrize("prefer", ["wait=soon", "wait=-1", "return=minimal", ""])
def test_wishes_that_are_not_understood_are_ignored(client, prefer):
    answer = client.post(PLANS, json=SHORT, headers={"Prefer": prefer})
    assert answer.status_code == 201
    assert "preference-applied" not in answer.headers


def test_the_same_key_and_request_get_the_same_plan(client):
    key = {"Idempotency-Key": "pass 4711"}
    with ThreadPoolExecutor(4) as threads:
        answers = list(threads.map(lambda _: client.post(PLANS, json=SHORT, headers=key), range(4)))
    assert {answer.status_code for answer in answers} == {201}
    assert len({answer.content for answer in answers}) == 1
    other = client.post(PLANS, json={**SHORT, "name": "other"}, headers=key)
    assert other.status_code == 422
    assert other.json()["type"].endswith("idempotency-key-reused")
    assert other.json()["field"] == "header.Idempotency-Key"
    revised = f"{PLANS}?revises={answers[0].json()['id']}"
    assert client.post(revised, json=SHORT, headers=key).status_code == 422
    unlike = client.post(PLANS, json=SHORT, headers={"Idempotency-Key": "pass 4712"})
    assert unlike.json()["id"] != answers[0].json()["id"]


@pytest.mark.parametrize("key", ["", "x" * 256, "a\tb"])
def test_a_key_that_is_none_is_refused(client, key):
    answer = client.post(PLANS, json=SHORT, headers={"Idempotency-Key": key})
    assert answer.status_code == 422
    assert answer.json()["field"] == "header.Idempotency-Key"


def test_a_plan_is_revised_by_another(client, plan):
    second = client.post(f"{PLANS}?revises={plan['id']}", json=SHORT).json()
    third = client.post(f"{PLANS}?revises={second['id']}", json=SHORT).json()
    assert (second["revision"], second["revises"]) == (2, plan["id"])
    assert (third["revision"], third["revises"]) == (3, second["id"])
    assert client.get(f"{PLANS}/{plan['id']}").json() == plan


def test_only_what_was_planned_can_be_revised(client):
    unknown = client.post(f"{PLANS}?revises=01890a5d-ac96-774b-bcce-b302099a8057", json=SHORT)
    assert (unknown.status_code, unknown.json()["field"]) == (422, "query.revises")
    refused = client.post(PLANS, json=request(("sessions.0.target.latitude_deg", -36.0)))
    job_id = refused.headers["location"].rsplit("/", 1)[1]
    answer = client.post(f"{PLANS}?revises={job_id}", json=SHORT)
    assert (answer.status_code, answer.json()["type"][-8:]) == (409, "conflict")
    assert "refused" in answer.json()["detail"]


def test_a_finished_plan_is_deleted(client):
    location = client.post(PLANS, json=SHORT).headers["location"]
    assert client.delete(location).status_code == 204
    for path in (location, f"{location}/table", f"{location}/events"):
        assert client.get(path).status_code == 404
    assert client.delete(location).status_code == 404
    with client.app.state.database.reading() as connection:
        [entry, *_] = audit.entries(connection, limit=1, before=10**9)
    assert (entry.action, entry.subject) == ("plan.delete", location.rsplit("/", 1)[1])


def test_ids_of_another_resource_are_unknown(client, plan):
    assert client.get(f"/v1/spacecraft/plans/{plan['id']}").status_code == 404
    assert client.get(f"{PLANS}/nonsense").status_code in (404, 422)


def events_of(text):
    fields = [
        dict(line.split(": ", 1) for line in block.splitlines()) for block in text.split("\n\n")
    ]
    return [(int(one["id"]), one["event"], json.loads(one["data"])) for one in fields if one]


def test_events_tell_what_happens_until_the_end(client):
    location = located(client.post(PLANS, json=SHORT, headers=LATER))
    answer = client.get(f"{location}/events")
    assert answer.headers["content-type"].startswith("text/event-stream")
    told = events_of(answer.text)
    assert [seq for seq, *_ in told] == list(range(1, len(told) + 1))
    states = [data["state"] for _, kind, data in told if kind == "state"]
    assert states == ["queued", "running", "done"]
    rest = client.get(f"{location}/events", headers={"Last-Event-ID": "1"}).text
    assert events_of(rest) == told[1:]
    last = {"Last-Event-ID": str(len(told))}
    assert client.get(f"{location}/events", headers=last).status_code == 204
    wrong = client.get(f"{location}/events", headers={"Last-Event-ID": "x"})
    assert (wrong.status_code, wrong.json()["field"]) == (422, "header.Last-Event-ID")
    assert client.get(f"{location}/events", headers={"Accept": "image/webp"}).status_code == 406


def test_the_busy_service_knows_of_no_jobs_but_its_own(plan, busy):
    """Else the other service, whose database it is, would take up what waits here."""
    client, _ = busy
    assert client.get(PLANS).json()["plans"] == []


def test_a_plan_that_runs_is_cancelled(busy):
    client, _ = busy
    location = located(client.post(PLANS, json=SHORT, headers=LATER))
    assert client.get(f"{location}/table").status_code == 409
    assert client.get(location).json()["state"] == "running"
    assert cancelled(client, location)
    assert events_of(client.get(f"{location}/events").text)[-1][2]["state"] == "cancelled"
    assert client.delete(location).status_code == 204


def test_a_full_queue_says_when_to_come_back(busy):
    client, _ = busy
    running, waiting = (located(client.post(PLANS, json=SHORT, headers=LATER)) for _ in range(2))
    assert client.get(waiting).json()["state"] == "queued"
    answer = client.post(PLANS, json=SHORT, headers=LATER)
    assert answer.status_code == 503
    assert answer.json()["type"].endswith("queue-full")
    assert int(answer.headers["retry-after"]) > 0
    assert len(client.get(PLANS).json()["plans"]) == 2
    for location in (waiting, running):
        assert cancelled(client, location)


def test_patience_ends_with_where_to_look(busy):
    client, _ = busy
    answer = client.post(PLANS, json=SHORT, headers={"Prefer": "wait=1"})
    assert answer.headers["preference-applied"] == "wait=1"
    assert cancelled(client, located(answer))
