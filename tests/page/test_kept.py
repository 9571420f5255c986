"""Kept plans can be found, compared, cancelled and deleted on the page."""

import json

import httpx
import pytest
from browsing import ROOT, long_campaign, made, violations
from playwright.sync_api import expect

EXAMPLE = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())


@pytest.fixture(scope="module")
def plans(service) -> tuple[str, str]:
    """A plan and the one that replaces it, ten seconds shorter: their ids."""
    shorter = json.loads(json.dumps(EXAMPLE))
    stop = shorter["sessions"][0]["stop"]
    shorter["sessions"][0]["stop"] = stop.replace(stop[17:19], f"{int(stop[17:19]) - 10:02d}")
    first = made(service, "/v1/plans", EXAMPLE | {"name": "Vegas, kept"})["id"]
    second = made(service, "/v1/plans", shorter | {"name": "Vegas, kept"}, revises=first)["id"]
    return first, second


def test_plans_are_found_and_two_revisions_compared(open_page, plans):
    page = open_page("/plans")
    page.get_by_label("Search").fill("vegas, kept")
    rows = page.locator("tbody tr").filter(has_text="Vegas, kept")
    expect(rows).to_have_count(2)
    assert violations(page) == []
    page.get_by_role("link", name="compare with the one it replaces").click()
    expect(page.get_by_role("row", name="Session 1, stop")).to_contain_text("differs")
    expect(page.get_by_role("row", name="Platform")).not_to_contain_text("differs")
    assert violations(page) == []

    # Any two are chosen to compare.
    page.goto("/plans")
    page.get_by_label("Search").fill("vegas, kept")
    boxes = page.get_by_role("checkbox", name="Choose Vegas, kept")
    expect(boxes).to_have_count(2)
    boxes.nth(0).check()
    boxes.nth(1).check()
    page.get_by_role("link", name="Compare these two").click()
    expect(page.get_by_role("heading", name="Side by side")).to_be_visible()
    expect(page.get_by_text("figures of")).to_be_visible()


def test_what_is_deleted_is_gone_only_after_asking(open_page, service):
    path = f"/v1/plans/{made(service, '/v1/plans', EXAMPLE | {'name': 'Not to be kept'})['id']}"
    with httpx.Client(base_url=service.address, timeout=60.0) as client:
        page = open_page("/plans")
        page.get_by_role("button", name="Delete Not to be kept").click()
        page.get_by_role("button", name="Keep it").click()
        assert client.get(path).status_code == 200
        page.get_by_role("button", name="Delete Not to be kept").click()
        dialog = page.get_by_role("dialog")
        assert violations(page) == []
        dialog.get_by_role("button", name="Delete").click()
        expect(page.get_by_role("link", name="Not to be kept")).to_have_count(0)
        assert client.get(path).status_code == 404


def test_work_shows_its_progress_and_can_be_cancelled(open_page, service):
    long_campaign(service, "Long work to cancel")
    page = open_page("/plans")
    page.get_by_label("Show", exact=True).select_option("campaigns")
    row = page.locator("tbody tr").filter(has_text="Long work to cancel")
    expect(row.get_by_role("progressbar")).to_be_visible()
    row.get_by_role("button", name="Cancel Long work to cancel").click()
    expect(row).to_contain_text("cancelled")
    expect(row.get_by_role("button", name="Delete Long work to cancel")).to_be_visible()


def test_a_lost_connection_is_told_and_recovered_from(open_page, plans):
    page = open_page("/plans")
    page.route("**/v1/plans?*", lambda route: route.abort())
    page.get_by_role("button", name="Reload").click()
    expect(page.get_by_role("alert")).to_contain_text("doesn't answer")
    page.unroute("**/v1/plans?*")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_role("alert")).to_have_count(0)
