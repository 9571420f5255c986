"""Steps that tests of the planner's page share."""

import json
import uuid
from pathlib import Path

import httpx2 as httpx
from live_service import Service
from playwright.sync_api import Locator, Page, Route, expect
from waiting import eventually

from app.requests.plan import read_plan_request

ROOT = Path(__file__).parents[2]
LAPTOP = {"width": 1280, "height": 800}
PHONE = {"width": 390, "height": 844}
_AXE = ROOT / "web/node_modules/axe-core/axe.min.js"


def made(service: Service, path: str, request: dict[str, object], **query: str) -> dict:
    """The service's answer once it is made, however long a loaded machine takes."""
    headers = {"Prefer": "wait=60", "Idempotency-Key": uuid.uuid4().hex}
    with httpx.Client(base_url=service.address, headers=headers, timeout=120.0) as client:

        def answered() -> httpx.Response | None:
            answer = client.post(path, json=request, params=query)
            return None if answer.status_code == 202 else answer

        answer = eventually(answered)
    assert answer.status_code == 201, answer.text
    return answer.json()


def long_campaign(service: Service, name: str) -> str:
    """The id of a campaign that works for as long as nobody cancels it."""
    places = [(lat, lon) for lat in range(-50, 51, 5) for lon in range(-180, 180, 12)]
    example = json.loads((ROOT / "examples/campaign_cities.json").read_text())
    targets = [
        {
            "id": f"{latitude} {longitude}",
            "session_s": 20.0,
            "target": {"mode": "ground", "latitude_deg": latitude, "longitude_deg": longitude},
        }
        for latitude, longitude in places
    ]
    asked = example | {"name": name, "stop": "2015-03-10T00:00:00Z", "targets": targets}
    address, later = f"{service.address}/v1/campaigns", {"Prefer": "respond-async"}
    sent = httpx.post(address, json=asked, headers=later)
    assert sent.status_code == 202, sent.text
    return sent.json()["id"]


def planned(page: Page) -> dict:
    """The request of the plan that the form now makes, as the service keeps it."""
    page.get_by_role("button", name="Plan").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    plan_id = page.url.rsplit("/", 1)[1]
    return page.request.get(f"/v1/plans/{plan_id}/request").json()


def asked(page: Page) -> dict:
    """The request that the form sends, which the service's reader takes; nothing is planned."""
    sent: list[str] = []

    def keep(route: Route) -> None:
        if route.request.method != "POST":
            return route.continue_()
        sent.append(route.request.post_data)
        refusal = json.dumps({"title": "Not planned here", "status": 422})
        return route.fulfill(status=422, content_type="application/problem+json", body=refusal)

    page.route("**/v1/plans", keep)
    with page.expect_response(lambda answer: answer.request.method == "POST" and bool(sent)):
        page.get_by_role("button", name="Plan").click()
    [request] = sent
    read_plan_request(request.encode())
    return json.loads(request)


def box_of(shown: Locator) -> dict[str, float]:
    """Where it stands, once it does: what is drawn anew has no box for a moment."""
    return eventually(shown.bounding_box)


def show_one_instant(marks: Locator, count: int) -> None:
    """So many charts, all with the cursor at the same place, once they have their widths."""
    expect(marks).to_have_count(count)
    places = "all => new Set(all.map(one => one.hidden ? null : one.style.transform)).size"
    eventually(lambda: marks.evaluate_all(places) == 1)


def fit_a_phone(page: Page) -> None:
    """Nothing is wider, once the charts have taken the width that they are given."""
    page.wait_for_function(
        "most => document.documentElement.scrollWidth <= most", arg=PHONE["width"]
    )


def violations(page: Page) -> list[str]:
    """What axe-core finds wrong on the page as it is."""
    page.evaluate(_AXE.read_text())
    found = page.evaluate("axe.run()")
    return [
        f"{one['id']} ({one['impact']}): {node['html'][:200]}"
        for one in found["violations"]
        for node in one["nodes"]
    ]
