"""A reload loses nothing that was typed, in any room that has a form; of files the page says so."""

import json

import pytest
from browsing import PHONE, ROOT, fit_a_phone, made, violations
from playwright.sync_api import expect

PLAN = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())
# By the room's address: labels, and what is typed there.
TYPED = {
    "/campaigns": {
        "Name": "Kept over a reload",
        "Days": "2",
        "Least elevation, °": "40",
        "Priority of Boston": "7",
        "Add a target": "Ljubl",
    },
    "/spacecraft": {
        "Name": "Kept over a reload",
        "Closed-loop runs": "0",
        "Priority of strip": "3",
    },
    "/flights": {"Plan": "of no plan yet", "Runs": "77", "Seed": "5"},
    "/telemetry": {"Plan": "of no plan yet"},
    "/horizon": {"Request": '{"cameras": [', "Sigma of its attitude, deg": "0.75"},
}


@pytest.mark.parametrize("room", TYPED)
def test_what_was_typed_is_there_after_a_reload(open_page, room):
    page = open_page(room)
    for label, text in TYPED[room].items():
        field = page.get_by_label(label, exact=True)
        field.fill(text)
        field.dispatch_event("change")
    page.reload()
    for label, text in TYPED[room].items():
        expect(page.get_by_label(label, exact=True)).to_have_value(text)
    assert violations(page) == []
    if room in ("/campaigns", "/spacecraft"):  # also a request that is no JSON yet
        page.get_by_label("Request as JSON").fill('{"name": ')
        page.reload()
        expect(page.get_by_label("Request as JSON")).to_have_value('{"name": ')


def test_an_address_that_asks_for_another_begins_anew(open_page):
    page = open_page("/flights")
    page.get_by_label("Plan", exact=True).fill("one")
    page.goto(page.url + "?plan=another")
    expect(page.get_by_label("Plan", exact=True)).to_have_value("another")
    page.get_by_label("Plan", exact=True).fill("a third")
    page.reload()
    expect(page.get_by_label("Plan", exact=True)).to_have_value("a third")


def test_columns_stay_chosen_and_the_file_is_asked_for_again(open_page, service, tmp_path):
    file = tmp_path / "flown.csv"
    file.write_text("seconds,alpha_deg\n0,1\n")
    plan = made(service, "/v1/plans", PLAN)["id"]
    page = open_page(f"/telemetry?plan={plan}", viewport=PHONE)
    page.get_by_label("Telemetry, CSV").set_input_files(file)
    page.get_by_label("seconds", exact=True).select_option("t_s")
    page.get_by_role("button", name="Add a frame").click()
    page.reload()
    expect(page.get_by_text("choose flown.csv again")).to_be_visible()
    expect(page.get_by_label("Frame taken (UTC)")).to_be_visible()
    assert violations(page) == []
    fit_a_phone(page)
    page.get_by_label("Telemetry, CSV").set_input_files(file)
    expect(page.get_by_label("seconds", exact=True)).to_have_value("t_s")


def test_images_of_the_horizon_are_asked_for_again(open_page):
    page = open_page("/horizon")
    page.get_by_label("Choose images").set_input_files(ROOT / "examples/horizon_ahead.png")
    page.reload()
    expect(page.get_by_text("choose horizon_ahead.png again")).to_be_visible()
