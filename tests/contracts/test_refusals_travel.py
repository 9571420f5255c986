"""Every refusal arrives as it was raised: from a child, from the store, over HTTP."""

import copy
import inspect
import pickle
from dataclasses import replace
from datetime import UTC, datetime
from typing import ClassVar, get_origin

import pytest
from child_work import refuse_by, refuse_unread
from refusal_cases import request
from refusal_kinds import every_refusal

from app.answers.problem import problem_of
from app.cli.service import RefusedThere
from app.http.routes import search_routes
from app.jobs.child import Bounds
from app.jobs.kinds import JOB_KINDS, PLAN
from app.jobs.worker_process import run_in_worker
from app.requests.examples import OPPORTUNITY_EXAMPLES
from planner.base.errors import FieldError, InvalidRequest, Refusal, Relaxation
from planner.spacecraft.imaging.choice import LooksTooClose
from slewtrack.client import problems

BOUNDS = Bounds(deadline_s=120.0, memory_mib=200)
LEAP_UTC = datetime(2016, 12, 31, 23, 59, 59, 500_000, tzinfo=UTC, fold=1)
TOLD = {
    "detail": "it isn't",
    "field": "sessions.0.start",
    "axis": "alpha",
    "limit": "rate",
    "needs_s": 41.5,
    "at_utc": LEAP_UTC,
    "earliest_feasible_start_utc": LEAP_UTC,
    "feasible_stop_utc": LEAP_UTC,
    "costs_sessions": (1, 3),
    "relaxations": (
        Relaxation(on_conflict="shorten_later", session=1, start_later_s=12.4, stop_earlier_s=0.5),
    ),
}
# Those whose first arguments are others than a Refusal's.
MADE_FROM = {
    InvalidRequest: (
        FieldError(field="sessions.0.start", detail="is none", value=91),
        FieldError(field="name", detail="is too long", value=True),
    ),
    RefusedThere: (problems.problem_of({"status": 503, "detail": "is busy", "field": "name"}),),
    LooksTooClose: (1, 20.0, 15.0, 12.5),
}


def whole(kind: type[Refusal]) -> Refusal:
    """One of a class with every member set: a new member must be named above."""
    names = set(inspect.signature(kind).parameters)
    made_from = MADE_FROM.get(kind, ())
    refusal = kind(*made_from) if made_from else kind(**{name: TOLD[name] for name in names})
    vars(refusal).update({name: TOLD[name] for name in set(TOLD) & set(vars(refusal))})
    for base in kind.__mro__:
        for name, of in inspect.get_annotations(base).items():
            if get_origin(of) is not ClassVar and name not in vars(refusal):
                setattr(refusal, name, TOLD[name])
    return refusal


def assert_same(came: Refusal, went: Refusal) -> None:
    assert type(came) is type(went)
    assert vars(came) == vars(went)
    assert came.args == went.args
    assert str(came) == str(went)
    assert problem_of(came) == problem_of(went)


EVERY = pytest.mark.parametrize("kind", sorted(every_refusal(), key=lambda kind: kind.__name__))


@EVERY
def test_every_refusal_survives_its_way(kind):
    went = whole(kind)
    assert not [name for name, value in vars(went).items() if value in (None, ())]
    for protocol in range(pickle.DEFAULT_PROTOCOL, pickle.HIGHEST_PROTOCOL + 1):
        assert_same(pickle.loads(pickle.dumps(went, protocol)), went)
    assert_same(copy.copy(went), went)


@EVERY
def test_every_refusal_comes_out_of_a_child_whole(kind):
    went = whole(kind)
    with pytest.raises(kind) as caught:
        run_in_worker(BOUNDS, refuse_by, went)
    assert_same(caught.value, went)


def test_what_a_child_can_not_read_is_no_bug_over_http(client, monkeypatch):
    monkeypatch.setattr(search_routes, "find_windows", refuse_unread)
    answer = client.post("/v1/opportunities", json=OPPORTUNITY_EXAMPLES["cities"][1])
    assert answer.status_code == 422, answer.text
    told = answer.json()
    assert told["type"] == "urn:slewtrack:problem:invalid-request"
    assert told["errors"] == [
        {"field": "name", "detail": "is none", "value": -0.5, "candidates": []},
        {"field": "", "detail": "", "value": None, "candidates": []},
    ]


SOON = ("initial_state.epoch", "2015-02-27T17:36:19.4Z")
REFUSED = {
    "infeasible-slew": request(SOON),
    "infeasible-slew with offers": request(("on_conflict", "refuse"), example="sequence"),
    "not-visible": request(("sessions.0.target.latitude_deg", -36.1147)),
    "track-breaks-limit": request(
        ("sessions.0.target.axes.alpha.amplitude_deg", 20.0), example="test_motion"
    ),
    "outside-coverage": request(("sessions.0.stop", "2015-02-27T17:45:00Z"), example="oem"),
    "invalid-request": request(),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_kept_refusal_is_told_as_the_direct_one(client, monkeypatch, kind):
    """By its job, in the list, and by who waited: all members but whose refusal it is."""
    if kind == "invalid-request":  # in the child, as of a request that an older version kept
        monkeypatch.setitem(JOB_KINDS, "plan", replace(PLAN, work=refuse_unread))
    direct = client.post("/v1/plans", json=REFUSED[kind])
    assert direct.status_code == 422, direct.text
    told = direct.json()
    assert told["type"] == f"urn:slewtrack:problem:{kind.split()[0]}"
    location = direct.headers["location"]
    job = client.get(location).json()
    assert job["state"] == "refused"
    kept = {"instance": f"urn:uuid:{job['id']}"}
    assert job["problem"] == told | kept
    [listed] = [one for one in client.get("/v1/plans").json()["plans"] if one["id"] == job["id"]]
    assert listed["problem"] == told | kept
    if kind != "invalid-request":
        tried = client.post("/v1/plans?dry_run=true", json=REFUSED[kind])
        assert tried.json() | kept == told | kept
