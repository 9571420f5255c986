"""Short breaks, plans that are gone, API keys: reported and recovered from."""

import os
from contextlib import closing

from browsing import violations
from live_service import live_service
from playwright.sync_api import expect

from app.store.database import open_database
from app.store.keys import KeyStore


def plan(page):
    page.get_by_role("button", name="Plan").click()


def test_a_short_break_is_bridged_without_a_second_plan(open_page):
    page = open_page()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    asked = []

    def break_first(route):
        asked.append(route.request.headers["idempotency-key"])
        if len(asked) == 1:
            route.abort("connectionreset")
        else:
            route.continue_()

    page.route("**/v1/plans", break_first)
    plan(page)
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    assert len(asked) == 2
    assert len(set(asked)) == 1


def test_an_address_that_is_no_text_or_of_a_plan_that_is_gone_is_told(open_page):
    page = open_page()
    for path in ("/plans/%", "/plans/%ff", "/campaigns/%e0%a4"):
        page.goto(path)
        expect(page.get_by_text("There is nothing at this address.")).to_be_visible()
    assert violations(page) == []
    page.goto("/plans/0190b7a5-0000-7000-8000-000000000000")
    expect(page.get_by_text("There is no such plan")).to_be_visible()
    assert violations(page) == []


def test_a_key_is_asked_for_and_kept_in_memory_only(open_page, tmp_path):
    with live_service(tmp_path, SLEWTRACK_REQUIRE_KEYS="true") as guarded:
        with closing(open_database(os.environ["SLEWTRACK_DATABASE_URL"], tmp_path)) as database:
            _, secret = KeyStore(database).create("page", ["write"])
        page = open_page("/", at=guarded)
        dialog = page.get_by_role("dialog", name="This service asks for an API key")
        expect(dialog).to_be_visible()
        assert violations(page) == []
        dialog.get_by_label("API key").fill("slewtrack_wrong")
        dialog.get_by_role("button", name="Use this key").click()
        expect(dialog).to_contain_text("doesn't know this key")
        dialog.get_by_label("API key").fill(secret)
        dialog.get_by_role("button", name="Use this key").click()
        expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
        plan(page)
        expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
        with page.expect_download() as download:
            page.get_by_role("button", name="Download CSV").click()
        assert download.value.suggested_filename.endswith(".csv")
        stored = page.evaluate("JSON.stringify([localStorage, sessionStorage, document.cookie])")
        assert secret not in stored
        page.close()
