"""Flow 3: a refusal is explained in words, drawn where it happens, its way out one click away."""

import httpx2 as httpx
import pytest
from browsing import violations
from playwright.sync_api import expect
from waiting import eventually

from app.requests.examples import LAS_VEGAS

TOO_EARLY = {"start": "2015-02-27T17:35:00Z", "stop": "2015-02-27T17:37:00Z"}


# Ten seconds to slew away and back are too few.
_FIRST = {"start": "2015-02-27T17:36:20Z", "stop": "2015-02-27T17:37:20Z"}
_SECOND = {
    "target": {"mode": "ground", "latitude_deg": 40.76, "longitude_deg": -111.89},
    "start": "2015-02-27T17:37:22Z",
    "stop": "2015-02-27T17:38:30Z",
}
TIGHT = LAS_VEGAS | {
    "sessions": [LAS_VEGAS["sessions"][0] | times for times in (_FIRST, _SECOND)],
    "on_conflict": "refuse",
}


def kept_refusal(service, request):
    """The id of a plan that the service refused; its request can be opened in the page."""
    with httpx.Client(base_url=service.address, timeout=120.0) as client:
        answer = client.post("/v1/plans", json=request, headers={"Prefer": "respond-async"})
        assert answer.status_code == 202, answer.text
        plan_id = answer.json()["id"]
        eventually(lambda: client.get(f"/v1/plans/{plan_id}").json()["state"] == "refused")
    return plan_id


@pytest.fixture(scope="module")
def refused_id(service):
    """That of TIGHT, which those who take its ways out leave as it is."""
    return kept_refusal(service, TIGHT)


def test_a_start_that_works_is_offered_drawn_and_taken(open_page, refused_id):
    page = open_page(f"/plans/{refused_id}")
    expect(page.get_by_role("alert")).to_contain_text("The slew doesn't fit")
    page.get_by_role("link", name="Change the request").click()
    page.get_by_role("button", name="2 40.76").click()
    refusal = page.get_by_role("alert")
    expect(refusal).to_contain_text("alpha needs")
    expect(refusal).to_contain_text("Session 2 · axis alpha · limit duration")
    expect(page.locator(".offered")).to_be_visible()
    assert violations(page) == []
    refusal.get_by_role("button", name="Take 17:37:3").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    request = page.request.get(f"/v1{_path(page)}/request").json()
    assert request["sessions"][1]["start"] > "2015-02-27T17:37:30Z"


def test_a_target_below_the_horizon_is_marked_where_it_is(open_page, service):
    request = LAS_VEGAS | {"sessions": [LAS_VEGAS["sessions"][0] | TOO_EARLY]}
    request["sessions"][0]["target"] = request["sessions"][0]["target"] | {
        "min_elevation_deg": 40.0
    }
    page = open_page(f"/?from={kept_refusal(service, request)}")
    expect(page.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    expect(page.get_by_role("alert")).to_contain_text("Session 1")
    expect(page.locator(".refused-at")).to_be_visible()
    expect(page.locator(".track-refused")).to_be_visible()


def test_sessions_that_overlap_are_told_and_one_is_left_out(open_page):
    page = open_page()
    windows = page.get_by_role("list", name="Windows, the first first")
    expect(windows).to_be_visible()
    page.get_by_role("button", name="Add a session").click()
    page.get_by_label("Place or coordinates").fill("40.76, -111.89, 1288")
    with page.expect_response(lambda answer: "40.76" in (answer.request.post_data or "")):
        page.get_by_role("button", name="Find").click()
    windows.get_by_role("button").first.click()
    page.get_by_role("slider", name="Start of the session").press("Home")
    told = page.get_by_role("alert")
    expect(told).to_contain_text("Sessions 1 and 2 overlap by")
    assert violations(page) == []
    page.get_by_label("Language").select_option("ru")
    expect(told).to_contain_text("Сеансы 1 и 2 перекрываются на")
    page.get_by_label("Язык").select_option("en")
    told.get_by_role("button", name="Leave out session 1").click()
    expect(told).to_be_hidden()
    page.get_by_role("button", name="Plan").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    [session] = page.request.get(f"/v1{_path(page)}/request").json()["sessions"]
    assert session["target"]["latitude_deg"] == 40.76


def test_where_nothing_is_offered_one_session_can_be_left_out(open_page, service):
    """Three seconds each and one between them: neither can be shortened so far."""
    first, second = TIGHT["sessions"]
    first = first | {"start": "2015-02-27T17:37:00Z", "stop": "2015-02-27T17:37:03Z"}
    second = second | {"start": "2015-02-27T17:37:04Z", "stop": "2015-02-27T17:37:07Z"}
    refused_id = kept_refusal(service, TIGHT | {"sessions": [first, second]})
    page = open_page(f"/?from={refused_id}")
    told = page.get_by_role("alert").filter(has_text="leave one out")
    expect(told).to_contain_text("Sessions 1 and 2 don't both fit")
    told.get_by_role("button", name="Leave out session 2").click()
    page.get_by_role("button", name="Plan").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")


def test_what_a_refused_plan_offers_is_taken_where_it_is_shown(open_page, refused_id):
    page = open_page(f"/plans/{refused_id}")
    page.get_by_role("alert").get_by_role("button", name="Take 17:37:3").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    request = page.request.get(f"/v1{_path(page)}/request").json()
    assert request["sessions"][1]["start"] > "2015-02-27T17:37:30Z"


def test_by_keyboard_the_way_out_is_the_next_stop(open_page, refused_id):
    page = open_page(f"/?from={refused_id}")
    refusal = page.get_by_role("alert")
    expect(refusal).to_be_visible()
    with page.expect_response(lambda answer: answer.url.endswith("/events")):
        page.get_by_role("button", name="Plan", exact=True).press("Enter")
    expect(refusal).to_be_visible()
    page.keyboard.press("Tab")
    expect(refusal.get_by_role("button", name="Take")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Change the request")).to_be_focused()


def _path(page):
    return "/plans/" + page.url.rsplit("/", 1)[1]
