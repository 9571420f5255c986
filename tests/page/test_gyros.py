"""A plan of a body with gyros shows its gimbals and their momentum, and how steady it flies."""

import pytest
from browsing import PHONE, made, show_one_instant, violations
from other_body import body_request
from playwright.sync_api import expect

PATIENCE_MS = 180_000.0  # a flight whose kernels are compiled beside it


@pytest.fixture(scope="module")
def plan(service) -> str:
    """The id of one city imaged by the spacecraft of the registry."""
    request = body_request(sessions=1) | {"platform": "agile-cmg"}
    [session] = request["sessions"]
    session["start"], session["stop"] = "2015-05-10T10:35:50Z", "2015-05-10T10:36:10Z"
    return made(service, "/v1/plans", request)["id"]


def test_momentum_and_gimbals_are_panels_of_a_plan(open_page, plan):
    page = open_page(f"/plans/{plan}")
    sphere = page.get_by_role("region", name="Momentum of the gyros")
    way = sphere.locator(".sphere-off").get_attribute("d")
    sphere.get_by_role("application").press("ArrowLeft")
    expect(sphere.locator(".sphere-off")).not_to_have_attribute("d", way)
    for chart in ("Gimbal angles in °", "Gimbal rates in °/s", "Momentum in N·m·s"):
        expect(page.get_by_role("img", name=f"{chart} over time")).to_be_visible()
    show_one_instant(page.locator(".look-charts .chart-now"), 9)
    assert violations(page) == []


def test_the_rate_error_is_shown_where_it_is_flown(open_page, plan):
    page = open_page(f"/flights?plan={plan}", viewport=PHONE)
    page.get_by_label("Runs").fill("4")
    page.get_by_role("button", name="Fly it").click()
    expect(page.get_by_text("steady within 0.001°/s in 100 % of the runs")).to_be_visible(
        timeout=PATIENCE_MS
    )
    expect(page.get_by_role("img", name="Rate error while imaging")).to_be_visible()
    page.get_by_label("Language").select_option("ru")
    expect(page.get_by_text("Управление гиродинами")).to_be_visible()
    assert violations(page) == []
