"""Rooms lead on: from a plan to flights, telemetry and horizon frames, from these to the next."""

import csv
import json
from pathlib import Path

from browsing import PHONE, ROOT, fit_a_phone, show_one_instant, violations
from playwright.sync_api import expect
from test_flown import telemetry

NAMED = "Las Vegas, 27 Feb 2015 17:36:20–17:37:50 UTC"
FRAMES = [str(ROOT / f"examples/horizon_{name}.png") for name in ("ahead", "right")]


def plan_field(page):
    return page.get_by_role("combobox", name="Plan", exact=True)


def next_request(page):
    """The request that the form sends."""
    with page.expect_request(lambda one: one.method == "POST" and "/v1/plans" in one.url) as sent:
        page.get_by_role("button", name="Plan", exact=True).click()
    return json.loads(sent.value.post_data)


def test_a_plan_leads_to_its_files_and_to_each_room_that_knows_it_by_name(open_page, plan):
    page = open_page(f"/plans/{plan}")
    for button, room in (
        ("Fly it many times", "Flights"),
        ("Compare telemetry", "Telemetry"),
        ("Check with horizon frames", "Horizon"),
    ):
        page.get_by_role("navigation", name="From here").get_by_role("link", name=button).click()
        expect(page.get_by_role("heading", name=room, exact=True)).to_be_visible()
        expect(plan_field(page)).to_have_value(NAMED)
        assert violations(page) == []
        page.go_back()
    page.set_viewport_size(PHONE)
    page.get_by_role("button", name="Export").click()
    expect(page.get_by_role("region", name="Take away")).to_be_in_viewport()
    fit_a_phone(page)


def test_plans_are_offered_by_name_where_one_is_to_be_chosen(open_page, plan):
    page = open_page("/telemetry")
    plan_field(page).click()
    page.get_by_role("option", name=NAMED).first.click()
    expect(page.get_by_text("The target in images")).to_be_visible()
    expect(plan_field(page)).to_have_value(NAMED)


def test_what_images_teach_goes_into_the_next_request(open_page, service, plan, tmp_path):
    file = tmp_path / "flight.csv"
    file.write_bytes(telemetry(service, plan, 0.37))
    page = open_page(f"/telemetry?plan={plan}")
    page.get_by_label("Telemetry, CSV").set_input_files(str(file))
    page.get_by_role("button", name="Add a frame").click()
    page.get_by_label("First side, °").fill("0.12")
    page.get_by_role("button", name="Compare", exact=True).click()
    expect(page.get_by_test_id("identity")).to_contain_text(plan)
    page.get_by_text("As attitude.corrections of a request").click()
    [learnt] = json.loads(
        page.get_by_role("region", name="For the next plan").locator("pre").inner_text()
    )
    page.get_by_role("button", name="Take the correction into the next request").click()
    assert next_request(page)["attitude"]["corrections"] == [learnt]


def test_a_vertical_that_differs_goes_into_the_next_request(open_page, plan):
    page = open_page(f"/horizon?plan={plan}")
    page.get_by_label("Choose images").set_input_files(FRAMES)
    page.get_by_role("button", name="Take them from the plan").click()
    expect(page.get_by_text("predicted attitude are the plan's")).to_be_visible()
    page.get_by_role("button", name="Measure the vertical").click()
    identity = page.get_by_test_id("identity")
    for part in ("2015-02-27 17:37:00 UTC", "ahead, right", plan, "SHA-256"):
        expect(identity).to_contain_text(part)
    page.get_by_role("heading", name="As a correction for the next plan").click()
    learnt = json.loads(page.locator("details pre").inner_text())
    page.get_by_role("button", name="Take the correction into the next request").click()
    assert next_request(page)["attitude"]["corrections"] == [learnt]


def test_the_flight_is_a_chart_with_a_cursor_and_files(open_page, service, plan, tmp_path):
    file = tmp_path / "flight.csv"
    file.write_bytes(telemetry(service, plan, 0.37))
    page = open_page(f"/telemetry?plan={plan}")
    page.get_by_label("Telemetry, CSV").set_input_files(str(file))
    page.get_by_role("button", name="Compare", exact=True).click()
    expect(page.get_by_role("img", name="alpha, planned and flown")).to_be_visible()
    expect(page.get_by_text("left out: no_time")).to_be_visible()
    flight = page.get_by_role("region", name="Plan and flight over time")
    now = flight.get_by_test_id("flight-now")
    expect(now).to_contain_text("alpha: flown 0.0000°")
    slider = flight.get_by_role("slider")
    slider.press("End")
    expect(now).not_to_contain_text("alpha: flown 0.0000°")
    show_one_instant(flight.locator(".chart-now"), 4)
    expect(page.get_by_text("-0.0000")).to_have_count(0)
    with page.expect_download() as download:
        page.get_by_role("button", name="Samples, CSV").click()
    assert download.value.suggested_filename.startswith("Las_Vegas_20150227T173620Z_r1_")
    lines = Path(download.value.path()).read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert {row["axis"] for row in rows} == {"alpha", "beta"}
    with page.expect_download() as download:
        page.get_by_role("button", name="Picture, SVG").click()
    assert b"alpha error, arcsec" in Path(download.value.path()).read_bytes()
    assert violations(page) == []
