"""Access: openly on loopback, by the right key elsewhere."""

import hashlib
import os
import re

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import inspect, text
from typer.testing import CliRunner

from app.cli import main
from app.http.app import create_app
from app.requests.examples import LAS_VEGAS
from app.settings import Settings
from app.store.database import open_database

ELSEWHERE = ("192.0.2.7", 40000)  # RFC 5737: nobody's
READ, WRITE = ("GET", "/v1/platforms"), ("POST", "/v1/plans")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("keys")


@pytest.fixture(scope="module")
def keys(folder):
    """Runs `slewtrack keys` on the folder's database; what it prints."""

    def run(*words: str, code: int = 0) -> str:
        environment = {"SLEWTRACK_DATA_DIR": str(folder)}
        result = CliRunner().invoke(main, ["keys", *words], env=environment)
        assert result.exit_code == code, result.output
        return result.stderr if code else result.stdout

    return run


@pytest.fixture(scope="module")
def secrets(keys):
    return {
        scope: keys("create", f"{scope} key", "--scope", scope).strip()
        for scope in ("read", "write", "admin")
    }


@pytest.fixture(scope="module")
def app(folder):
    app = create_app(Settings(data_dir=folder, failures_per_minute=1000))
    with TestClient(app):
        yield app


@pytest.fixture(scope="module")
def there(app):
    return TestClient(app, client=ELSEWHERE, raise_server_exceptions=False)


@pytest.fixture(scope="module")
def here(app):
    return TestClient(app, base_url="http://localhost", client=("127.0.0.1", 40000))


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


def refused(answer, status: int, says: str) -> None:
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert says in answer.json()["detail"]


@pytest.mark.parametrize("path", ["/healthz", "/readyz", "/docs", "/redoc", "/openapi.json"])
def test_probes_and_pages_need_no_key(there, path):
    # Who is asked while it still warms up says 503.
    assert there.get(path).status_code in ((200, 503) if path == "/readyz" else (200,))


@pytest.mark.parametrize("path", ["/v1/platforms", "/metrics", "/v1/audit", "/no/such/route"])
@pytest.mark.parametrize("method", ["GET", "POST", "DELETE", "PUT", "OPTIONS", "HEAD"])
def test_all_else_needs_one_from_elsewhere(there, path, method):
    answer = there.request(method, path)
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"].startswith("Bearer ")


@pytest.mark.parametrize("held", ["read", "write", "admin"])
@pytest.mark.parametrize(
    ("needed", "method", "path"),
    [
        ("read", *READ),
        ("read", "GET", "/metrics"),
        ("write", *WRITE),
        ("admin", "GET", "/v1/audit"),
    ],
)
def test_scopes_include_the_lesser_ones(there, secrets, held, needed, method, path):
    order = ["read", "write", "admin"]
    answer = there.request(method, path, headers=bearer(secrets[held]))
    if order.index(held) < order.index(needed):
        refused(answer, 403, f"scope {needed}")
    else:
        assert answer.status_code in (200, 415)


@pytest.mark.parametrize(
    "given",
    [
        "",
        "Basic eDp5",
        "Bearer",
        "Bearer slewtrack_x",
        "Bearer ' OR 1=1 --",
        "Bearer " + "x" * 9000,
    ],
)
def test_what_is_no_key_is_refused_even_here(here, given):
    refused(here.get("/v1/platforms", headers={"Authorization": given}), 401, "key")


def test_nearly_the_secret_is_not_the_secret(there, secrets):
    secret = secrets["read"]
    for near in (secret[:-1], secret + "0", secret[:-1] + "#", secret.swapcase()):
        refused(there.get("/v1/platforms", headers=bearer(near)), 401, "unknown or revoked")


def test_a_revoked_key_is_refused_at_once(there, keys):
    secret = keys("create", "short-lived").strip()
    [key_id] = re.findall("slewtrack_([0-9a-f]+)_", secret)
    assert there.get("/v1/platforms", headers=bearer(secret)).status_code == 200
    keys("revoke", key_id)
    refused(there.get("/v1/platforms", headers=bearer(secret)), 401, "unknown or revoked")
    assert re.search(rf"{key_id} .*revoked .*short-lived", keys("list"))
    assert "no valid key" in keys("revoke", key_id, code=2)


def test_secrets_are_kept_as_digests_only(folder, secrets, keys):
    database = open_database(Settings().database_url, folder)
    with database.reading() as connection:
        tables = inspect(connection).get_table_names()
        kept = repr([connection.execute(text(f"SELECT * FROM {name}")).all() for name in tables])
    database.close()
    for secret in secrets.values():
        assert secret not in kept
        assert secret.split("_", 2)[2] not in kept
        assert hashlib.sha256(secret.encode()).hexdigest() in kept
        assert secret not in keys("list")


def test_a_plan_says_whose_key_asked_for_it(there, here, secrets):
    whose = bearer(secrets["write"])
    made = there.post("/v1/plans", json=LAS_VEGAS, headers=whose).json()
    assert made["requested_by"] == "write key"
    [listed, *_] = here.get("/v1/plans", headers=bearer(secrets["read"])).json()["plans"]
    assert (listed["id"], listed["requested_by"]) == (made["id"], "write key")
    assert here.post("/v1/plans", json=LAS_VEGAS).json()["requested_by"] is None


def test_keys_made_and_revoked_are_in_the_audit_log(there, secrets, keys):
    secret = keys("create", "audited").strip()
    [key_id] = re.findall("slewtrack_([0-9a-f]+)_", secret)
    keys("revoke", key_id)
    log = there.get("/v1/audit", headers=bearer(secrets["admin"])).json()["entries"]
    assert [(one["action"], one["subject"]) for one in log[:2]] == [
        ("key.revoke", key_id),
        ("key.create", key_id),
    ]
    older = there.get(f"/v1/audit?before={log[0]['id']}&limit=1", headers=bearer(secrets["admin"]))
    assert older.json()["entries"] == [log[1]]


@pytest.mark.parametrize(
    "words",
    [
        ("create", "a\nb"),
        ("create", ""),
        ("create", "x", "--scope=root"),
        ("create", os.fsdecode(b"\xff")),
    ],
)
def test_keys_that_can_not_be_made(keys, words):
    [line] = keys(*words, code=2).splitlines()
    assert line.startswith("slewtrack: ")


@pytest.mark.parametrize("key_id", ["nobody", "", "a\0b", os.fsdecode(b"\xff"), "x" * 9999])
def test_keys_that_can_not_be_revoked(keys, key_id):
    [line] = keys("revoke", key_id, code=2).splitlines()
    assert line.startswith("slewtrack: ID: no valid key")


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "[::1]", "LOCALHOST:8000", "[::1]:80"])
def test_open_by_the_names_of_this_machine(here, host):
    assert here.get("/v1/platforms", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "localhost.evil.example", "127.0.0.1.nip.io", "", "[::1"]
)
def test_a_name_that_was_rebound_to_this_machine_is_refused(here, host):
    """DNS rebinding: the page's own name leads here, so that only the Host header tells."""
    refused(here.get("/v1/platforms", headers={"Host": host}), 421, "SLEWTRACK_ALLOWED_HOSTS")


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://localhost:3000"},
        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"},
        {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "cors"},
    ],
)
@pytest.mark.parametrize(("method", "path"), [READ, ("POST", "/v1/horizon/estimates")])
def test_pages_of_other_sites_are_refused(here, headers, method, path):
    answer = here.request(method, path, headers=headers)
    refused(answer, 403, "other sites")
    assert not [name for name in answer.headers if name.startswith("access-control")]


def test_our_own_page_and_links_to_it_work(here):
    own = {"Origin": "http://localhost", "Sec-Fetch-Site": "same-origin"}
    assert here.get("/v1/platforms", headers=own).status_code == 200
    followed = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
    assert here.get("/docs", headers=followed).status_code == 200


def test_preflights_are_not_granted(here):
    answer = here.options("/v1/plans", headers={"Access-Control-Request-Method": "POST"})
    assert answer.status_code == 405
    assert not [name for name in answer.headers if name.startswith("access-control")]


@pytest.mark.parametrize(
    "name",
    [
        *(f"X-Forwarded-{what}" for what in ("For", "Host", "Proto", "Port", "Server", "Any")),
        *("Forwarded", "Via", "X-Real-IP", "CF-Connecting-IP", "True-Client-IP"),
    ],
)
def test_what_a_proxy_passed_on_needs_a_key(here, secrets, name):
    refused(here.get("/v1/platforms", headers={name: "127.0.0.1"}), 401, "proxy")
    known = bearer(secrets["read"]) | {name: "127.0.0.1", "Host": "plans.example"}
    assert here.get("/v1/platforms", headers=known).status_code == 200


def test_no_cookies(here):
    for path in ("/docs", "/v1/platforms", "/healthz"):
        assert "set-cookie" not in here.get(path).headers
