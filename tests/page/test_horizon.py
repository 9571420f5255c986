"""Images of the horizon can be measured on the page, and checked against a plan."""

import json

from browsing import ROOT, made, violations
from other_body import PLATFORM
from playwright.sync_api import expect

FRAMES = [str(ROOT / f"examples/horizon_{name}.png") for name in ("ahead", "right")]


def test_dropped_images_give_verdict_ellipse_and_overlays(open_page):
    page = open_page("/horizon")
    measure = page.get_by_role("button", name="Measure the vertical")
    expect(measure).to_be_disabled()
    page.get_by_label("Choose images").set_input_files(FRAMES)
    measure.click()
    expect(page.get_by_test_id("horizon-verdict")).to_contain_text("Consistent")
    expect(page.get_by_role("img", name="Error ellipse of the nadir")).to_be_visible()
    for camera in ("ahead", "right"):
        overlay = page.get_by_alt_text(
            f"Limb points and the fitted limb in the image of camera {camera}"
        )
        expect(overlay).to_have_js_property("naturalWidth", 640)
    page.get_by_role("heading", name="As a correction for the next plan").click()
    assert "turn_body_deg" in json.loads(page.locator("details pre").inner_text())
    assert violations(page) == []


def test_the_plan_says_where_and_how_the_carrier_should_be(open_page, service):
    example = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())
    example["attitude"] = {"law": "lvlh", "yaw_deg": 0.0, "pitch_deg": 3.0, "roll_deg": 0.0}
    plan = made(service, "/v1/plans", example)["id"]
    page = open_page(f"/horizon?plan={plan}")
    page.get_by_role("button", name="Take the example's images").click()
    page.get_by_role("button", name="Take them from the plan").click()
    expect(page.get_by_text("predicted attitude are the plan's")).to_be_visible(timeout=60_000)
    page.get_by_role("button", name="Measure the vertical").click()
    expect(page.get_by_test_id("horizon-verdict")).to_contain_text("Not consistent")


def test_the_table_of_a_body_says_how_it_should_be_turned(open_page, service):
    """While it idles towards nadir, as the example's images were rendered."""
    request = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())
    del request["attitude"]
    target = {"mode": "ground", "latitude_deg": 41.0, "longitude_deg": -108.0}
    times = {"start": "2015-02-27T17:38:50Z", "stop": "2015-02-27T17:39:00Z"}
    request |= {
        "platform": PLATFORM,
        "initial_state": {"epoch": "2015-02-27T17:36:50Z"},
        "sessions": [{"target": target, **times}],
        "slew": {"lead": {"max_duration_s": 60.0}},
    }
    plan = made(service, "/v1/plans", request)["id"]
    page = open_page(f"/plans/{plan}")
    page.get_by_role("link", name="Check with horizon frames").click()
    page.get_by_role("button", name="Take the example's images").click()
    page.get_by_role("button", name="Take them from the plan").click()
    expect(page.get_by_text("predicted attitude are the plan's")).to_be_visible(timeout=60_000)
    asked = page.get_by_label("Request", exact=True)
    # 360 deg in 92.6 min against the stars, pitching down.
    rate_deg_s = json.loads(asked.input_value())["rate_body_deg_s"]
    assert [round(part, 3) for part in rate_deg_s] == [0.0, -0.065, 0.0]
    page.get_by_role("button", name="Measure the vertical").click()
    expect(page.get_by_test_id("horizon-verdict")).to_contain_text("Consistent")
    expect(page.get_by_text("correction for the next plan")).to_have_count(0)
    assert violations(page) == []
    asked.fill(asked.input_value().replace("17:37:00", "17:40:00"))
    expect(page.get_by_text("lies outside the plan")).to_contain_text("17:36:50–17:39:00 UTC")
    expect(page.get_by_role("button", name="Take them from the plan")).to_be_disabled()


def test_what_is_no_image_is_refused_in_words(open_page, tmp_path):
    page = open_page("/horizon")
    wrong = tmp_path / "notes.png"
    wrong.write_text("no image")
    page.get_by_label("Choose images").set_input_files([FRAMES[0], str(wrong)])
    page.get_by_role("button", name="Measure the vertical").click()
    expect(page.get_by_role("alert")).to_contain_text("images")
    page.get_by_label("Request", exact=True).fill("{")
    expect(page.get_by_text("JSON", exact=False).first).to_be_visible()
    expect(page.get_by_role("button", name="Measure the vertical")).to_be_disabled()
