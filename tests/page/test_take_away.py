"""Flow 4: everything that leaves the page says what the service says."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from browsing import made
from playwright.sync_api import expect
from waiting import eventually

from app.requests.examples import LAS_VEGAS
from planner.output.export import EXPORTERS


@pytest.fixture(scope="module")
def plan_id(service):
    """Of the plan that the page makes of its example."""
    return made(service, "/v1/plans", LAS_VEGAS | {"on_conflict": "refuse"})["id"]


@pytest.fixture
def plan_page(open_page, plan_id):
    page = open_page(f"/plans/{plan_id}")
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    expect(page.locator(".look-charts canvas").first).to_be_visible()  # nothing moves any more
    return page


def in_clipboard(page):
    return page.evaluate("navigator.clipboard.readText()")


def test_every_export_can_be_saved(plan_page):
    path = "/v1/plans/" + plan_page.url.rsplit("/", 1)[1]
    saved = {}
    region = plan_page.get_by_role("region", name="Take away")
    for button in [
        region.get_by_role("button", name="Download CSV"),
        *region.get_by_role("list").get_by_role("button").all(),
    ]:
        plan_page.reload()  # of one page a browser takes no ten downloads in a row unasked
        with plan_page.expect_download() as download:
            button.click()
        name = download.value.suggested_filename
        assert name.startswith("Las_Vegas_20150227T173620Z_r1_")
        saved[name.rsplit(".", 1)[1]] = Path(download.value.path()).read_bytes()
    assert len(saved) == len(EXPORTERS)
    assert saved["csv"] == plan_page.request.get(f"{path}/table?format=csv").body()


def test_the_plan_says_which_it_is_and_what_the_answer_says(plan_page):
    answer = plan_page.request.get("/v1/plans/" + plan_page.url.rsplit("/", 1)[1]).json()
    summary = answer["summary"]
    verdict = plan_page.get_by_test_id("verdict").inner_text()
    percent = f"{100 * summary['probability_in_frame']:.1f}".removesuffix(".0")
    assert f"in frame {percent} %" in verdict
    [session] = summary["sessions"]
    assert f"ground sample {session['ground_sample_m']:.2f} m" in verdict
    assert f"elevation up to {session['best_elevation_deg']:.0f}°" in verdict
    assert verdict.startswith("Passed, with doubts")  # it will probably miss
    # Of 3 deg/s the pass takes 0.99.
    assert "least margin 67 % of alpha rate at 17:37:30.5 UTC" in verdict
    when = "27 Feb 2015 17:36:20–17:37:50 UTC"
    expect(plan_page).to_have_title(
        f"Las Vegas, {when}, iss-hrc, TLE of 27 Feb 2015 11:33 (6 h old), "
        "LVLH -4/-2/1, revision 1 · A plan · slewtrack"
    )
    identity = plan_page.get_by_test_id("identity")
    for part in (
        when,
        "iss-hrc",
        "TLE of 27 Feb 2015 11:33 (6 h old)",
        "LVLH -4/-2/1",
        "revision 1",
        answer["id"],
        answer["provenance"]["input_sha256"][:12],
    ):
        expect(identity).to_contain_text(part)


def test_the_request_as_json_curl_and_python(plan_page, service, tmp_path):
    def copied(name):
        plan_page.locator("summary").filter(has_text=name).click()
        plan_page.get_by_role("button", name=f"Copy {name}").click()
        shown = plan_page.get_by_label(name, exact=True).text_content()
        eventually(lambda: in_clipboard(plan_page) == shown)
        return shown

    plan_page.get_by_role("button", name="Copy Permalink").click()
    eventually(lambda: in_clipboard(plan_page) == plan_page.url)
    asked = LAS_VEGAS | {"on_conflict": "refuse"}
    assert json.loads(copied("Request as JSON")) == asked
    curl = copied("curl")
    assert f"curl -s -X POST '{service.address}/v1/plans'" in curl
    assert json.loads(curl.split("--data-binary '")[1].removesuffix("'")) == asked
    script = tmp_path / "again.py"
    script.write_text(copied("Python"))
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout.endswith(" True\n")
