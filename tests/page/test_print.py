"""Flow 4: a plan is printed on one page, light, with nothing that only a screen needs."""

import re

import pytest
from browsing import made
from playwright.sync_api import expect

from app.requests.examples import LAS_VEGAS

PLACES = [(36.1, -115.2), (38.6, -109.6), (40.8, -96.7), (41.9, -87.6), (42.3, -83.0)]


def several_sessions():
    """Five within one pass over North America, as the ISS goes east."""
    [session] = LAS_VEGAS["sessions"]
    request = {name: value for name, value in LAS_VEGAS.items() if name != "initial_state"}
    sessions = [
        session
        | {
            "name": f"Place {number + 1}",
            "target": {"mode": "ground", "latitude_deg": latitude, "longitude_deg": longitude},
            "start": f"2015-02-27T17:{37 + (70 * number) // 60}:{(70 * number) % 60:02d}Z",
            "stop": f"2015-02-27T17:{37 + (70 * number + 20) // 60}:{(70 * number + 20) % 60:02d}Z",
        }
        for number, (latitude, longitude) in enumerate(PLACES)
    ]
    return request | {"name": "Five places", "sessions": sessions}


@pytest.fixture(scope="module")
def plans(service):
    """Ids of a plan of one session, and of one of several."""
    requests = {"one": LAS_VEGAS, "several": several_sessions()}
    return {name: made(service, "/v1/plans", asked)["id"] for name, asked in requests.items()}


def pages_of(pdf):
    return int(re.search(rb"/Type /Pages\s*/Count (\d+)", pdf)[1])


@pytest.mark.parametrize(
    ("name", "language", "theme"),
    [("one", "en-GB", "dark"), ("several", "en-GB", "light"), ("several", "ru-RU", "dark")],
)
def test_a_plan_is_printed_on_one_page(open_page, plans, name, language, theme):
    page = open_page(
        f"/plans/{plans[name]}", locale=language, color_scheme=theme, globe=name == "one"
    )
    expect(page.locator(".look-charts canvas").first).to_be_visible()
    verdict = page.get_by_test_id("verdict").inner_text()
    # The pictures are drawn for paper only, when the browser says that it prints.
    page.evaluate(
        """addEventListener("beforeprint", () => {
          window.drawn = document.querySelectorAll(".sheet-charts .plane").length;
        })"""
    )
    for paper in ("A4", "Letter"):
        page.evaluate("window.drawn = 0")
        assert pages_of(page.pdf(format=paper, print_background=True)) == 1
        assert page.evaluate("window.drawn") == 4
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    expect(page.locator(".sheet-charts .plane")).to_have_count(4)
    for picture in page.locator(".sheet svg").all():
        expect(picture).to_be_visible()
    expect(page.locator(".one button:visible, .one a:visible, header:visible")).to_have_count(0)
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(23, 33, 46)"
    assert page.evaluate("getComputedStyle(document.documentElement).backgroundColor") == (
        "rgb(255, 255, 255)"
    )
    margins = page.evaluate(
        "document.adoptedStyleSheets.map(one => [...one.cssRules].map(rule => rule.cssText)).join()"
    )
    identity = page.get_by_test_id("identity").text_content()
    for part in (plans[name], "27", "2015", "iss-hrc", "LVLH -4/-2/1", "SHA-256"):
        assert part in margins
        assert part in identity
    expect(page.locator(".signed")).to_be_visible()
    assert ("Planned" if language == "en-GB" else "Запланировано") in margins
    assert ("Approved" if language == "en-GB" else "Утверждено") in margins
    for picture in page.locator(".sheet-charts .plane").all():
        levels = picture.locator("text[text-anchor=end]").all_text_contents()
        assert len(set(levels)) > 1
    shown = page.locator(".one").inner_text()
    assert verdict in shown
    for session in ("Las Vegas",) if name == "one" else [f"Place {k + 1}" for k in range(5)]:
        assert session in shown
