"""Each parameter is taken once, known and as documented; HEAD goes where GET does."""

import json
import re

import pytest
from api_document import api_document
from waiting import eventually

from app.ids import new_id
from app.requests.examples import LAS_VEGAS

PATHS = api_document()["paths"]
NO_PLAN = new_id()
PAGES = ["/docs", "/redoc", "/openapi.json"]
OPERATIONS = [(path, method) for path, operations in PATHS.items() for method in operations]
ASKED = [path for path, method in OPERATIONS if method == "get"] + PAGES
PARAMETERS = [
    (path, method, parameter["name"], parameter["required"])
    for path, operations in PATHS.items()
    for method, operation in operations.items()
    for parameter in operation.get("parameters", ())
    if parameter["in"] == "query"
]
NEEDED = {path: f"{name}=a&" for path, _, name, is_needed in PARAMETERS if is_needed}


@pytest.fixture(scope="module")
def plan(client):
    return client.post("/v1/plans", json=LAS_VEGAS).json()


def sent(client, method, path, query=""):
    """A request whose body can be read, to a plan there may be."""
    address = re.sub("{.*?}", NO_PLAN, path) + query
    headers = {"Content-Type": "application/json"}
    content = json.dumps(LAS_VEGAS) if method == "post" else None
    return client.request(method.upper(), address, content=content, headers=headers)


def refused(answer, field):
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["field"] == f"query.{field}"


@pytest.mark.parametrize(("path", "method"), [*OPERATIONS, *((page, "get") for page in PAGES)])
def test_unknown_parameters(client, path, method):
    refused(sent(client, method, path, f"?{NEEDED.get(path, '')}x=1"), "x")


@pytest.mark.parametrize(("path", "method", "name"), [one[:3] for one in PARAMETERS])
def test_parameters_given_twice(client, path, method, name):
    refused(sent(client, method, path, f"?{name}=1&{name}=1"), name)
    refused(sent(client, method, path, f"?{name}=true&{name}=false"), name)


@pytest.mark.parametrize("limit", ["1_0", "%2B1", "1.0", "%201", "1%0A", "٣", "1e1", "", "0x1"])
def test_numbers_as_they_are_documented(client, limit):
    refused(client.get(f"/v1/plans?limit={limit}"), "limit")
    assert client.get("/v1/plans?limit=10").status_code == 200


@pytest.mark.parametrize("word", ["1", "yes", "on", "True", "true%20", ""])
def test_true_is_true(client, word):
    refused(sent(client, "post", "/v1/plans", f"?dry_run={word}"), "dry_run")
    assert sent(client, "post", "/v1/plans", "?dry_run=true").status_code == 200


@pytest.mark.parametrize("mark", ["\n", " ", "\t", "\u2028"])
@pytest.mark.parametrize("time", ["{}2015-02-27T17:34:00Z", "2015-02-27T17:34:00Z{}"])
def test_times_hold_nothing_beside_themselves(client, time, mark):
    state = LAS_VEGAS["initial_state"] | {"epoch": time.format(mark)}
    answer = client.post("/v1/plans?dry_run=true", json=LAS_VEGAS | {"initial_state": state})
    assert answer.status_code == 422
    assert answer.json()["field"] == "initial_state.epoch"


@pytest.mark.parametrize("time", ["2015-02-27T17:34:00,0Z", "2015-02-27 17:34:00Z"])
def test_times_are_those_of_rfc_3339(client, time):
    state = LAS_VEGAS["initial_state"] | {"epoch": time}
    answer = client.post("/v1/plans?dry_run=true", json=LAS_VEGAS | {"initial_state": state})
    assert answer.json()["field"] == "initial_state.epoch"


VARYING = {"x-request-id", "date"}


@pytest.mark.parametrize("path", [*ASKED, "/page-files/pages.css", "/v1/nothing"])
def test_head_answers_as_get_without_a_body(client, plan, path):
    address = path.replace("{id}", plan["id"])
    if path == "/readyz":  # a machine that is busy enough isn't ready, and may soon be
        asked, told = eventually(lambda: ready_both_times(client, address))
    else:
        asked, told = client.get(address), client.head(address)
    assert told.status_code == asked.status_code
    assert told.content == b""
    same = {name for name in asked.headers if name not in VARYING}
    if path == "/metrics":  # it counts itself
        same.discard("content-length")
    if asked.status_code >= 400:  # an instance of its own
        same -= {"content-length"}
    assert {name: told.headers[name] for name in same} == {n: asked.headers[n] for n in same}


def ready_both_times(client, address):
    answers = client.get(address), client.head(address)
    return answers if {answer.status_code for answer in answers} == {200} else None


@pytest.mark.parametrize("path", ASKED)
def test_head_is_among_the_methods_allowed(client, path):
    answer = client.put(path.replace("{id}", NO_PLAN))
    assert answer.status_code == 405
    assert {"GET", "HEAD"} <= set(answer.headers["allow"].split(", "))


def test_head_is_refused_where_there_is_no_get(client):
    answer = client.head("/v1/horizon/images")
    assert answer.status_code == 405
    assert answer.headers["allow"] == "POST"
