"""Flow 1: what a person clicks, types, pastes, drops or drags is what is planned."""

import re

import pytest
from browsing import ROOT, asked, box_of, planned, violations
from playwright.sync_api import expect

from app.requests.examples import LAS_VEGAS

OEM = (ROOT / "app/requests/examples/data/orbit.oem").read_text()
TLE = (
    "ISS (ZARYA)\n"
    "1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991\n"
    "2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964\n"
)


def windows_found(page):
    expect(page.get_by_role("list", name="Windows, the first first")).to_be_visible()
    return page.get_by_role("list", name="Windows, the first first").get_by_role("button")


@pytest.fixture
def ask(open_page):
    page = open_page()
    windows_found(page)
    return page


def test_the_packaged_example_is_planned_as_it_is(ask):
    errors: list[str] = []
    ask.on("console", lambda told: told.type == "error" and errors.append(told.text))
    assert planned(ask) == LAS_VEGAS | {"on_conflict": "refuse"}
    assert errors == []


def test_a_place_is_found_by_name_and_its_best_window_taken(ask):
    ask.get_by_label("Place or coordinates").fill("Ljubljana")
    ask.get_by_role("button", name="Find").click()
    expect(ask.get_by_text("GeoNames 3196359")).to_be_visible()
    expect(ask.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    expect(windows_found(ask).first).to_contain_text(re.compile(r"in frame \d+ %"))
    request = asked(ask)
    assert request["sessions"][0]["target"] == {"mode": "place", "name": "Ljubljana"}
    assert "epoch" not in request["initial_state"]  # it was of the example's times


def test_of_places_of_one_name_one_is_chosen(ask):
    ask.get_by_label("Place or coordinates").fill("Springfield")
    ask.get_by_role("button", name="Find").click()
    ask.get_by_role("button", name="Springfield, Ohio, US").click()
    expect(ask.get_by_text("Taken: Springfield")).to_be_visible()
    assert asked(ask)["sessions"][0]["target"]["name"] == "Springfield, Ohio, US"


def test_a_place_is_completed_as_it_is_typed_by_keys(ask):
    entry = ask.get_by_role("combobox", name="Place or coordinates")
    entry.fill("lond")
    options = ask.get_by_role("listbox", name="Places of this name").get_by_role("option")
    expect(options.first).to_contain_text("London, GB")
    expect(ask.get_by_text("8 names offered")).to_be_attached()
    assert violations(ask) == []
    entry.press("ArrowUp")
    expect(options.last).to_have_attribute("aria-selected", "true")
    entry.press("ArrowDown")
    expect(options.first).to_have_attribute("aria-selected", "true")
    assert entry.get_attribute("aria-activedescendant") == options.first.get_attribute("id")
    entry.press("Enter")
    expect(options).to_have_count(0)
    expect(entry).to_have_value("London, GB")
    expect(ask.get_by_text("GeoNames 2643743")).to_be_visible()
    entry.fill("lond")
    expect(options.first).to_be_visible()
    entry.press("Escape")
    expect(options).to_have_count(0)
    expect(entry).to_have_value("lond")


def test_a_star_is_completed_and_chosen_by_a_click(ask):
    ask.get_by_role("radio", name="Star").check()
    entry = ask.get_by_role("combobox", name="Star")
    entry.press_sequentially("veg")
    ask.get_by_role("option", name="Vega HIP 91262").click()
    expect(entry).to_have_value("Vega")
    expect(ask.get_by_text("Vega is Hipparcos 91262")).to_be_visible()
    expect(ask.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    assert asked(ask)["sessions"][0]["target"] == {"mode": "star", "name": "Vega"}


def test_a_click_on_the_map_is_a_target(ask):
    world = ask.get_by_role("application")
    box = box_of(world)
    # Flat, 360 degrees wide, 12 north in the middle.
    east_deg, north_deg = 15.0, 46.0
    scale = box["width"] / 360.0
    world.click(
        position={
            "x": box["width"] / 2 + east_deg * scale,
            "y": box["height"] / 2 - (north_deg - 12.0) * scale,
        }
    )
    entry = ask.get_by_label("Place or coordinates")
    expect(entry).not_to_have_value("36.1147, -115.1728, 610")
    latitude, longitude = (float(part) for part in entry.input_value().split(",")[:2])
    assert (latitude, longitude) == pytest.approx((north_deg, east_deg), abs=1.0 / scale)


def test_the_moon(ask):
    ask.get_by_role("radio", name="Sun, Moon, planet").check()
    ask.get_by_label("Body", exact=True).select_option("Moon")
    expect(ask.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    assert asked(ask)["sessions"][0]["target"] == {"mode": "body", "name": "moon"}


def test_a_pasted_tle(ask):
    ask.get_by_text("Orbit", exact=True).click()
    entry = ask.get_by_label("TLE, or a CCSDS OEM, OMM or OPM")
    entry.fill("no orbit")
    expect(ask.get_by_text("This is no orbit known here")).to_be_visible()
    entry.fill(TLE)
    expect(ask.get_by_text("This is no orbit known here")).to_be_hidden()
    expect(ask.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    assert asked(ask)["orbit"] == {"source": "tle", "content": TLE.strip()}


def test_a_dropped_oem(ask):
    ask.get_by_text("Orbit", exact=True).click()
    data = ask.evaluate_handle(
        "text => { const data = new DataTransfer();"
        " data.items.add(new File([text], 'orbit.oem')); return data; }",
        OEM,
    )
    entry = ask.get_by_label("TLE, or a CCSDS OEM, OMM or OPM")
    entry.dispatch_event("drop", {"dataTransfer": data})
    expect(ask.get_by_text("OEM ·")).to_be_visible()
    expect(ask.get_by_label("From, UTC")).to_have_value("2015-02-27T17:28")
    expect(ask.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    assert asked(ask)["orbit"]["source"] == "oem"


def test_a_session_is_dragged_and_moved_by_keys(ask):
    start = ask.get_by_role("slider", name="Start of the session")
    expect(start).to_have_attribute("aria-valuetext", "17:36:20 UTC")
    start.press("ArrowRight")
    expect(start).to_have_attribute("aria-valuetext", "17:36:21 UTC")
    start.press("Shift+ArrowLeft")
    expect(start).to_have_attribute("aria-valuetext", "17:36:11 UTC")
    box = box_of(start)
    ask.mouse.move(box["x"] + 7, box["y"] + 20)
    ask.mouse.down()
    ask.mouse.move(box["x"] + 107, box["y"] + 20, steps=5)
    ask.mouse.up()
    dragged = start.get_attribute("aria-valuetext")
    assert dragged > "17:36:30 UTC"
    request = asked(ask)
    assert request["sessions"][0]["start"] == f"2015-02-27T{dragged.removesuffix(' UTC')}Z"


def test_conflicting_sessions_show_what_each_way_out_gives_up(ask):
    end = ask.get_by_role("slider", name="End of the session")
    end.press("Home")
    for _ in range(2):
        end.press("PageUp")
    ended = end.get_attribute("aria-valuetext").removesuffix(" UTC")
    ask.get_by_role("button", name="Add a session").click()
    ask.get_by_label("Place or coordinates").fill("40.76, -111.89, 1288")
    with ask.expect_response(lambda answer: "40.76" in (answer.request.post_data or "")):
        ask.get_by_role("button", name="Find").click()
    expect(ask.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    windows_found(ask).first.click()
    # It was placed where the slew fits.
    ask.get_by_text("Session 2: exact times, name, keyhole").click()
    ask.get_by_label("Start, UTC").fill(f"2015-02-27T{ended}.200")
    ask.get_by_role("button", name="Plan").click()
    group = ask.get_by_role("group", name="What each way out gives up")
    expect(group.get_by_role("button")).to_have_count(3)
    expect(group).to_contain_text(re.compile(r"session \d loses [\d.]+ s"))
    assert violations(ask) == []
    group.get_by_role("button", name="Lose as little as possible").click()
    expect(ask.get_by_test_id("verdict")).to_contain_text("Passed")
    plan_id = ask.url.rsplit("/", 1)[1]
    request = ask.request.get(f"/v1/plans/{plan_id}/request").json()
    assert request["on_conflict"] == "least_loss"
    assert len(request["sessions"]) == 2


def test_searches_for_windows_are_not_left_behind(ask, service):
    def kept():
        return len(ask.request.get("/v1/opportunities?limit=100").json()["opportunities"])

    before = kept()
    for days in ("4", "5", "6"):
        with ask.expect_response(lambda answer: answer.request.method == "DELETE"):
            ask.get_by_label("Days").fill(days)
            ask.get_by_label("Days").press("Enter")
    assert kept() <= before  # the first search's may still have been there
