"""Origins of web pages that may use the service, and what they may read."""

import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner
from waiting import PatientClient

from app.cli import main
from app.http.app import create_app
from app.requests.examples import LAS_VEGAS
from app.settings import Settings
from planner.base.errors import InvalidInput

PAGE, OTHER = "https://planner.example", "https://elsewhere.example"
HERE, THERE = ("127.0.0.1", 40000), ("192.0.2.7", 40000)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("origins")


@pytest.fixture(scope="module")
def app(folder):
    origins = f"{PAGE.upper()} , http://localhost:5173,"
    app = create_app(Settings(data_dir=folder, allowed_origins=origins))
    with TestClient(app):
        yield app


@pytest.fixture(scope="module")
def key(folder):
    words = ["keys", "create", "page", "--scope", "write"]
    made = CliRunner().invoke(main, words, env={"SLEWTRACK_DATA_DIR": str(folder)})
    return {"Authorization": f"Bearer {made.stdout.strip()}"}


def client_of(app, end):
    return PatientClient(
        app, base_url="http://localhost", client=end, raise_server_exceptions=False
    )


@pytest.fixture(scope="module")
def here(app):
    return client_of(app, HERE)


@pytest.fixture(scope="module")
def there(app):
    return client_of(app, THERE)


def from_page(origin=PAGE, **headers):
    """As a browser asks for a page of another site."""
    return {"Origin": origin, "Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "cors"} | headers


def asks_first(client, origin=PAGE, method="POST", path="/v1/plans"):
    headers = from_page(origin) | {
        "Access-Control-Request-Method": method,
        "Access-Control-Request-Headers": "authorization,content-type,idempotency-key",
    }
    return client.options(path, headers=headers)


def words(answer, header):
    return {word.strip().lower() for word in answer.headers.get(header, "").split(",")} - {""}


@pytest.mark.parametrize("method", ["POST", "DELETE", "GET"])
def test_a_browser_that_asks_first_is_told_without_a_key(here, there, method):
    for client in (here, there):
        answer = asks_first(client, method=method)
        assert answer.status_code == 200
        assert answer.headers["access-control-allow-origin"] == PAGE
        assert method.lower() in words(answer, "access-control-allow-methods")
        assert words(answer, "access-control-allow-headers") >= {
            "authorization", "content-type", "idempotency-key", "if-none-match", "last-event-id",
            "prefer", "x-request-id",
        }  # fmt: skip
        assert "access-control-allow-credentials" not in answer.headers  # there are no cookies
        assert "origin" in words(answer, "vary")


def test_a_page_of_an_allowed_origin_reads_what_it_needs(here):
    answer = here.post("/v1/plans", json=LAS_VEGAS, headers=from_page())
    assert answer.status_code == 201, answer.text
    assert answer.headers["access-control-allow-origin"] == PAGE
    assert words(answer, "access-control-expose-headers") >= {
        "location", "etag", "link", "retry-after", "x-request-id", "content-disposition",
    }  # fmt: skip
    assert {"origin", "accept", "prefer", "accept-encoding"} == words(answer, "vary")
    events = here.get(f"{answer.headers['location']}/events", headers=from_page())
    assert events.headers["access-control-allow-origin"] == PAGE


def test_it_needs_a_key_where_others_do(there, key):
    refused = there.get("/v1/platforms", headers=from_page())
    assert refused.status_code == 401
    assert refused.headers["access-control-allow-origin"] == PAGE  # the page may say why
    assert there.get("/v1/platforms", headers=from_page() | key).status_code == 200


def test_it_needs_a_key_on_loopback_where_that_is_set(folder):
    settings = Settings(data_dir=folder, allowed_origins=PAGE, require_keys=True)
    with TestClient(create_app(settings), base_url="http://localhost", client=HERE) as client:
        assert client.get("/v1/platforms", headers=from_page()).status_code == 401


def test_host_is_looked_at_all_the_same(app):
    """Against DNS rebinding."""
    client = TestClient(app, base_url="http://planner.example", client=HERE)
    assert client.get("/v1/platforms", headers=from_page()).status_code == 421


@pytest.mark.parametrize(
    "origin",
    [OTHER, "null", "http://planner.example", f"{PAGE}:8443", f"{PAGE}.evil.example", "*", "",
     "https://evil.example/https://planner.example"],
)  # fmt: skip
def test_other_pages_get_no_word(here, there, key, origin):
    assert "access-control-allow-origin" not in asks_first(here, origin).headers
    refused = here.get("/v1/platforms", headers=from_page(origin))
    assert refused.status_code == 403
    assert "access-control-allow-origin" not in refused.headers
    with_key = there.get("/v1/platforms", headers=from_page(origin) | key)
    assert with_key.status_code == 200  # a browser keeps it from the page
    assert "access-control-allow-origin" not in with_key.headers


def test_an_image_or_script_of_an_allowed_page_sends_no_origin_and_gets_nothing(here):
    headers = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"}
    assert here.get("/v1/platforms", headers=headers).status_code == 403


@pytest.mark.parametrize(
    "text",
    ["*", "planner.example", "https://planner.example/app", "ftp://planner.example", "null",
     "https://", "https://a.example https://b.example", "https://user@planner.example"],
)  # fmt: skip
def test_what_is_no_origin_is_refused_when_the_service_starts(monkeypatch, text):
    from app.settings import settings_of_environment

    monkeypatch.setenv("SLEWTRACK_ALLOWED_ORIGINS", text)
    with pytest.raises(InvalidInput) as refusal:
        settings_of_environment()
    assert refusal.value.field == "SLEWTRACK_ALLOWED_ORIGINS"
    assert "each must be an origin such as https://planner.example" in refusal.value.detail
