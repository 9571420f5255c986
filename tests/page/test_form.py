"""The Plan room's form: every kind of target, options, files and templates, by names and clicks."""

import json
import re

import pytest
from browsing import PHONE, ROOT, asked, box_of, fit_a_phone, planned, violations
from playwright.sync_api import Page, expect

MESSAGES = ROOT / "app/requests/examples/data"
CYRILLIC = re.compile("[а-яё]", re.IGNORECASE)


def with_window(page: Page) -> Page:
    # Kernels of scans may be compiled first.
    shown = page.get_by_role("slider", name="Session", exact=True)
    expect(shown).to_be_visible(timeout=300_000)
    return page


@pytest.fixture
def form(open_page):
    return with_window(open_page())


def opened(page: Page, name: str):
    """The panel of that name, unfolded."""
    panel = page.get_by_role("region", name=name, exact=True)
    if not panel.locator("details").first.evaluate("box => box.open"):
        panel.locator("summary").first.click()
    return panel


def group(panel, name: str):
    """A folded box in a panel, unfolded."""
    box = panel.locator("details.fields-group", has=panel.page.get_by_text(name, exact=True)).last
    if not box.evaluate("box => box.open"):
        box.locator("summary").first.click()
    return box


def request_as_json(page: Page) -> dict:
    panel = opened(page, "Request")
    group(panel, "As JSON, to read and change")
    return json.loads(panel.get_by_label("Request as JSON").input_value())


def dropped(page: Page, onto, name: str, text: str) -> None:
    data = page.evaluate_handle(
        "([name, text]) => { const data = new DataTransfer();"
        " data.items.add(new File([text], name)); return data; }",
        [name, text],
    )
    onto.dispatch_event("drop", {"dataTransfer": data})


def test_a_path_is_clicked_on_the_map(form):
    form.get_by_role("radio", name="Path").check()
    world = form.get_by_role("application")
    closer = form.get_by_role("button", name="Closer")
    form.get_by_role("button", name="To the target").click()
    for _ in range(4):
        closer.click()
    box = box_of(world)
    middle = {"x": box["width"] / 2, "y": box["height"] / 2}
    for step in (0, 12, 24):
        world.click(position={"x": middle["x"] + step, "y": middle["y"] - step / 2})
    points = form.get_by_role("list", name="Points of the path")
    expect(points.get_by_role("listitem")).to_have_count(3)
    with_window(form)
    [session] = asked(form)["sessions"]
    assert session["target"]["mode"] == "ground_path"
    assert len(session["target"]["points"]) == 3


def test_a_mode_is_drawn_and_planned_in_a_window_of_all_its_scans(form, tmp_path):
    modes = json.loads((ROOT / "examples/imaging_modes.json").read_text())
    file = tmp_path / "modes.json"
    file.write_text(json.dumps(modes | {"sessions": [{}]}))
    opened(form, "Request").get_by_label("Open a request file").set_input_files(file)
    form.get_by_role("radio", name="Stereo pair").check()
    entry = form.get_by_role("combobox", name="Next point: place or coordinates")
    for count, place in enumerate(("28.772611, -15.742638", "29.301017, -15.876398"), start=1):
        entry.fill(place)
        entry.press("Enter")
        expect(form.get_by_role("button", name=f"Remove point {count}")).to_be_visible()
    expect(form.locator(".map .asked-shape")).to_have_count(1)
    with_window(form)
    plan = planned(form)
    [session] = plan["sessions"]
    assert session["target"]["mode"] == "stereo"
    assert session["target"]["geometry"]["coordinates"][0] == [-15.742638, 28.772611]
    expect(form.get_by_role("region", name="Sessions").get_by_role("row")).to_have_count(3)


def test_a_path_by_names_is_reordered_and_timed(form):
    form.get_by_role("radio", name="Path").check()
    entry = form.get_by_role("combobox", name="Next point: place or coordinates")
    for count, place in enumerate(("Las Vegas, Nevada, US", "Henderson, Nevada, US"), start=1):
        entry.fill(place)
        entry.press("Enter")
        expect(form.get_by_role("button", name=f"Remove point {count}")).to_be_visible()
    form.get_by_role("button", name="Point 2 earlier").click()
    expect(form.get_by_label("Latitude of point 1, °")).to_have_value("36.0397")
    form.get_by_label("Time for the whole path, s").fill("45")
    expect(form.get_by_text(re.compile(r"km at 45\d(\.\d)? m/s"))).to_be_visible()
    with_window(form)
    [session] = asked(form)["sessions"]
    assert session["target"]["speed_m_s"] == pytest.approx(456.0, rel=0.01)


def test_something_that_moves_by_a_places_name(form):
    form.get_by_role("radio", name="Moving").check()
    entry = form.get_by_role("combobox", name="Place or coordinates")
    entry.fill("Reno, Nevada, US")
    entry.press("Enter")
    speed = form.get_by_label("Speed, m/s")
    speed.fill("12,5")
    with_window(form)
    [session] = asked(form)["sessions"]
    assert session["target"]["mode"] == "ground_moving"
    assert session["target"]["speed_m_s"] == 12.5


def test_a_contact_with_a_station_clicked_on_the_map_or_typed(form):
    target = form.get_by_role("region", name="Target")
    form.get_by_role("radio", name="Station").check()
    world = form.get_by_role("application")
    box = box_of(world)
    world.click(position={"x": box["width"] / 2 + 20, "y": box["height"] / 2})
    expect(target.get_by_text(re.compile(r"^-?\d+[.]\d+, -?\d+[.]\d+$"))).to_be_visible()
    expect(form.get_by_role("radio", name="Station")).to_be_checked()
    entry = form.get_by_role("combobox", name="Place or coordinates")
    entry.fill("37.94, -75.46, 12")
    entry.press("Enter")
    expect(target.get_by_text("37.94, -75.46, 12")).to_be_visible()
    with_window(form)
    station = asked(form)["sessions"][0]["target"]
    assert (station["mode"], station["latitude_deg"], station["height_m"]) == ("station", 37.94, 12)


def test_a_test_motion_of_the_platforms_axes(form):
    form.get_by_role("radio", name="Test motion").check()
    form.get_by_role("button", name="Begin: Test motion").click()
    axes = group(form.get_by_role("region", name="Target"), "Motion of the axes")
    group(axes, "beta").get_by_label("beta: kind").select_option("sine")
    target = asked(form)["sessions"][0]["target"]
    assert {axis: motion["kind"] for axis, motion in target["axes"].items()} == {
        "alpha": "constant_rate",
        "beta": "sine",
    }


def test_degrees_minutes_and_seconds_are_read_and_a_wrong_angle_is_told_before_planning(form):
    entry = form.get_by_role("combobox", name="Place or coordinates")
    entry.fill("46 3 25 N 14 30 36 E")
    entry.press("Enter")
    expect(entry).to_have_value("46.0569444, 14.51")
    with_window(form)
    entry.fill("96, 14")
    entry.press("Enter")
    told = "Sessions 1 › Target › Latitude: It lies between -90 and 90 °."
    expect(form.get_by_text(told)).to_be_visible()
    entry.fill("Nowhereville")
    entry.press("Enter")
    expect(form.get_by_text("No town of this name is known here")).to_be_visible()


def test_level_flight_is_warned_of_and_the_usual_mean_taken_by_a_click(form):
    attitude = opened(form, "Attitude")
    for angle in ("Yaw, °", "Pitch, °", "Roll, °"):
        attitude.get_by_label(angle).fill("0")
    warning = attitude.get_by_role("status")
    expect(warning).to_contain_text("its usual mean is -4/-2/1")
    assert violations(form) == []
    warning.get_by_role("button", name="Take the usual -4/-2/1 of iss-hrc").click()
    expect(warning).to_be_hidden()
    law = asked(form)["attitude"]
    assert law == {"law": "lvlh", "yaw_deg": -4.0, "pitch_deg": -2.0, "roll_deg": 1.0}


@pytest.mark.parametrize("box", ["Attitude", "Orbit"])
def test_a_dropped_aem_is_the_attitude_wherever_it_falls(form, box):
    panel = opened(form, box)
    if box == "Attitude":
        panel.get_by_label("Law").select_option("aem")
        expect(panel.get_by_text("This law takes an AEM.")).to_be_visible()
    text = (MESSAGES / "attitude.aem").read_text()
    dropped(form, panel.locator(".drop-zone"), "attitude.aem", text)
    expect(form.get_by_role("region", name="Attitude").locator("summary").first).to_contain_text(
        "AEM"
    )
    made = asked(form)
    assert made["attitude"] == {"law": "aem", "content": text}
    assert made["orbit"]["source"] == "tle"


def test_options_are_those_of_the_schema(form):
    options = opened(form, "Options")
    slews = group(options, "Slews")
    slews.get_by_label("Objective").select_option("minimum_time")
    cones = group(slews, "Cones to keep out of")
    cones.get_by_role("button", name="Add: Cones to keep out of").click()
    cones.get_by_label("Half angle, °").fill("20")
    lead = group(slews, "Lead")
    lead.get_by_label("Lead", exact=True).select_option(label="At most so long")
    lead.get_by_label("Longest slew, s").fill("300")
    final = group(options, "Final state")
    final.get_by_label("Final state", exact=True).select_option(label="At angles, or parked")
    expect(final.get_by_label("Park")).to_have_value("zero")
    assert violations(form) == []
    made = asked(form)
    assert made["slew"] == {
        "method": "ocp",
        "objective": "minimum_time",
        "keep_out": [{"half_angle_deg": 20, "body": "sun"}],
        "lead": {"max_duration_s": 300},
    }
    assert made["final_state"] == {"park": "zero"}


def test_a_plan_begins_where_another_ends(form):
    first = planned(form)
    first_id = form.url.rsplit("/", 1)[1]
    form.get_by_role("link", name="Plan", exact=True).click()
    expect(form.get_by_role("slider", name="Session", exact=True)).to_be_visible()
    form.get_by_role("list", name="Windows, the first first").get_by_role("button").nth(1).click()
    opened(form, "Options").get_by_label("Begins where a plan ends").select_option(first_id)
    second = planned(form)
    assert second["sessions"][0]["start"] > first["sessions"][0]["stop"]
    end = first["sessions"][0]["stop"].removesuffix("Z")
    assert second["initial_state"]["epoch"].startswith(end)


def test_a_refused_field_is_told_in_words_and_marked_where_it_is(form):
    slews = group(opened(form, "Options"), "Slews")
    cones = group(slews, "Cones to keep out of")
    cones.get_by_role("button", name="Add: Cones to keep out of").click()
    cones.get_by_label("Body").fill("vulcan")
    form.get_by_role("button", name="Plan").click()
    alert = form.get_by_role("alert")
    expect(alert).to_contain_text("Slews › Cones to keep out of 1 › Body")
    expect(cones.get_by_label("Body")).to_have_attribute("aria-invalid", "true")


def test_a_reload_loses_nothing(form):
    options = opened(form, "Options")
    cones = group(group(options, "Slews"), "Cones to keep out of")
    cones.get_by_role("button", name="Add: Cones to keep out of").click()
    opened(form, "Request").get_by_label("Name of the plan").fill("A night over Europe")
    opened(form, "Attitude").get_by_label("Roll, °").fill("0.75")
    entry = form.get_by_role("combobox", name="Place or coordinates")
    entry.fill("Ljubljana")
    entry.press("Enter")
    expect(form.get_by_text("GeoNames 3196359")).to_be_visible()
    with_window(form)
    form.get_by_role("button", name="Add a session").click()
    form.get_by_label("Days").fill("5")
    form.get_by_label("Days").press("Enter")
    opened(form, "Request").get_by_label("Name of the plan").fill("A night over Europe")
    before = request_as_json(form)
    assert before["attitude"]["roll_deg"] == 0.75
    form.reload()
    expect(form.get_by_text("Session 2: no target yet")).to_be_visible()
    assert request_as_json(form) == before
    expect(form.get_by_label("Days")).to_have_value("5")


def test_a_plan_that_is_changed_in_the_form_stays_changed_over_a_reload(form):
    planned(form)
    form.get_by_role("link", name="Change the request").click()
    with_window(form)
    opened(form, "Request").get_by_label("Name of the plan").fill("Second thoughts")
    form.wait_for_function("() => sessionStorage['slewtrack.plan']?.includes('Second thoughts')")
    form.reload()
    with_window(form)
    request = planned(form)
    assert request["name"] == "Second thoughts"
    plan = form.request.get("/v1" + re.sub(r"^https?://[^/]+", "", form.url)).json()
    assert plan["revision"] == 2


def test_a_request_goes_out_as_a_file_and_comes_back(form, tmp_path):
    panel = opened(form, "Request")
    with form.expect_download() as saved:
        panel.get_by_role("button", name="Save the request as JSON").click()
    assert saved.value.suggested_filename == "Las Vegas.json"
    request = json.loads(saved.value.path().read_text())
    request |= {"name": "From a file", "final_state": "rest"}
    request["sessions"][0]["keyhole"] = "nearest"
    dropped(form, panel.locator(".drop-zone"), "mine.json", json.dumps(request))
    expect(panel.get_by_label("Name of the plan")).to_have_value("From a file")
    with_window(form)
    assert planned(form) == request


def test_what_the_form_has_no_fields_for_is_named(form):
    panel = opened(form, "Request")
    request = request_as_json(form)
    request["weather"] = "fine"
    request["slew"]["keep_out"] = [{"body": "sun", "half_angle_deg": 2, "colour": "red"}]
    panel.get_by_label("Request as JSON").fill(json.dumps(request))
    expect(panel).to_contain_text("they are kept and sent: Slews › Cones to keep out of 1 › Colour")
    expect(panel).to_contain_text("Weather")
    dropped(form, panel.locator(".drop-zone"), "photo.json", "[1]")
    expect(panel.get_by_role("alert")).to_contain_text("photo.json holds no request for a plan")
    assert request_as_json(form) == request


def test_a_template_is_kept_for_other_days(form):
    panel = opened(form, "Request")
    panel.get_by_label("Name of the template").fill("Vegas by day")
    panel.get_by_label("Name of the template").press("Enter")
    before = request_as_json(form)
    form.get_by_role("combobox", name="Place or coordinates").fill("Ljubljana")
    form.get_by_role("button", name="Find").click()
    expect(form.get_by_text("GeoNames 3196359")).to_be_visible()
    fresh = form.context.new_page()
    fresh.goto(form.url)
    panel = opened(with_window(fresh), "Request")
    panel.get_by_role("button", name="Vegas by day", exact=True).click()
    assert request_as_json(fresh) == before
    panel.get_by_role("button", name="Delete the template Vegas by day").click()
    expect(panel.get_by_role("button", name="Vegas by day", exact=True)).to_have_count(0)
    assert fresh.evaluate("localStorage['slewtrack.templates']") == "[]"


def test_a_platform_written_out_takes_masks(form):
    panel = opened(form, "Request")
    panel.get_by_label("Platform", exact=True).select_option(label="Written out…")
    platform = group(panel, "Platform iss-hrc, written out")
    masks = group(platform, "Masks")
    masks.get_by_role("button", name="Add: Masks").click()
    masks.get_by_label("Margin, °").fill("1")
    with_window(form)
    made = asked(form)["platform"]
    assert made["masks"][0]["margin_deg"] == 1


def test_conditions_of_windows(form):
    windows = form.get_by_role("region", name="Windows")
    found = windows.get_by_role("list", name="Windows, the first first").get_by_role("button")
    before = found.count()
    conditions = group(windows, "More conditions")
    conditions.get_by_label("Greatest off nadir, °").fill("30")
    expect(found).not_to_have_count(before)
    conditions.get_by_label("Least Sun elevation, °").fill("80")
    none = windows.get_by_text(
        "The target isn't seen in these days: whenever it is in sight the Sun"
    )
    expect(none).to_contain_text("sun_elevation_min_deg 80. Its greatest elevation is ")


def test_the_form_by_keyboard(form):
    form.get_by_role("radio", name="Ground").focus()
    form.keyboard.press("ArrowRight")
    form.keyboard.press("ArrowRight")
    expect(form.get_by_role("radio", name="Path")).to_be_checked()
    world = form.get_by_role("application")
    world.focus()
    for key in ("Enter", "ArrowRight", "Enter"):
        world.press(key)
    points = form.get_by_role("list", name="Points of the path")
    expect(points.get_by_role("listitem")).to_have_count(2)
    summary = form.get_by_role("region", name="Options").locator("summary").first
    summary.focus()
    summary.press("Enter")
    expect(form.get_by_label("Begins where a plan ends")).to_be_visible()


def test_everything_unfolded_fits_a_phone_in_the_longer_words_of_russian(open_page):
    page = open_page(viewport=PHONE, locale="ru-RU")
    expect(page.get_by_role("slider").first).to_be_visible()
    page.get_by_role("region").locator("select").first.wait_for(state="attached")
    unfold = "() => document.querySelectorAll('details').forEach(box => { box.open = true; })"
    for _ in range(4):
        page.evaluate(unfold)
    add = page.locator('button[aria-label^="Добавить: "]')
    assert add.count() > 5
    for number in range(add.count()):
        add.nth(number).evaluate("button => button.click()")
    page.evaluate(unfold)
    fit_a_phone(page)
    assert violations(page) == []
    words = page.locator(".ask-form :is(label, legend, summary b, .hint)").all_inner_texts()
    names = re.compile(r"^([\W\d]*|(alpha|beta)(, °.*)?|CCSDS AEM)$")
    english = {word for word in words if not CYRILLIC.search(word) and not names.match(word)}
    assert english == set()


def test_a_spacecraft_that_turns_as_a_whole_is_planned_by_name_and_written_out(open_page):
    page = open_page()
    panel = opened(page, "Request")
    panel.get_by_label("Platform", exact=True).select_option("smallsat-120kg")
    attitude = page.get_by_role("region", name="Attitude", exact=True)
    expect(attitude).to_contain_text("smallsat-120kg steers itself")
    expect(page.get_by_role("radio", name="Test motion")).to_have_count(0)
    assert "attitude" not in request_as_json(page)
    windows = page.get_by_role("region", name="Windows", exact=True)
    expect(windows.get_by_role("listitem").first).to_be_visible(timeout=60_000)
    panel.get_by_label("Platform", exact=True).select_option("Written out…")
    group(panel, "Platform smallsat-120kg, written out")
    panel.get_by_label("Off nadir max, °", exact=True).fill("45")
    assert request_as_json(page)["platform"]["off_nadir_max_deg"] == 45
    page.get_by_role("button", name="Plan").click()
    page.get_by_role("button", name=re.compile("Take")).first.click()  # the nearest that works
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    plan_id = page.url.rsplit("/", 1)[1]
    asked = page.request.get(f"/v1/plans/{plan_id}/request").json()
    assert asked["platform"]["kind"] == "body"
    assert asked["platform"]["off_nadir_max_deg"] == 45
    for room in ("Fly it many times", "Compare telemetry"):
        expect(page.get_by_role("link", name=room)).to_be_visible()
    page.get_by_role("link", name="Change the request").click()
    panel = opened(page, "Request")
    panel.get_by_label("Platform", exact=True).select_option("iss-hrc")
    assert request_as_json(page)["attitude"]["yaw_deg"] == -4
