"""Work that a client waits for ends with the client, and at its limits with a refusal."""

import json
import os
import socket
import threading
from functools import partial

import pytest
from child_work import Notes, abort, hang, hoard
from databases import own_settings
from refusal_cases import SHORT
from waiting import alive, eventually

from app.http.routes import horizon, opportunities, plan_routes, search_routes
from app.http.routes.plans import PLANS
from app.http.serving import server
from app.jobs.child import Bounds
from app.requests.examples import (
    ESTIMATE_EXAMPLE,
    OPPORTUNITY_EXAMPLES,
    ORBIT_TRACK_EXAMPLES,
    PICTURE_EXAMPLES,
    PREDICTION_EXAMPLES,
)

CITIES = OPPORTUNITY_EXAMPLES["cities"][1]
# What a route hands to its child, its bounds, and a request that gets so far.
ROUTES = {
    "/v1/opportunities": ((search_routes, "find_windows", "SEARCH_BOUNDS"), {"json": CITIES}),
    "/v1/orbits/tracks": (
        (opportunities, "orbit_track_json", "SEARCH_BOUNDS"),
        {"json": ORBIT_TRACK_EXAMPLES["tle"][1]},
    ),
    "/v1/horizon/estimates": (
        (horizon, "estimate_json", "ESTIMATE_BOUNDS"),
        {"data": {"request": json.dumps(ESTIMATE_EXAMPLE)}, "files": {"images": b"1"}},
    ),
    "/v1/horizon/predictions": (
        (horizon, "prediction_json", "PREDICTION_BOUNDS"),
        {"json": PREDICTION_EXAMPLES["pass"][1]},
    ),
    "/v1/horizon/images": (
        (horizon, "picture", "PICTURE_BOUNDS"),
        {"json": PICTURE_EXAMPLES["ahead"][1]},
    ),
}


@pytest.fixture
def notes(tmp_path):
    return Notes(tmp_path / "notes")


@pytest.fixture(params=[(hang, 0.5, "0.5 s"), (hoard, 60.0, "200 MiB")], ids=["time", "memory"])
def wild(request, notes):
    """Work that goes beyond its bounds, these, and which of them the refusal names."""
    work, deadline_s, bound = request.param
    bounds = Bounds(deadline_s=deadline_s, memory_mib=200)
    return partial(work, os.fsencode(notes.file)), bounds, bound


def refused_as_documented(client, answer, bound, path, method="post"):
    assert answer.status_code == 422, answer.text
    problem = answer.json()
    assert problem["type"] == "urn:slewtrack:problem:too-demanding"
    assert bound in problem["detail"]
    document = client.get("/openapi.json").json()
    documented = document["paths"][path][method]["responses"]["422"]
    if "$ref" in documented:  # what is refused alike everywhere is described once
        documented = document["components"]["responses"]["422"]
    assert answer.headers["content-type"] in documented["content"]


@pytest.mark.parametrize("path", ROUTES)
def test_work_beyond_its_bounds_is_refused(client, monkeypatch, notes, wild, path):
    (module, work, bounds), asked = ROUTES[path]
    doing, within, bound = wild
    monkeypatch.setitem(vars(module), work, doing)
    monkeypatch.setitem(vars(module), bounds, within)
    refused_as_documented(client, client.post(path, **asked), bound, path)
    assert eventually(lambda: not any(map(alive, notes.pids())))


@pytest.mark.parametrize("query", ["", "?format=netcdf"])
def test_a_table_beyond_its_bounds_is_refused(client, monkeypatch, wild, query):
    plan = client.post("/v1/plans", json=SHORT)
    assert plan.status_code == 201, plan.text
    doing, within, bound = wild
    monkeypatch.setitem(vars(PLANS), "table_json", doing)
    monkeypatch.setattr(plan_routes, "stored_table_file", doing)
    monkeypatch.setattr(plan_routes, "EXPORT_BOUNDS", within)
    answer = client.get(f"{plan.headers['location']}/table{query}")
    refused_as_documented(client, answer, bound, "/v1/plans/{id}/table", "get")


def test_a_picture_whose_child_dies_is_not_put_down_to_the_request(client, monkeypatch):
    monkeypatch.setattr(horizon, "picture", abort)
    answer = client.post("/v1/horizon/images", json=PICTURE_EXAMPLES["ahead"][1])
    assert answer.status_code == 500
    assert answer.json()["type"] == "urn:slewtrack:problem:internal-error"


def test_the_child_of_a_client_that_goes_away_is_killed(tmp_path, monkeypatch, notes):
    """Over a real connection: that it has gone is told through all layers of the service."""
    hanging = partial(hang, os.fsencode(notes.file))
    monkeypatch.setattr(search_routes, "find_windows", hanging)
    service = server("127.0.0.1", 0, own_settings(tmp_path))
    children = service.application.state.children
    listening = socket.create_server(("127.0.0.1", 0))
    serving = threading.Thread(target=service.run, args=([listening],))
    serving.start()
    try:
        eventually(lambda: service.started)
        body = json.dumps(CITIES).encode()
        head = (
            "POST /v1/opportunities HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        )
        with socket.create_connection(listening.getsockname()) as connection:
            connection.sendall(head.encode() + body)
            [pid] = eventually(notes.pids)
            assert alive(pid)
            assert children.borrowed_tokens == 1
        assert eventually(lambda: not alive(pid))
        assert eventually(lambda: children.borrowed_tokens == 0)  # others get its place
    finally:
        service.should_exit = True
        serving.join()
