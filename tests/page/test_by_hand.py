"""From an empty page to a sheet that somebody can sign, for one's own city, by names alone."""

import re

from playwright.sync_api import expect


def test_a_sheet_for_ones_own_city(open_page):
    """By the name that its people or others give it; which names are found, the API's tests ask."""
    page = open_page(globe=True)
    errors: list[str] = []
    page.on("console", lambda told: told.type == "error" and errors.append(told.text))
    entry = page.get_by_role("combobox", name="Place or coordinates")
    entry.fill("Лонд")
    page.get_by_role("option", name=re.compile("London")).first.click()
    expect(page.get_by_role("list", name="Windows, the first first")).to_be_visible()
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    page.get_by_role("button", name="Plan", exact=True).click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    identity = page.get_by_test_id("identity")
    for part in ("Feb 2015", "UTC", "iss-hrc", "TLE of 27 Feb 2015", "SHA-256"):
        expect(identity).to_contain_text(part)
    expect(page).to_have_title(re.compile("London"))
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    expect(page.locator(".signed")).to_contain_text("Approved, date and signature")
    assert page.pdf(format="A4").startswith(b"%PDF")
    assert errors == []
