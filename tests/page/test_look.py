"""The look at a plan shows what the plan holds, at the cursor's time, to everyone."""

import io
import json
import math
import re
import urllib.request

import pytest
from browsing import PHONE, ROOT, box_of, fit_a_phone, made, show_one_instant, violations
from PIL import Image
from playwright.sync_api import Locator, Page, expect
from waiting import eventually

from app.requests.examples import ESTIMATE_EXAMPLE, PLAN_EXAMPLES

AHEAD = ESTIMATE_EXAMPLE["cameras"][0]
RIGHT = ESTIMATE_EXAMPLE["cameras"][1]
AGILE = {
    "kind": "body",
    "name": "agile",
    "agility": {
        "limits": "magnitude",
        "rate_max_deg_s": 3.0,
        "acceleration_max_deg_s2": 0.5,
        "jerk_max_deg_s3": 0.3,
    },
    "off_nadir_max_deg": 60.0,
    "camera": {"type": "frame", "field_of_view_deg": [2.0, 1.5]},
    "exclusions": [
        {
            "name": "radiator",
            "direction_body": [0.0, 1.0, 0.0],
            "away_from": "sun",
            "min_deg": 20.0,
            "when": "imaging",
        }
    ],
    "star_trackers": {
        "needed": 1,
        "each": [
            {
                "name": f"st{number}",
                "boresight_body": [along, -0.6, -0.6245],
                "sun_deg": 35.0,
                "moon_deg": 10.0,
                "limb_deg": 12.0,
            }
            for number, along in ((1, 0.5), (2, -0.5))
        ],
    },
}

# What a globe takes without a graphics card hangs on its pixels.
SMALL = {"width": 640, "height": 480}

# How much was drawn, and for how many of the browser's pictures nothing was.
_COUNT_DRAWING = """
window.drawn = window.idle = 0;
const { drawElements } = WebGL2RenderingContext.prototype;
WebGL2RenderingContext.prototype.drawElements = function (...given) {
  window.drawn++;
  window.idle = 0;
  return drawElements.apply(this, given);
};
const count = () => { window.idle++; requestAnimationFrame(count); };
count();
"""


@pytest.fixture(scope="module")
def las_vegas(plan) -> str:
    """Its address on the page."""
    return f"/plans/{plan}"


def planned(service, **changed: object) -> str:
    document = json.loads((ROOT / "examples/las_vegas_2015.json").read_text()) | changed
    return f"/plans/{made(service, '/v1/plans', document)['id']}"


def view_of(service, path: str) -> dict:
    with urllib.request.urlopen(
        f"{service.address}/v1{path}/view?step_s=0.2", timeout=60
    ) as answer:
        return json.load(answer)


def go_to(page: Page, t_s: float) -> None:
    page.get_by_label("Time of the cursor").fill(f"{t_s:g}")


def shows_the_earth(globe: Locator) -> bool:
    """Whether the picture has the colours of land and sea, which space and lines have not."""
    picture = Image.open(io.BytesIO(globe.screenshot())).convert("RGB")
    return len(picture.getcolors(picture.width * picture.height)) > 5000


def axis_row(page: Page, name: str) -> list[str]:
    row = page.get_by_role("row").filter(has=page.get_by_role("rowheader", name=name, exact=True))
    return row.first.get_by_role("cell").all_inner_texts()


def test_the_values_are_those_of_the_view(open_page, service, las_vegas):
    """Beside a map, where there is no WebGL; a closer look at the session tells its probability."""
    view = view_of(service, las_vegas)
    page = open_page(las_vegas)
    go_to(page, 170)
    row = view["t_s"].index(170.0)
    elevation = f"{view['targets'][0]['elevation_deg'][row]:.2f}°"
    expect(page.get_by_text(elevation, exact=True)).to_be_visible()
    for name, axis in view["axes"].items():
        told = [float(text.replace("−", "-")) for text in axis_row(page, name)]
        assert told[0] == pytest.approx(axis["angle_deg"][row], abs=1e-4)
        assert told[1] == pytest.approx(axis["rate_deg_s"][row], abs=1e-5)
        assert told[2] == pytest.approx(axis["acceleration_deg_s2"][row], abs=1e-5)
        assert told[3] == pytest.approx(axis["jerk_deg_s3"][row], abs=1e-5)
    expect(page.get_by_test_id("aloud")).to_contain_text("17:36:50 UTC; session; alpha")
    land_map = page.get_by_role("img", name="Map with the ground track")
    expect(land_map).to_be_visible()
    expect(land_map.get_by_text("36.1147")).to_be_visible()
    expect(page.get_by_role("button", name="Globe", exact=True)).to_be_disabled()
    assert violations(page) == []
    told = page.request.get(f"/v1{las_vegas}").json()["uncertainty"][0]["probability_in_frame"]
    page.get_by_role("button", name="Closer look: near Las Vegas").click()
    expect(page.get_by_label("Time of the cursor")).to_have_value("140")
    expect(page.get_by_text(f"in frame: {round(100 * told, 1):g} %")).to_be_visible()


def test_a_spacecraft_that_turns_as_a_whole_shows_what_it_has(open_page, service):
    """Rates about x, y and z, exclusions in the verdict and over time; no angles of axes."""
    request = json.loads((ROOT / "examples/three_sessions.json").read_text()) | {"platform": AGILE}
    del request["attitude"], request["initial_state"]
    path = f"/plans/{made(service, '/v1/plans', request)['id']}"
    page = open_page(path)
    view = view_of(service, path)
    least_deg = min(
        margin
        for one in view["exclusions"]
        for margin, does in zip(one["margin_deg"], view["activity"], strict=True)
        if does == "track"  # both count while the camera images
    )
    verdict = page.get_by_test_id("verdict").inner_text()
    told = re.search(r"([\d.]+)° at least", verdict)
    # to one decimal, and between rows, of which each turns by 0.2 s of at most 1 deg/s
    assert float(told[1]) == pytest.approx(least_deg, abs=0.05 + 0.2)
    expect(page.locator(".look-left")).to_contain_text("1-sigma")
    ellipse = re.search(r"1-sigma (\d+) × (\d+) ″", page.locator(".look-left").inner_text())
    row = view["activity"].index("track")  # the next session's, while none is at the cursor
    sigmas_arcsec = [view["pointing"][f"sigma_{one}_arcsec"][row] for one in ("major", "minor")]
    # the page's rows of so long a plan are seconds apart
    assert [*map(float, ellipse.groups())] == pytest.approx(sigmas_arcsec, rel=0.02)
    charts = page.get_by_role("region", name="Motion and sight")
    for shown in ("Exclusions kept by", "Camera from the nadir", "star trackers", "radiator"):
        expect(charts).to_contain_text(shown)
    expect(charts.get_by_role("heading", name="Angle")).to_have_count(0)
    expect(page.get_by_role("region", name="Margins")).to_contain_text("star trackers")
    for name in "xyz":
        assert len(axis_row(page, name)) == 3
    page.set_viewport_size(PHONE)
    fit_a_phone(page)
    assert violations(page) == []


def test_keys_and_charts_move_the_cursor_and_it_plays(open_page, las_vegas):
    page = open_page(las_vegas)
    slider = page.get_by_label("Time of the cursor")
    expect(slider).to_have_value("0")
    expect(page.locator(".chart canvas").first).to_be_visible()
    page.keyboard.press("ArrowRight")
    expect(slider).to_have_value("1")
    page.keyboard.press("Shift+ArrowRight")
    expect(slider).to_have_value("11")
    page.keyboard.press("End")
    expect(slider).to_have_value("230")
    page.keyboard.press("Home")
    expect(slider).to_have_value("0")
    page.get_by_label("Speed").select_option("60")
    page.get_by_role("heading", name="At the cursor").click()
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(slider).to_have_value("230")  # after four seconds, where it stops by itself
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    # A chart that is dragged moves the cursor for all.
    rate = page.locator(".chart .u-over").nth(1)
    show_one_instant(page.locator(".chart-now"), 6)
    width = box_of(rate)["width"]
    begin, end = ({"x": share * width, "y": 20} for share in (0.2, 0.5))
    rate.drag_to(rate, source_position=begin, target_position=end)
    eventually(lambda: float(slider.input_value()) == pytest.approx(115, abs=1))
    show_one_instant(page.locator(".chart-now"), 6)


def test_close_to_the_target_there_is_the_flat_map(open_page, service, las_vegas):
    """Swath, frame, 1-sigma ellipse, scale and legend; the ellipse is as long as range and angle
    make it."""
    view = view_of(service, las_vegas)
    page = open_page(las_vegas, globe=True, viewport=SMALL)
    expect(page.locator(".look-globe")).to_have_attribute("data-state", "there")
    page.get_by_role("button", name="Target", exact=True).click()
    near = page.get_by_role("img", name="Map with the ground track")
    row = view["targets"][0]["elevation_deg"].index(max(view["targets"][0]["elevation_deg"]))
    go_to(page, view["t_s"][row])
    box = box_of(near.locator(".lm-ellipse"))
    scale = box_of(near.locator(".lm-scale path"))["width"]
    [told] = near.locator(".lm-scale text").all_text_contents()
    per_px_m = 1e3 * float(told.removesuffix(" km")) / scale
    sigma_rad = view["pointing"]["sigma_major_arcsec"][row] / 206_264.806
    range_m = view["targets"][0]["range_m"][row]
    # The pass is nearly overhead: a long axis aslant lies within its box's diagonal.
    assert max(box["width"], box["height"]) * per_px_m == pytest.approx(
        2.0 * sigma_rad * range_m, rel=0.15
    )
    expect(near.locator(".lm-footprints")).to_have_count(24)
    for named in ("swath and frame", "1 sigma", "night"):
        expect(page.locator(".look-map-legend").get_by_text(named)).to_be_visible()
    name, mark = near.get_by_text("36.1147"), near.locator(".lm-target circle")
    assert box_of(name)["x"] > box_of(mark)["x"] + box_of(mark)["width"]
    assert violations(page) == []
    page.get_by_role("button", name="Overview").click()
    expect(near.locator(".lm-carrier")).to_be_visible()
    # A globe closer than its picture becomes the map, too.
    page.get_by_role("button", name="Globe", exact=True).click()
    expect(near).to_be_hidden()
    for _ in range(20):
        if near.is_visible():
            break
        page.get_by_role("button", name="Closer", exact=True).click()
    expect(near).to_be_visible()


def test_a_star_has_a_chart_of_the_sky(open_page, service):
    """The star in the middle, the Sun as far off as the view tells, its height above the limb."""
    path = f"/plans/{made(service, '/v1/plans', PLAN_EXAMPLES['star'][1])['id']}"
    view = view_of(service, path)
    page = open_page(path, globe=True)
    chart = page.get_by_role("img", name="Chart of the sky around the target")
    expect(chart).to_be_visible()
    go_to(page, 200)
    row = view["t_s"].index(200.0)
    whole, star, sun = (
        box_of(chart.locator(part).first)
        for part in (".sky-ground", ".sky-target path", ".sky-sun circle")
    )

    def middle(box: dict) -> tuple[float, float]:
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    assert middle(star) == pytest.approx(middle(whole), abs=1.5)
    off_px = math.dist(middle(star), middle(sun))
    # Distances from the middle are true: half the chart is half a turn.
    expected = view["targets"][0]["sun_separation_deg"][row]
    assert 360.0 * off_px / whole["width"] == pytest.approx(expected, abs=2.0)
    height = view["targets"][0]["elevation_deg"][row]
    expect(page.get_by_text(f"{height:.1f}° above the limb")).to_be_visible()
    expect(page.get_by_text("Above the limb", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Target", exact=True)).to_have_count(0)
    assert violations(page) == []
    page.set_viewport_size(SMALL)
    page.get_by_role("button", name="Globe", exact=True).click()
    expect(page.locator(".look-globe")).to_have_attribute("data-state", "there")


def test_one_globe_rests_until_something_moves_and_is_kept_from_plan_to_plan(
    open_page, service, las_vegas
):
    """Each one that is destroyed leaves its canvas with listeners behind."""
    page = open_page("/healthz", globe=True, viewport=SMALL)
    page.add_init_script(_COUNT_DRAWING)
    page.goto(page.url.replace("/healthz", las_vegas))
    expect(page.locator(".look-globe")).to_have_attribute("data-state", "there")
    page.wait_for_function("() => window.drawn && window.idle > 30")
    before = page.evaluate("window.drawn")
    go_to(page, 170)
    page.wait_for_function("before => window.drawn > before && window.idle > 30", arg=before)
    globe = page.locator(".look-globe[data-state=there]")
    globe.locator("canvas").evaluate("canvas => { canvas.dataset.first = ''; }")
    for path in (planned(service, name="another"), "/plans", las_vegas):
        page.evaluate("path => history.pushState(null, '', path)", path)
        page.evaluate("dispatchEvent(new PopStateEvent('popstate'))")
        expect(page.get_by_role("heading", level=1)).to_be_visible()
    expect(globe).to_be_visible()
    expect(globe.locator("canvas[data-first]")).to_be_visible()
    expect(page.locator(".look-globe canvas")).to_have_count(1)
    eventually(lambda: shows_the_earth(globe))
    page.get_by_role("button", name="Flat map").click()
    expect(page.get_by_role("img", name="Map with the ground track")).to_be_visible()


def test_in_the_dark_it_is_accessible_and_in_russian_it_fits_a_phone(open_page, las_vegas):
    page = open_page(las_vegas, color_scheme="dark", locale="ru-RU", globe=True)
    expect(page.locator(".chart canvas").first).to_be_visible()
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    expect(page.get_by_role("button", name="Пуск")).to_be_visible()
    expect(page.get_by_role("heading", name="В выбранный момент")).to_be_visible()
    fit_a_phone(page)


def test_what_horizon_cameras_will_see(open_page, service):
    path = planned(service, horizon_cameras=[AHEAD, RIGHT])
    page = open_page(path)
    pictures = page.get_by_role("img", name="Limb in the frame of")
    expect(pictures).to_have_count(6)
    page.get_by_role("button", name="17:37:50").first.click()
    expect(page.get_by_label("Time of the cursor")).to_have_value("230")
    assert violations(page) == []


def test_the_cone_and_its_outline(open_page, service):
    cone = {"body": "sun", "half_angle_deg": 25.0}
    path = planned(service, slew={"method": "ocp", "objective": "smooth", "keep_out": [cone]})
    page = open_page(path)
    axes = page.get_by_role("img", name="Path of the axes")
    page.get_by_label("To the stops").check()
    assert axes.locator(".axis-cone").first.get_attribute("d").startswith("M")
    expect(axes.locator(".axis-keyhole")).to_have_count(2)
