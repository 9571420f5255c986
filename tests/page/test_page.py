"""The page opens, in every room, and everyone can use it."""

import re

import pytest
from browsing import PHONE, ROOT, fit_a_phone, violations
from playwright.sync_api import expect

from app.http.admission.access import PAGE_ROOMS

ROOMS = re.findall(r'path: "(/[^":]*)"', (ROOT / "web/src/rooms.ts").read_text())


def test_every_room_has_an_address_that_the_service_knows():
    paths = re.findall(r'path: "(/[^"]*)"', (ROOT / "web/src/rooms.ts").read_text())
    assert paths
    assert {path.split("/")[1] for path in paths} - {""} <= PAGE_ROOMS


@pytest.mark.parametrize("path", ROOMS)
def test_each_room_opens_and_is_accessible(open_page, path):
    """By day and by night, and on a phone nothing is wider than that."""
    page = open_page(path, color_scheme="light")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    assert violations(page) == []
    page.emulate_media(color_scheme="dark")
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    fit_a_phone(page)


def test_russian_stays_chosen(open_page):
    page = open_page("/plans")
    page.get_by_label("Language").select_option("ru")
    expect(page.get_by_role("heading", level=1)).to_have_text("Сохранённое")
    page.reload()
    expect(page.get_by_role("heading", level=1)).to_have_text("Сохранённое")
    assert page.evaluate("document.documentElement.lang") == "ru"


def test_what_is_loaded_before_the_globe_is_small(open_page, service):
    page = open_page("/plans")
    session = page.context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Network.setCacheDisabled", {"cacheDisabled": True})
    sizes = []
    session.on("Network.loadingFinished", lambda event: sizes.append(event["encodedDataLength"]))
    page.goto("/")
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    assert 30_000 < sum(sizes) < 300_000
