"""The service answers with the planner's page at its addresses, and to those who may have it."""

import re
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.http import pages
from app.http.admission.access import PAGE_ROOMS
from app.http.app import create_app
from app.settings import Settings

_PUBLISHED = re.findall(
    r'"(?:node_modules|src)/\S+/(\S+)"',
    (Path(__file__).parents[2] / "web/vite.documentation.ts").read_text(),
)
_INDEX = '<!doctype html><base href="./"><title>slewtrack</title><div id="page"></div>'


@pytest.fixture
def built(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "BUILT", tmp_path / "page")
    assets = tmp_path / "page/assets"
    assets.mkdir(parents=True)
    (tmp_path / "page/index.html").write_text(_INDEX)
    (assets / "index-09TdYzx8.js").write_text("1;" * 1000)
    (assets / "worker.js").write_text("2")
    (assets / "documentation").mkdir()
    for name in _PUBLISHED:
        (assets / "documentation" / name).write_text("3")


@pytest.fixture
def not_built(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "BUILT", tmp_path / "page")


def client(**settings):
    return TestClient(create_app(Settings(**settings)))


def test_each_room_is_the_page_with_its_own_way_back_to_the_root(built):
    there = client()
    for path, base in {
        "/": "./",
        "/plans": "./",
        "/plans/7": "../",
        "/plans/7/x": "../../",
    }.items():
        answer = there.get(path)
        assert (answer.status_code, answer.headers["content-type"]) == (
            200,
            "text/html; charset=utf-8",
        )
        assert f'<base href="{base}">' in answer.text
        assert answer.headers["cache-control"] == "no-cache"
        again = there.get(path, headers={"If-None-Match": answer.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    assert there.head("/").status_code == 200
    assert there.get("/horizon?plan=7").status_code == 200


def test_its_policy_lets_nothing_inline_run(built):
    there = client()
    for path in ("/", "/assets/worker.js"):
        policy = there.get(path).headers["content-security-policy"]
        assert "unsafe-inline" not in policy
        assert "'unsafe-eval'" not in policy
        assert "script-src 'self' 'wasm-unsafe-eval'" in policy


def test_files_named_after_their_content_are_kept_for_good(built):
    there = client()
    named = there.get("/assets/index-09TdYzx8.js")
    assert re.search("immutable", named.headers["cache-control"])
    assert there.get("/assets/worker.js").headers["cache-control"] == "no-cache"
    assert there.get("/assets/missing.js").status_code == 404


def test_the_page_needs_no_key_but_what_it_asks_does(built):
    there = client(require_keys=True)
    for path in ("/", *(f"/{room}" for room in PAGE_ROOMS), "/plans/7", "/assets/worker.js"):
        assert there.get(path).status_code == 200
    assert there.get("/v1/plans").status_code == 401
    assert there.post("/plans").status_code in (401, 405)


def test_programs_are_told_where_the_schema_is(built):
    told = client().get("/", headers={"Accept": "application/json"}).json()
    assert told == {"page": "built", "documentation": "docs", "openapi": "openapi.json"}


def test_where_it_is_not_built_it_says_how(not_built):
    there = client()
    page = there.get("/")
    assert "make web" in page.text
    assert 'href="openapi.json"' in page.text
    assert "make web" in there.get("/", headers={"Accept": "application/json"}).json()["page"]
    room = there.get("/plans/7")
    assert room.status_code == 404
    assert room.headers["content-type"] == "application/problem+json"
    assert "make web" in room.json()["detail"]
    assert there.get("/plans/7/x").json()["status"] == 404
    for path in ("/docs", "/redoc"):
        assert there.get(path).text == page.text


@pytest.mark.parametrize("path", ["/docs", "/redoc"])
def test_the_pages_of_the_api_need_no_other_machine(built, path):
    there = client(require_keys=True)
    page = there.get(path)
    named = re.findall(r"""(?:src|href)=["']([^"']+)["']""", page.text)
    assert len(named) >= 4
    for address in named:
        assert ":" not in address, f"{path} would fetch {address}"
        assert there.get(f"/{address}").status_code == 200
    assert not re.search(r"https?://", page.text), f"{path} names another machine"
    assert "script-src 'self';" in page.headers["content-security-policy"]
