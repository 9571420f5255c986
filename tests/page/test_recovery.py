"""Is what goes wrong shown as what it is, and recovered from?"""

import json
import os
from contextlib import closing

import pytest
from browsing import violations
from live_service import live_service
from playwright.sync_api import expect

from app.store.database import open_database
from app.store.keys import KeyStore

TOO_MANY = {
    "type": "about:blank", "title": "Too Many Requests", "status": 429,
    "detail": "60 requests a minute may come", "instance": "urn:uuid:0",
}  # fmt: skip


def plan(page):
    page.get_by_role("button", name="Plan").click()


def test_a_lost_connection_is_told_and_the_form_kept(open_page):
    page = open_page()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    page.context.set_offline(True)
    plan(page)
    expect(page.get_by_role("alert")).to_contain_text("The service doesn't answer")
    assert violations(page) == []
    page.context.set_offline(False)
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")


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


def test_too_many_requests_are_waited_for(open_page):
    page = open_page()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    refusals = iter([TOO_MANY])

    def refuse_once(route):
        refusal = next(refusals, None)
        if refusal is None:
            route.continue_()
        else:
            route.fulfill(
                status=429,
                headers={"Content-Type": "application/problem+json", "Retry-After": "2"},
                body=json.dumps(refusal),
            )

    page.route("**/v1/plans", refuse_once)
    plan(page)
    expect(page.get_by_text("The service is busy; the next try is in")).to_be_visible()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")


def test_a_full_store_is_told_in_its_own_words(open_page):
    page = open_page()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    detail = "the store is full"
    full = TOO_MANY | {"status": 503, "title": "Service Unavailable", "detail": detail}
    page.route(
        "**/v1/plans",
        lambda route: route.fulfill(
            status=503,
            headers={"Content-Type": "application/problem+json", "Retry-After": "60"},
            body=json.dumps(full),
        ),
    )
    plan(page)
    expect(page.get_by_role("alert")).to_contain_text(detail)
    page.unroute("**/v1/plans")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")


@pytest.mark.parametrize(
    ("end", "told"),
    [({"state": "failed", "problem": TOO_MANY | {"status": 500, "detail": "the solver broke"}},
      "the solver broke"),
     ({"state": "refused", "problem": TOO_MANY | {"status": 422, "detail": "no way there"}},
      "no way there")],
)  # fmt: skip
def test_a_job_that_ends_badly_says_why(open_page, end, told):
    page = open_page()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    events = f"event: state\ndata: {json.dumps(end)}\nid: 1\n\n"
    page.route(
        "**/v1/plans/*/events",
        lambda route: route.fulfill(headers={"Content-Type": "text/event-stream"}, body=events),
    )
    plan(page)
    expect(page.get_by_role("alert")).to_contain_text(told)


def test_progress_is_told_and_the_work_cancelled(open_page):
    page = open_page()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    progress = {"stage": "slews and tracks", "done": 1, "of": 3, "percent": 40}
    cancelled = json.dumps({"state": "cancelled"})
    parts = [
        f"event: progress\ndata: {json.dumps(progress)}\nid: 1\n\n",
        f"event: state\ndata: {cancelled}\nid: 2\n\n",
    ]
    deleted = []

    def events(route):
        # The end is told only once it was asked for; a stream that breaks off is resumed.
        body = parts[1] if deleted else parts[0]
        route.fulfill(headers={"Content-Type": "text/event-stream"}, body=body)

    page.route("**/v1/plans/*/events", events)
    page.route(
        "**/v1/plans/*",
        lambda route: (
            route.continue_()
            if route.request.method != "DELETE"
            else (deleted.append(route.request.url), route.fulfill(status=204))
        ),
    )
    plan(page)
    expect(page.get_by_role("progressbar", name="slews and tracks")).to_have_attribute(
        "value", "40"
    )
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("progressbar")).to_be_hidden()
    expect(page.get_by_role("button", name="Plan")).to_be_enabled()
    assert len(deleted) == 1


def test_a_plan_that_is_gone(open_page):
    page = open_page("/plans/0190b7a5-0000-7000-8000-000000000000")
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
