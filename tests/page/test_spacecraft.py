"""Flow 5: a session of the imaging spacecraft is asked for, followed, viewed and taken away."""

import json
import re
from pathlib import Path

import pytest
from browsing import PHONE, ROOT, fit_a_phone, made, violations
from playwright.sync_api import expect

FOUR_MODES = json.loads((ROOT / "examples/spacecraft_four_modes.json").read_text())
GEOJSON = ROOT / "examples/spacecraft_four_modes.geojson"
PATIENCE_MS = 180_000


@pytest.fixture(scope="module")
def session(service):
    """The answer to the example with a strip more, beyond the Earth's edge: left out."""
    elsewhere = {
        "mode": "strip",
        "name": "elsewhere",
        "geometry": {"type": "LineString", "coordinates": [[160.0, -20.0], [160.0, -20.5]]},
    }
    asked = FOUR_MODES | {"requests": [*FOUR_MODES["requests"], elsewhere]}
    return made(service, "/v1/spacecraft/plans", asked)


def planned(page):
    page.get_by_role("button", name="Plan the session").click()
    page.wait_for_url(re.compile(r"/spacecraft/plans/[0-9a-z-]+$"))


def test_a_kept_session_is_shown_with_what_is_left_out_and_taken_away(open_page, session):
    page = open_page(f"/spacecraft/plans/{session['id']}")
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    expect(page.get_by_test_id("session-imaged")).to_contain_text("4 of 5 requests imaged")
    margins = page.get_by_role("region", name="Margins").get_by_role("row")
    expect(margins.filter(has_text="torque 15 N·m")).to_have_count(1)
    [left_out] = session["left_out"]
    expect(page.get_by_role("region", name="Left out")).to_contain_text(left_out["reason"])
    looks = page.get_by_role("region", name="Looks").locator("tbody tr")
    expect(looks).to_have_count(len(session["windows"]))
    for chart in ("Rate in °/s", "Gimbal angles in °", "Momentum in N·m·s"):
        expect(page.get_by_role("img", name=f"{chart} over time")).to_be_visible()
    expect(page.get_by_role("img", name="Rate error while imaging")).to_be_visible()
    assert violations(page) == []
    # Time moves the momentum as it moves every plan.
    sphere = page.get_by_role("region", name="Momentum of the gyros")
    before = sphere.locator(".mono").inner_text()
    page.get_by_role("button", name="Closer look: strip").first.click()
    expect(sphere.locator(".mono")).not_to_have_text(before)
    with page.expect_download() as download:
        page.get_by_role("button", name="CCSDS AEM, payload's attitude", exact=True).click()
    assert Path(download.value.path()).read_bytes().startswith(b"CCSDS_AEM_VERS")
    taken = page.get_by_role("region", name="Take away")
    expect(taken).to_contain_text(f"/spacecraft/plans/{session['id']}")
    expect(taken).to_contain_text("client.spacecraft.plan(REQUEST)")
    page.set_viewport_size(PHONE)
    fit_a_phone(page)
    page.get_by_role("link", name="Fly it").click()
    expect(page).to_have_url(re.compile(rf"/flights\?plan={session['id']}"))


def test_what_is_drawn_on_the_map_is_asked_for(open_page):
    page = open_page("/spacecraft")
    world = page.get_by_role("application", name="Map: arrows move the cross")
    expect(world.locator(".asked-shape")).to_have_count(4)
    page.get_by_role("button", name="Remove all").click()
    page.get_by_label("Corridor", exact=True).check()
    world.focus()
    for key in ("Enter", "ArrowRight", "Enter", "ArrowUp", "Enter"):
        world.press(key)
    expect(page.get_by_text("3 set")).to_be_visible()
    page.get_by_role("button", name="Finish").click()
    asked = json.loads(page.get_by_label("Request as JSON").input_value())
    [corridor] = asked["requests"]
    assert (corridor["mode"], corridor["name"]) == ("corridor", "corridor")
    (west, _), (middle, _), (east, _) = corridor["geometry"]["coordinates"]
    assert west < middle == east
    assert asked["orbit"] == FOUR_MODES["orbit"]
    assert violations(page) == []


def test_dropped_geojson_is_planned_with_progress(open_page):
    page = open_page("/spacecraft")
    page.get_by_role("button", name="Remove all").click()
    page.get_by_label("Choose GeoJSON").set_input_files(GEOJSON)
    for name in ("stereo", "corridor", "area"):
        page.get_by_role("button", name=f"Remove {name}", exact=True).click()
    page.get_by_label("Closed-loop runs").fill("0")
    page.get_by_label("Closed-loop runs").press("Tab")
    planned(page)
    expect(page.get_by_test_id("session-imaged")).to_contain_text(
        "1 of 1 requests imaged", timeout=PATIENCE_MS
    )
    page.get_by_role("link", name="Change the request").click()
    expect(page.get_by_label("Closed-loop runs")).to_have_value("0")


def test_a_session_that_images_nothing_is_refused_in_words(open_page):
    page = open_page("/spacecraft")
    nowhere = FOUR_MODES | {
        "requests": [
            {
                "mode": "strip",
                "name": "elsewhere",
                "geometry": {"type": "LineString", "coordinates": [[160.0, -20.0], [160.0, -20.5]]},
            }
        ]
    }
    page.get_by_label("Request as JSON").fill(json.dumps(nowhere))
    planned(page)
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("requests.0", timeout=PATIENCE_MS)
    assert violations(page) == []
    page.get_by_role("link", name="Change the request").click()
    expect(page.get_by_role("rowheader", name="elsewhere")).to_be_visible()


def test_a_wrong_request_keeps_what_was_typed(open_page):
    page = open_page("/spacecraft")
    page.get_by_label("Request as JSON").fill("{")
    expect(page.get_by_text("JSON at position", exact=False)).to_be_visible()
    wrong = FOUR_MODES | {"stop": FOUR_MODES["start"]}
    page.get_by_label("Request as JSON").fill(json.dumps(wrong))
    page.get_by_role("button", name="Plan the session").click()
    expect(page.get_by_role("alert")).to_contain_text("10 to 3600 s")
    assert json.loads(page.get_by_label("Request as JSON").input_value()) == wrong


def test_a_pass_is_found_and_taken_for_the_session(open_page):
    page = open_page("/spacecraft")
    passes = page.get_by_role("region", name="When does it pass?")
    passes.get_by_label("Days").fill("1")
    passes.get_by_role("button", name="Find passes").click()
    first = passes.get_by_role("list").get_by_role("button").first
    # The example's session is of this pass: the service's own search has all four in it.
    expect(first).to_contain_text("sees 4 of 4")
    expect(passes.locator(".overview-bar").first).to_be_visible()
    assert violations(page) == []
    passes.locator(".overview-bar").last.click()
    last = passes.get_by_role("list").get_by_role("button").last
    expect(last).to_have_attribute("aria-pressed", "true")
    first.press("Enter")
    expect(first).to_have_attribute("aria-pressed", "true")
    asked = json.loads(page.get_by_label("Request as JSON").input_value())
    assert asked["start"] <= FOUR_MODES["start"] < asked["stop"]
    page.get_by_label("Closed-loop runs").fill("0")
    page.get_by_label("Closed-loop runs").press("Tab")
    planned(page)
    expect(page.get_by_test_id("session-imaged")).to_contain_text(
        "of 4 requests imaged", timeout=PATIENCE_MS
    )


def test_what_no_pass_shows_is_told(open_page):
    page = open_page("/spacecraft")
    wide = {  # 3,600 km across the track: more than the camera reaches on both sides
        "mode": "corridor",
        "name": "far apart",
        "geometry": {"type": "LineString", "coordinates": [[0.0, 0.0], [16.0, 0.0], [32.0, 0.0]]},
    }
    page.get_by_label("Request as JSON").fill(json.dumps(FOUR_MODES | {"requests": [wide]}))
    page.get_by_role("button", name="Find passes").click()
    passes = page.get_by_role("region", name="When does it pass?")
    expect(passes).to_contain_text("No pass in these days shows: far apart")
    page.get_by_label("Request as JSON").fill(json.dumps(FOUR_MODES))
    expect(passes).not_to_contain_text("No pass")
