"""Answers are sent as a client can read them, smaller, and cached without a mix-up."""

import gzip
import json

import pytest
from waiting import PatientClient

from app.http import pages
from app.http.app import create_app
from app.requests.examples import LAS_VEGAS


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    built = tmp_path_factory.mktemp("page")
    (built / "assets").mkdir()
    (built / "assets/swagger-ui-bundle.js").write_text("1;" * 100_000)
    (built / "assets/picture.png").write_bytes(bytes(2000))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pages, "BUILT", built)
        app = create_app()
    with PatientClient(app) as client:
        yield client


@pytest.fixture(scope="module")
def plan(client):
    return f"/v1/plans/{client.post('/v1/plans', json=LAS_VEGAS).json()['id']}"


def raw(client, path, coding=None, **headers):
    """The answer's head, and its body as it came over the wire."""
    headers = {name.replace("_", "-"): value for name, value in headers.items()}
    asked = {"Accept-Encoding": coding or "identity"} | headers
    with client.stream("GET", path, headers=asked) as answer:
        return answer, b"".join(answer.iter_raw())


@pytest.mark.parametrize(
    "path", ["/openapi.json", "PLAN", "PLAN/table?format=csv", "/assets/swagger-ui-bundle.js"]
)
def test_what_is_sent_smaller_is_the_same(client, plan, path):
    path = path.replace("PLAN", plan)
    _, plain = raw(client, path)
    answer, body = raw(client, path, "gzip")
    assert answer.status_code == 200
    assert answer.headers["content-encoding"] == "gzip"
    assert "accept-encoding" in answer.headers["vary"].lower()
    assert gzip.decompress(body) == plain
    assert len(body) < 0.8 * len(plain)
    if "content-length" in answer.headers:
        assert int(answer.headers["content-length"]) == len(body)


def test_posted_answers_are_smaller_too(client):
    headers = {"Accept-Encoding": "gzip", "Content-Type": "application/json"}
    body = json.dumps(LAS_VEGAS)
    with client.stream("POST", "/v1/plans", headers=headers, content=body) as answer:
        packed = b"".join(answer.iter_raw())
    assert (answer.status_code, answer.headers["content-encoding"]) == (201, "gzip")
    assert json.loads(gzip.decompress(packed))["verification"]["passed"]
    assert {word.strip() for word in answer.headers["vary"].split(",")} == {
        "Accept", "Prefer", "Accept-Encoding",
    }  # fmt: skip


def test_short_answers_pictures_and_netcdf_go_as_they_are(client, plan):
    for path in ("/healthz", "/assets/picture.png", f"{plan}/table?format=netcdf"):
        answer, _ = raw(client, path, "gzip")
        assert answer.status_code == 200
        assert "content-encoding" not in answer.headers


def test_an_answer_is_known_again_packed_or_not(client, plan):
    """RFC 9110, 8.8.1: one strong tag must not name two strings of bytes."""
    plain, _ = raw(client, plan)
    coded, _ = raw(client, plan, "gzip")
    assert plain.headers["etag"].startswith('W/"')
    assert coded.headers["etag"] == plain.headers["etag"]
    for coding in (None, "gzip"):
        for known in (plain.headers["etag"], plain.headers["etag"].removeprefix("W/")):
            answer, body = raw(client, plan, coding, If_None_Match=known)
            assert (answer.status_code, body) == (304, b"")
            assert "content-encoding" not in answer.headers
            assert answer.headers["etag"] == plain.headers["etag"]


def test_a_part_of_a_file_is_sent_as_it_is(client):
    path = "/assets/swagger-ui-bundle.js"
    _, plain = raw(client, path)
    answer, part = raw(client, path, "gzip", Range="bytes=10-19")
    assert (answer.status_code, part) == (206, plain[10:20])
    assert "content-encoding" not in answer.headers


def test_events_are_not_held_back(client, plan):
    answer, body = raw(client, f"{plan}/events", "gzip")
    assert "content-encoding" not in answer.headers
    assert body.startswith(b"event: state\n")


def test_a_long_refusal_can_be_read(client):
    many = {**LAS_VEGAS, "sessions": LAS_VEGAS["sessions"] * 201, "platform": "x", "orbit": 1}
    headers = {"Accept-Encoding": "gzip", "Content-Type": "application/json"}
    answer = client.post("/v1/plans", headers=headers, content=json.dumps(many))
    assert answer.status_code == 422
    assert answer.json()["errors"]
