"""Flow 5: a campaign's targets are taken, its progress shown, and its choice given with reasons."""

import json
import re
import zipfile
from pathlib import Path

import httpx
import pytest
from browsing import PHONE, ROOT, fit_a_phone, long_campaign, made, violations
from playwright.sync_api import expect

EXAMPLE = json.loads((ROOT / "examples/campaign_cities.json").read_text())
PATIENCE_MS = 180_000


@pytest.fixture(scope="module")
def campaign(service):
    """The example as it is made, with a town that the carrier never sees: its answer."""
    north = {
        "id": "Longyearbyen",
        "session_s": 20.0,
        "target": {"mode": "ground", "latitude_deg": 78.22, "longitude_deg": 15.63},
    }
    asked = EXAMPLE | {"targets": [*EXAMPLE["targets"], north]}
    return made(service, "/v1/campaigns", asked)


@pytest.fixture(scope="module")
def fleet(service):
    """What is asked of several carriers, and the answer."""
    asked = json.loads((ROOT / "examples/campaign_fleet.json").read_text())
    return asked, made(service, "/v1/campaigns", asked)


def outcome(page, target):
    return page.get_by_role("row").filter(has=page.get_by_role("button", name=target, exact=True))


def test_what_is_chosen_and_why_the_rest_is_not(open_page, campaign):
    page = open_page(f"/campaigns/{campaign['id']}")
    expect(page.get_by_test_id("campaign-verdict")).to_contain_text("4 looks in 2 passes")
    expect(page.get_by_test_id("campaign-verdict")).to_contain_text("5 of 6 targets can be seen")
    [left_out], [unseen] = campaign["choice"]["left_out"], campaign["choice"]["unseen"]
    expect(outcome(page, left_out["target"])).to_contain_text(left_out["because"])
    expect(outcome(page, unseen["target"])).to_contain_text(unseen["because"])
    expect(page.locator(".map .fate-chosen")).to_have_count(4)
    expect(page.locator(".map .fate-left_out")).to_have_count(1)
    expect(page.locator(".map .fate-unseen")).to_have_count(1)
    outcome(page, "Boston").get_by_role("button").click()
    expect(page.locator(".map .fate-now")).to_contain_text("Boston")
    page.get_by_label("Show", exact=True).select_option("left out")
    expect(page.get_by_role("button", name="Boston", exact=True)).to_have_count(0)
    assert violations(page) == []


def test_hundreds_of_targets_from_a_file_are_drawn_as_one_and_chosen_by_a_click(
    open_page, service, tmp_path
):
    """The command's columns, too; what is too long to be changed as JSON can be saved."""
    rows = [f"north {n},30,ground,{84 + 0.01 * n},{0.4 * n - 150}" for n in range(500)]
    heading = "id,session_s,target.mode,target.latitude_deg,target.longitude_deg"
    file = tmp_path / "north.csv"
    others = [f"{which} {one}" for which in ("again", "more") for one in rows]
    file.write_text("\n".join([heading, *rows, *others]))
    page = open_page("/campaigns")
    page.get_by_label("Choose a file of targets").set_input_files(file)
    expect(page.get_by_text("Show 1300 more")).to_be_visible()
    expect(page.locator(".map .fate .dot")).to_have_count(1)
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the request as JSON").click()
    asked = json.loads(Path(saved.value.path()).read_text())
    assert len(asked["targets"]) == 1500

    seen = made(service, "/v1/campaigns", EXAMPLE | {"targets": asked["targets"][:500]})
    page = open_page(f"/campaigns/{seen['id']}")
    expect(page.locator(".map .fate-unseen .dot")).to_have_count(1)
    dots = page.locator(".map .fate-unseen .dot")
    first = dots.evaluate("e => (({x, y}) => [x, y])(e.getPointAtLength(0))")
    corner = page.locator(".map svg").bounding_box()
    page.mouse.click(corner["x"] + first[0] + 1, corner["y"] + first[1] + 1)
    expect(page.locator(".map .fate-now")).to_have_count(1)
    expect(page.locator(".fate-list .row-now")).to_contain_text("north")


def test_a_fleet_is_shown_by_carrier_and_sought_by_name(open_page, fleet):
    asked, told = fleet
    page = open_page(f"/campaigns/{told['id']}")
    looks = [(one["carrier"], look["target"]) for one in told["passes"] for look in one["looks"]]
    expect(page.locator(".carriers li")).to_have_count(len(asked["carriers"]))
    expect(page.locator(".carrier-look")).to_have_count(len(looks))
    colour = "element => getComputedStyle(element).fill"
    look = page.locator(".carriers li").filter(has_text="follower").locator("rect").first
    on_map = page.locator(".map .fate").filter(has_text="Boston").locator("circle")
    assert look.evaluate(colour) == on_map.evaluate(colour)
    page.get_by_role("button", name="follower").click()
    own = {target for carrier, target in looks if carrier == "follower"}
    expect(page.locator(".fate-list tbody tr")).to_have_count(len(own))
    expect(page.locator(".map .fate")).to_have_count(len(own))
    page.get_by_role("button", name="follower").click()
    page.get_by_label("Name", exact=True).fill("las")
    expect(page.locator(".fate-list tbody tr")).to_have_count(1)
    expect(page.locator(".carrier-look")).to_have_count(1)
    page.locator(".carrier-look").click()
    expect(page.locator(".fate-list .row-now")).to_contain_text("Las Vegas")
    page.get_by_label("Name", exact=True).fill("")
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    fit_a_phone(page)


def test_a_fleet_is_changed_and_revised(open_page, service, fleet):
    asked, before = fleet
    page = open_page(f"/campaigns/{before['id']}")
    page.get_by_role("link", name="Revise", exact=True).click()
    carriers = page.get_by_test_id("carrier")
    expect(carriers).to_have_count(3)
    carriers.nth(2).get_by_label("Carrier", exact=True).fill("survey")
    carriers.nth(2).get_by_label("Platform").select_option("agile-cmg")
    page.get_by_role("button", name="Another carrier").click()
    expect(carriers).to_have_count(4)
    carriers.nth(3).get_by_role("button", name="Remove 4").click()
    changed = json.loads(page.get_by_label("Request as JSON").input_value())
    assert [one["id"] for one in changed["carriers"]] == ["station", "follower", "survey"]
    assert changed["carriers"][:2] == asked["carriers"][:2]
    assert changed["carriers"][2] == asked["carriers"][2] | {
        "id": "survey",
        "platform": "agile-cmg",
    }
    page.get_by_label("Passes that begin before it stay").fill("2015-02-27T18:00:00")
    assert violations(page) == []
    page.get_by_role("button", name="Revise the campaign").click()
    expect(page.get_by_text("of an earlier campaign")).to_be_visible(timeout=PATIENCE_MS)
    found = httpx.get(f"{service.address}/v1/campaigns/{page.url.rsplit('/', 1)[1]}").json()
    assert found["revises"] == before["id"]
    assert found["choice"]["revision"]["frozen"]
    page.get_by_role("link", name="Revise", exact=True).click()
    page.get_by_role("button", name="Revise the campaign").click()
    expect(page.get_by_text("of an earlier campaign")).to_be_visible(timeout=PATIENCE_MS)
    again = httpx.get(f"{service.address}/v1/campaigns/{page.url.rsplit('/', 1)[1]}").json()
    assert again["revises"] == found["id"]


def test_the_last_of_several_carriers_is_the_campaigns_own(open_page, fleet):
    asked, told = fleet
    page = open_page(f"/campaigns?from={told['id']}")
    page.get_by_role("button", name="Remove smallsat").click()
    page.get_by_role("button", name="Remove follower").click()
    expect(page.get_by_test_id("carrier")).to_have_count(0)
    single = json.loads(page.get_by_label("Request as JSON").input_value())
    station = asked["carriers"][0]
    own = {name: station[name] for name in ("platform", "orbit", "attitude")}
    assert single == {name: asked[name] for name in asked if name != "carriers"} | own
    page.get_by_role("button", name="Another carrier").click()
    both = json.loads(page.get_by_label("Request as JSON").input_value())["carriers"]
    assert both == [own | {"id": "1"}, own | {"id": "2"}]


def test_a_target_left_out_for_the_memory_says_so(open_page, service):
    asked = json.loads((ROOT / "examples/campaign_resources.json").read_text())
    kept = made(service, "/v1/campaigns", asked)
    page = open_page(f"/campaigns/{kept['id']}")
    [boston] = [one for one in kept["choice"]["left_out"] if one["target"] == "Boston"]
    expect(outcome(page, "Boston")).to_contain_text("left out for the memory")
    expect(outcome(page, "Boston")).to_contain_text(boston["because"])
    assert violations(page) == []


def test_places_that_were_taken_for_names_are_told(open_page, service):
    [first, *_] = EXAMPLE["targets"]
    by_name = first | {"id": "The town", "target": {"mode": "place", "name": "Las Vegas"}}
    made_of_it = made(service, "/v1/campaigns", EXAMPLE | {"targets": [by_name]})
    [assumed] = made_of_it["choice"]["assumed"]
    page = open_page(f"/campaigns/{made_of_it['id']}")
    told = page.get_by_role("region", name="Places taken for names").get_by_role("listitem")
    expect(told).to_have_text([f"Taken for The town: {assumed['detail']}"])
    assert violations(page) == []


def test_targets_of_a_file_are_asked_for_and_their_progress_is_shown(open_page, tmp_path):
    file = tmp_path / "towns.csv"
    file.write_text(
        "name,lat,lon,priority,session_s\n"
        'Ljubljana,46.05,14.51,2,30\n"Graz, Styria",47.07,15.44,1,30\n'
    )
    page = open_page("/campaigns")
    page.get_by_label("Choose a file of targets").set_input_files(file)
    expect(page.get_by_role("rowheader", name="Graz, Styria", exact=True)).to_be_visible()
    page.get_by_label("High Sun").fill("1")
    page.get_by_label("High Sun").press("Tab")
    asked = json.loads(page.get_by_label("Request as JSON").input_value())
    assert [one["id"] for one in asked["targets"]] == ["Ljubljana", "Graz, Styria"]
    assert asked["targets"][0]["priority"] == 2
    assert asked["view"] == {"sun": 1}
    page.get_by_role("button", name="Choose the looks").click()
    page.wait_for_url(re.compile(r"/campaigns/[0-9a-z-]+$"))
    expect(page.get_by_test_id("campaign-verdict")).to_be_visible(timeout=PATIENCE_MS)


def test_targets_are_added_weighed_and_removed_in_place(open_page):
    page = open_page("/campaigns")
    asked = page.get_by_label("Request as JSON")

    def targets():
        return json.loads(asked.input_value())["targets"]

    page.get_by_role("combobox", name="Add a target").fill("Ljub")
    page.get_by_role("option", name="Ljubljana, SI").click()
    expect(page.get_by_role("rowheader", name="Ljubljana", exact=True)).to_be_visible()
    assert targets()[-1]["target"] == {"mode": "place", "name": "Ljubljana, SI"}
    page.get_by_label("Map of the targets").click(position={"x": 200, "y": 200})
    expect(
        page.get_by_role("heading", name=f"Targets {len(EXAMPLE['targets']) + 2}")
    ).to_be_visible()
    assert targets()[-1]["target"]["mode"] == "ground"
    page.get_by_label("Priority of Ljubljana").fill("7")
    page.get_by_label("Length of a look at Ljubljana, s").fill("25")
    page.get_by_role("button", name="Remove Boston").click()
    known = {one["id"]: one for one in targets()}
    assert (known["Ljubljana"]["priority"], known["Ljubljana"]["session_s"]) == (7, 25)
    assert "Boston" not in known
    assert violations(page) == []
    # Conditions stand beside the time.
    page.get_by_label("Least elevation, °").fill("40")
    page.get_by_label("Least Sun elevation, °").fill("")
    page.get_by_label("Greatest off-nadir angle, °").fill("45")
    page.get_by_label("Days").fill("2")
    page.get_by_label("Days").press("Tab")
    page.get_by_label("Platform", exact=True).select_option("smallsat-120kg")
    whole = json.loads(asked.input_value())
    assert whole["conditions"] == {"min_elevation_deg": 40, "max_off_nadir_deg": 45}
    assert whole["stop"] == "2015-03-01T12:00:00Z"
    assert whole["platform"] == "smallsat-120kg"
    assert "attitude" not in whole  # of a carrier of axes


def test_imaging_modes_have_no_length_and_are_kept_as_they_are(open_page):
    page = open_page("/campaigns")
    modes = json.loads((ROOT / "examples/campaign_modes.json").read_text())
    asked = page.get_by_label("Request as JSON")
    asked.fill(json.dumps(modes))
    expect(page.get_by_role("cell", name="Stereo pair", exact=True)).to_be_visible()
    expect(page.locator(".map .fate-open")).to_have_count(4)
    expect(page.get_by_label("Length of a look at")).to_have_count(0)
    page.get_by_label("Priority of area").fill("3")
    page.get_by_label("Priority of area").press("Tab")
    modes["targets"][3]["priority"] = 3
    assert json.loads(asked.input_value()) == modes
    # One more is drawn on the map, and turned by a roll of its own.
    expect(page.locator(".map .asked-shape")).to_have_count(4)
    page.get_by_label("Corridor", exact=True).check()
    world = page.get_by_role("application", name="Map: arrows move the cross")
    world.focus()
    for key in ("Enter", "ArrowRight", "Enter", "ArrowUp", "Enter"):
        world.press(key)
    page.get_by_role("button", name="Finish").click()
    expect(page.locator(".map .asked-shape")).to_have_count(5)
    page.get_by_role("button", name="More of corridor 2", exact=True).click()
    page.locator("summary", has_text="Roll").click()
    page.get_by_label("Roll: kind").select_option("azimuth")
    drawn = json.loads(asked.input_value())["targets"][-1]
    assert (drawn["id"], drawn["target"]["mode"]) == ("corridor 2", "corridor")
    assert len(drawn["target"]["geometry"]["coordinates"]) == 3
    assert drawn["roll"]["rule"] == "azimuth"
    assert "session_s" not in drawn
    assert violations(page) == []


def test_names_that_may_mean_several_places_are_resolved_in_their_rows(open_page):
    page = open_page("/campaigns")
    for name in ("Springfield", "Newcastle"):
        page.get_by_role("combobox", name="Add a target").fill(name)
        page.get_by_role("button", name="Add", exact=True).click()
    chosen = {"Springfield": "Springfield, Illinois, US", "Newcastle": "Newcastle, AU"}
    send = page.get_by_role("button", name="Choose the looks")
    while chosen:
        send.click()
        expect(page.locator(".row-wrong").first).to_be_visible()
        told = [name for name in chosen if row_of(page, name).locator(".wrong").count()]
        for name in told:
            row_of(page, name).get_by_role("button", name=chosen.pop(name), exact=True).click()
            expect(row_of(page, name).locator(".wrong")).to_have_count(0)
    asked = json.loads(page.get_by_label("Request as JSON").input_value())
    assert [one["target"]["name"] for one in asked["targets"][-2:]] == [
        "Springfield, Illinois, US",
        "Newcastle, AU",
    ]


def row_of(page, name):
    return page.locator(".targets tr").filter(has_text=name)


def test_looks_and_plans_are_taken_away_and_a_pass_leads_to_its_plan(open_page, campaign):
    page = open_page(f"/campaigns/{campaign['id']}")
    looks = [look["target"] for one in campaign["passes"] for look in one["looks"]]
    files = {}
    for button in ("Looks, CSV", "Looks, GeoJSON", "Looks, KML", "All plans, zip"):
        with page.expect_download() as download:
            page.get_by_role("button", name=button).click()
        files[Path(download.value.suggested_filename).suffix] = Path(download.value.path())
    assert [line.split(",")[1] for line in files[".csv"].read_text().splitlines()[1:]] == looks
    features = json.loads(files[".geojson"].read_text())["features"]
    assert [feature["properties"]["name"] for feature in features] == looks
    assert all(target in files[".kml"].read_text() for target in looks)
    with zipfile.ZipFile(files[".zip"]) as archive:
        numbers = range(1, len(campaign["passes"]) + 1)
        assert {f"pass-{number}.csv" for number in numbers} <= set(archive.namelist())
    page.get_by_role("link", name="Plan of pass 1").click()
    expect(page.get_by_test_id("verdict")).to_contain_text("Passed")
    assert page.url.endswith(campaign["passes"][0]["plan"])


def test_a_file_without_targets_is_told_by_its_line(open_page, tmp_path):
    file = tmp_path / "towns.csv"
    file.write_text("id,latitude_deg,longitude_deg\nLjubljana,46.05,14.51\nGraz,north,15.44\n")
    page = open_page("/campaigns")
    page.get_by_label("Choose a file of targets").set_input_files(file)
    expect(page.get_by_role("alert")).to_contain_text("line 3: latitude_deg")
    expect(page.get_by_role("rowheader", name="Las Vegas")).to_be_visible()
    # A refusal names its field, and nothing typed is lost.
    wrong = EXAMPLE | {"step_s": 0.5}
    page.get_by_label("Request as JSON").fill(json.dumps(wrong))
    page.get_by_role("button", name="Choose the looks").click()
    expect(page.get_by_role("alert").last).to_contain_text("step_s")
    assert json.loads(page.get_by_label("Request as JSON").input_value()) == wrong


def test_work_is_cancelled_where_it_is_shown_and_asked_for_again(open_page, service):
    page = open_page(f"/campaigns/{long_campaign(service, 'Long work, looked at')}")
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_text("It was cancelled.")).to_be_visible()
    assert violations(page) == []
    page.get_by_role("link", name="Change the request").click()
    expect(page.get_by_role("heading", name="Targets 630")).to_be_visible()


def test_every_printed_page_says_which_campaign_it_is_of(open_page, campaign):
    page = open_page(f"/campaigns/{campaign['id']}", color_scheme="dark")
    expect(page.get_by_test_id("campaign-verdict")).to_be_visible()
    page.emulate_media(media="print")
    margins = page.evaluate(
        "document.adoptedStyleSheets.map(one => [...one.cssRules].map(rule => rule.cssText)).join()"
    )
    for part in ("Cities, 27 Feb 2015", campaign["id"], "iss-hrc", "Planned", "Approved"):
        assert part in margins
    expect(page.locator("header:visible, .fate-list:visible")).to_have_count(1)
    assert (
        page.evaluate("getComputedStyle(document.querySelector('.fate-list')).maxHeight") == "none"
    )
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(23, 33, 46)"
