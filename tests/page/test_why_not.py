"""Flow 3: is a refusal told in words, drawn where it happens, and its way out one click away?"""

import json

import pytest
from browsing import violations
from playwright.sync_api import expect

from app.requests.examples.plan import LAS_VEGAS

TOO_EARLY = {"start": "2015-02-27T17:35:00Z", "stop": "2015-02-27T17:37:00Z"}


def kept_refusal(page, request):
    """The id of a plan that the service refused; its request can be opened in the page."""
    answer = page.request.post(
        "/v1/plans",
        data=json.dumps(request),
        headers={"Content-Type": "application/json", "Prefer": "respond-async"},
    )
    assert answer.status == 202, answer.text()
    return answer.json()["id"]


@pytest.fixture
def tight():
    """Ten seconds to slew away and back are too few."""
    [session] = LAS_VEGAS["sessions"]
    first = session | {"start": "2015-02-27T17:36:20Z", "stop": "2015-02-27T17:37:20Z"}
    second = session | {
        "target": {"mode": "ground", "latitude_deg": 40.76, "longitude_deg": -111.89},
        "start": "2015-02-27T17:37:22Z",
        "stop": "2015-02-27T17:38:30Z",
    }
    return LAS_VEGAS | {"sessions": [first, second], "on_conflict": "refuse"}


def test_a_start_that_works_is_offered_drawn_and_taken(open_page, tight):
    page = open_page("/plans")
    plan_id = kept_refusal(page, tight)
    page.goto(f"/plans/{plan_id}")
    expect(page.get_by_role("alert")).to_contain_text("The slew doesn't fit")
    page.get_by_role("link", name="Change the request").click()
    page.get_by_role("button", name="2 40.76").click()
    page.get_by_role("button", name="Plan").click()
    refusal = page.get_by_role("alert")
    expect(refusal).to_contain_text("alpha needs")
    expect(refusal).to_contain_text("Session 2 · axis alpha · limit duration")
    expect(page.locator(".offered")).to_be_visible()
    assert violations(page) == []
    refusal.get_by_role("button", name="Take 17:37:3").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    request = page.request.get(f"/v1{_path(page)}/request").json()
    assert request["sessions"][1]["start"] > "2015-02-27T17:37:30Z"


def test_a_target_below_the_horizon_is_marked_where_it_is(open_page):
    page = open_page("/plans")
    request = LAS_VEGAS | {"sessions": [LAS_VEGAS["sessions"][0] | TOO_EARLY]}
    request["sessions"][0]["target"] = request["sessions"][0]["target"] | {
        "min_elevation_deg": 40.0
    }
    plan_id = kept_refusal(page, request)
    page.goto(f"/?from={plan_id}")
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    page.get_by_role("button", name="Plan").click()
    expect(page.get_by_role("alert")).to_contain_text("Session 1")
    expect(page.locator(".refused-at")).to_be_visible()
    expect(page.locator(".track-refused")).to_be_visible()


def _path(page):
    return "/plans/" + page.url.rsplit("/", 1)[1]
