"""A plan can be flown on the page, and its telemetry be compared."""

import json

import httpx
from browsing import PHONE, ROOT, fit_a_phone, made, show_one_instant, violations
from other_body import Flown, body_request, written
from playwright.sync_api import expect


def test_a_plan_is_flown_and_what_is_to_blame_is_told(open_page, plan):
    page = open_page(f"/flights?plan={plan}")
    page.get_by_label("Runs").fill("40")
    page.get_by_role("button", name="Fly it").click()
    verdict = page.get_by_test_id("flights-verdict")
    expect(verdict).to_contain_text("of the flights", timeout=120_000)
    expect(page.get_by_text("40 of 40 flights")).to_be_visible()
    expect(page.get_by_role("img", name="Histogram of the runs' largest misses")).to_be_visible()
    expect(page.get_by_role("img", name="Smear of the frames")).to_be_visible()
    expect(page.get_by_role("row", name="attitude").first).to_be_visible()
    over_time = page.get_by_role("region", name="Over the plan's time")
    expect(over_time).to_contain_text("budget, 1 σ")
    frame = over_time.get_by_test_id("frame-now")
    expect(frame).to_contain_text("Frame 1: error flown")
    expect(frame).to_contain_text("planned 0")
    slider = over_time.get_by_role("slider")
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
    expect(frame).not_to_contain_text("Frame 1:")
    show_one_instant(over_time.locator(".chart-now"), 2)
    before = slider.input_value()
    page.get_by_label("Language").select_option("ru")
    expect(page.get_by_role("heading", name="По времени плана")).to_be_visible()
    expect(page.locator("[aria-labelledby=over-time]").get_by_role("slider")).to_have_value(before)
    page.get_by_label("Язык").select_option("en")
    over_time.get_by_role("button", name="Play").click()
    expect(slider).not_to_have_value(before)
    assert violations(page) == []
    page.goto(page.url.rsplit("/flights", 1)[0] + "/flights")
    expect(page.get_by_role("heading", name="Flown before")).to_be_visible()


def test_a_body_is_flown_from_its_plan(open_page, service):
    """The smallsat of the registry over Las Vegas, in Russian on a phone."""
    request = json.loads((ROOT / "examples/las_vegas_2015.json").read_text())
    del request["attitude"]
    request["platform"] = "smallsat-120kg"
    request["initial_state"] = {"epoch": request["initial_state"]["epoch"]}
    request["sessions"][0]["start"] = "2015-02-27T17:36:46Z"
    page = open_page(f"/plans/{made(service, '/v1/plans', request)['id']}")
    page.get_by_role("link", name="Fly it many times").click()
    page.get_by_label("Runs").fill("20")
    page.get_by_role("button", name="Fly it").click()
    expect(page.get_by_text("20 of 20 flights")).to_be_visible(timeout=120_000)
    for cause in ("attitude knowledge", "attitude control", "vibration"):
        expect(page.get_by_role("row", name=cause)).to_be_visible()
    expect(page.get_by_test_id("frame-now")).to_contain_text("Frame 1: error flown")
    page.get_by_label("Language").select_option("ru")
    page.set_viewport_size(PHONE)
    expect(page.get_by_role("row", name="управление ориентацией")).to_be_visible()
    fit_a_phone(page)
    assert violations(page) == []


def test_flights_under_way_are_cancelled(open_page, plan):
    page = open_page(f"/flights?plan={plan}")
    page.get_by_label("Runs").fill("9000")
    page.get_by_role("button", name="Fly it").click()
    expect(page.get_by_role("progressbar")).to_be_visible(timeout=60_000)
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_text("Cancelled; what is told")).to_be_visible(timeout=60_000)


def test_flights_of_no_plan_are_refused_in_words(open_page):
    page = open_page("/flights?plan=nothing")
    page.get_by_role("button", name="Fly it").click()
    expect(page.get_by_role("alert")).to_contain_text("must be an id")


def telemetry(service, plan: str, ahead_s: float) -> bytes:
    """The table's own rows, by a clock that is ahead."""
    table = httpx.get(f"{service.address}/v1/plans/{plan}/table", params={"format": "json"}).json()
    columns = ("t_s", "alpha_deg", "beta_deg")
    lines = [",".join(columns)]
    for t_s, *angles in zip(*(table[column] for column in columns), strict=True):
        lines.append(",".join(map(str, [t_s + ahead_s, *angles])))
    lines[5:5] = ["nonsense,,"]
    return "\n".join(lines).encode()


def test_columns_of_other_names_are_mapped_by_hand(open_page, service, plan, tmp_path):
    file = tmp_path / "flight.csv"
    content = telemetry(service, plan, 0.37).decode()
    file.write_text(content.replace("t_s,alpha_deg,beta_deg", "Time,AZ alpha,EL beta"))
    page = open_page(f"/telemetry?plan={plan}")
    page.get_by_label("Telemetry, CSV").set_input_files(str(file))
    compare = page.get_by_role("button", name="Compare")
    compare.click()
    expect(page.get_by_role("alert")).to_contain_text("samples")
    meant = {"Time": "t_s", "AZ alpha": "alpha_deg", "EL beta": "beta_deg"}
    for name, meaning in meant.items():
        page.get_by_label(name, exact=True).select_option(meaning)
    compare.click()
    expect(page.get_by_test_id("comparison")).to_contain_text("0.3700")


def test_a_bodys_telemetry_is_compared_with_its_plan(open_page, service, tmp_path):
    plan = made(service, "/v1/plans", body_request(sessions=1))["id"]
    table = httpx.get(f"{service.address}/v1/plans/{plan}/table", params={"format": "json"}).json()
    file = tmp_path / "flight.csv"
    file.write_bytes(written(table, Flown(wander_arcsec=20.0, half_life_s=2.0), 1, "wxyz"))
    page = open_page(f"/telemetry?plan={plan}")
    page.get_by_label("Telemetry, CSV").set_input_files(str(file))
    expect(page.get_by_label("q_1", exact=True)).to_have_value("q_1")
    page.get_by_role("button", name="Compare").click()
    expect(page.get_by_test_id("comparison")).to_contain_text("0.37", timeout=60_000)
    expect(page.get_by_role("img", name="z, planned and flown")).to_be_visible()
    expect(page.get_by_text("The attitude wanders by").first).to_be_visible()
    expect(page.get_by_text("Stick and slip")).to_have_count(0)
    expect(page.get_by_text("knowledge.control_sigma_arcsec")).to_be_visible()
    assert violations(page) == []
