"""The timeline shows the days of everybody's plans, what gets in whose way, and takes it away."""

import json
import re
from pathlib import Path

import pytest
from browsing import PHONE, ROOT, box_of, fit_a_phone, made, violations
from live_service import live_service
from playwright.sync_api import Page, expect
from waiting import eventually

from app.requests.examples import OPPORTUNITY_EXAMPLES, PLAN_EXAMPLES

EXAMPLE = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())
DAY = "/timeline?from=2015-02-27T12:00:00Z&to=2015-02-28T00:00:00Z"


@pytest.fixture(scope="module")
def kept(browser, tmp_path_factory):
    """A service of its own: a plan, one in its way, a revision of it, another satellite."""
    with live_service(tmp_path_factory.mktemp("timeline")) as service:
        first = made(service, "/v1/plans", EXAMPLE | {"name": "Las Vegas"})
        made(service, "/v1/plans", EXAMPLE | {"name": "Las Vegas again"}, revises=first["id"])
        made(service, "/v1/plans", PLAN_EXAMPLES["star"][1] | {"name": "Vega"})
        state = PLAN_EXAMPLES["state"][1]
        made(service, "/v1/plans", state | {"name": "another satellite"})
        yield service


@pytest.fixture
def windows(kept, open_page):
    page = open_page("/healthz", at=kept)
    cities = OPPORTUNITY_EXAMPLES["cities"][1] | {"name": "cities"}
    answer = page.request.post("/v1/opportunities?include=view", data=cities)
    assert answer.ok
    yield answer.json()["windows"]
    page.request.delete(f"/v1/opportunities/{answer.json()['id']}")


def span_of(page: Page) -> tuple[float, float]:
    lanes = page.locator(".lanes")
    return tuple(float(lanes.get_attribute(f"data-{end}")) for end in ("from", "to"))


def test_everything_kept_has_its_lane_and_its_link(kept, windows, open_page):
    page = open_page(DAY, at=kept)
    expect(page.get_by_role("heading", name="iss-hrc, NORAD 25544")).to_be_visible()
    expect(page.get_by_role("heading", name="Windows: cities")).to_be_visible()
    las_vegas = next(one for one in windows if one["target"] == "Las Vegas")
    shown = page.get_by_role("listitem").filter(has_text="Window of Las Vegas")
    expect(shown.first).to_contain_text(f"up to {las_vegas['highest_deg']:.0f}° elevation")
    # Each of two carriers is in the shadow for a third of each turn.
    expect(page.locator(".shadow").nth(15)).to_be_visible()
    assert violations(page) == []
    page.get_by_role("link", name="Vega, iss-hrc").first.click()
    expect(page.get_by_role("heading", name="Vega", level=1)).to_be_visible()


def test_a_day_has_its_shadows_conflicts_and_ground_track(kept, open_page):
    """Shadow is what the service computes; plans in each other's way are named."""
    page = open_page(DAY, at=kept)
    expect(page.locator(".shadow").first).to_be_visible()
    span = {"start": "2015-02-27T00:00:00Z", "stop": "2015-02-28T00:00:00Z"}
    orbit = page.request.post("/v1/orbits/tracks", data={"orbit": EXAMPLE["orbit"], **span})
    eclipses = orbit.json()["eclipses"]
    told = page.locator(".shadow").evaluate_all("all => all.map(one => one.title)")
    first = next(one for one in eclipses if one["stop"] > "2015-02-27T12:00:00")
    assert told[0].endswith(f"{first['stop'][11:19]} UTC") or first["stop"][11:19] in told[0]
    conflicts = page.get_by_role("region", name="Conflicts: 1")
    expect(conflicts.get_by_role("listitem")).to_have_text(
        "Las Vegas again and Vega: both command iss-hrc, NORAD 25544, "
        "27 Feb 2015 17:34:00–17:37:50 UTC"
    )
    block = page.get_by_role("link", name=re.compile("^Las Vegas again, .*conflicts with Vega"))
    expect(block).to_be_visible()
    expect(page.get_by_role("link", name=re.compile("^Las Vegas, .*replaced"))).to_be_visible()
    ground = page.get_by_role("region", name="Ground track")
    expect(ground.get_by_text("Las Vegas again")).to_be_visible()
    for drawn in (".dm-track", ".map-night", ".dm-swath"):
        expect(ground.locator(drawn)).to_have_attribute("d", re.compile("^M"))
    page.get_by_label("Lanes by").select_option("owner")
    expect(page.get_by_role("heading", name="without a key")).to_be_visible()


def test_keys_and_wheel_zoom_and_a_drag_moves(kept, open_page):
    page = open_page(DAY, at=kept)
    lanes = page.locator(".lanes")
    expect(page.get_by_role("link", name="Vega, iss-hrc").first).to_be_visible()
    begin = span_of(page)
    lanes.focus()
    page.keyboard.press("+")
    closer = span_of(page)
    assert closer[1] - closer[0] == pytest.approx((begin[1] - begin[0]) / 1.6)
    assert sum(closer) == pytest.approx(sum(begin))
    page.keyboard.press("ArrowRight")
    assert span_of(page)[0] == pytest.approx(closer[0] + 0.1 * (closer[1] - closer[0]))
    page.keyboard.press("-")
    lanes.hover(position={"x": 300, "y": 8})
    before = span_of(page)
    page.mouse.wheel(0, -100)
    eventually(lambda: span_of(page)[1] - span_of(page)[0] < 0.9 * (before[1] - before[0]))
    before = span_of(page)
    box = box_of(lanes)
    page.mouse.move(box["x"] + 300, box["y"] + 8)
    page.mouse.down()
    page.mouse.move(box["x"] + 100, box["y"] + 8, steps=5)
    page.mouse.up()
    shift = 200 / box["width"] * (before[1] - before[0])
    eventually(lambda: span_of(page)[0] == pytest.approx(before[0] + shift, rel=1e-6))
    # The address holds it, so that a reload shows the same.
    eventually(lambda: "to=" in page.url and DAY not in page.url)
    now = span_of(page)
    page.reload()
    expect(lanes).to_be_visible()
    assert span_of(page) == pytest.approx(now, abs=1000)


def test_a_drag_over_a_plan_does_not_open_it(kept, open_page):
    page = open_page("/timeline?from=2015-02-27T17:30:00Z&to=2015-02-27T17:45:00Z", at=kept)
    block = page.get_by_role("link", name="Vega, iss-hrc").first
    expect(block).to_be_visible()
    box = box_of(block)
    page.mouse.move(box["x"] + 40, box["y"] + 8)
    page.mouse.down()
    page.mouse.move(box["x"] + 140, box["y"] + 8, steps=5)
    page.mouse.up()
    assert "/timeline" in page.url
    expect(page.locator(".part-slew").first).to_be_visible()


def test_without_a_time_it_begins_with_the_latest_plan_and_all_shows_all(kept, open_page):
    page = open_page("/timeline", at=kept)
    expect(page.get_by_role("link", name=re.compile("^another satellite, "))).to_be_visible()
    from_ms, to_ms = span_of(page)
    assert to_ms - from_ms == 86_400_000
    page.get_by_role("button", name="All that is kept").click()
    for name in ("Vega", "another satellite"):
        expect(page.get_by_role("link", name=re.compile(f"^{name}, "))).to_be_visible()
    page.goto(DAY.replace("2015", "2014"))
    expect(page.get_by_text("Nothing is kept for this time.")).to_be_visible()


def test_the_calendar_holds_sessions_windows_and_shadow(kept, windows, open_page):
    page = open_page(DAY, at=kept)
    expect(page.locator(".shadow").first).to_be_visible()
    with page.expect_download() as download:
        page.get_by_role("button", name="Calendar of all shown").click()
    assert download.value.suggested_filename == "slewtrack_2015-02-27_2015-02-28.ics"
    calendar = Path(download.value.path()).read_bytes()
    assert max(map(len, calendar.split(b"\r\n"))) <= 75
    text = calendar.decode().replace("\r\n ", "")
    plans = page.request.get("/v1/plans?after=2015-02-27T12:00:00Z&before=2015-02-28T00:00:00Z")
    for plan in plans.json()["plans"]:
        own = page.request.get(f"/v1/plans/{plan['id']}/table?format=ics").text()
        [uid] = re.findall(r"UID:\S+", own)
        assert uid in text  # taken in twice, a session stands there once
    assert "SUMMARY:window: Las Vegas" in text
    assert text.count("SUMMARY:Earth's shadow") >= 8
    assert text.count("BEGIN:VEVENT") == text.count("END:VEVENT") == len(re.findall(r"UID:", text))


def test_russian_on_a_phone_in_the_dark(kept, open_page):
    page = open_page(DAY, at=kept, viewport=PHONE, locale="ru-RU", color_scheme="dark")
    expect(page.get_by_role("heading", name="Шкала времени")).to_be_visible()
    expect(page.get_by_role("region", name="Конфликтов: 1")).to_be_visible()
    fit_a_phone(page)
    assert violations(page) == []


def test_a_window_is_a_link_to_its_plan(kept, windows, open_page):
    page = open_page(DAY, at=kept)
    link = page.get_by_role("link", name=re.compile("Window of Las Vegas.*plan it")).first
    expect(link).to_be_visible()
    link.focus()
    page.keyboard.press("Enter")
    taken = page.get_by_role("button", name=re.compile(r"27 Feb 2015 17:36.* 84°"), pressed=True)
    expect(taken).to_be_visible()
    page.get_by_role("button", name="Plan", exact=True).click()
    expect(page.get_by_role("heading", name="Las Vegas", level=1)).to_be_visible(timeout=30_000)


def test_of_an_ephemeris_only_what_it_covers_is_asked_for(browser, tmp_path, open_page):
    with live_service(tmp_path) as service:
        made(service, "/v1/plans", PLAN_EXAMPLES["oem"][1] | {"name": "by an ephemeris"})
        page = open_page("/healthz", at=service)
        refused = []
        page.on("response", lambda got: got.status >= 400 and refused.append(got.url))
        page.goto(f"{service.address}{DAY}")
        told = "covers only 27 Feb 2015 17:28:00–17:44:00 UTC of this time"
        expect(page.get_by_text(told)).to_be_visible()
        track = page.get_by_role("region", name="Ground track").locator(".dm-track")
        expect(track).to_have_attribute("d", re.compile("^M"))
        expect(page.get_by_text("No ground track")).to_have_count(0)
        page.goto(f"{service.address}{DAY.replace('2015-02-27', '2015-02-26')}")
        page.get_by_role("button", name="A week").click()
        expect(page.get_by_text("covers only")).to_be_visible()
        assert refused == []
        page.close()
