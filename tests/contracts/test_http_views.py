"""A plan's view over HTTP holds what there is to see, in every format."""

import io
import json
import math
from datetime import datetime

import numpy as np
import pytest
from jsonschema_rs import Draft202012Validator
from lxml import etree
from PIL import Image
from refusal_cases import request
from scipy.io import netcdf_file
from scipy.spatial.transform import Rotation

from app.http.routes.plan_routes import SEEN_AS
from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES, SPACECRAFT_EXAMPLES
from app.requests.plan import read_plan_request
from app.work.view import DRAWN
from planner.motion.pointing.angles import boresight_platform

FILL = 9.969209968386869e36  # NetCDF's own default for doubles
STRIP = SPACECRAFT_EXAMPLES["geojson"][1] | {"simulation_runs": 0}
SUN_CONE = next(
    example for _, example in PLAN_EXAMPLES.values() if example.get("slew", {}).get("keep_out")
)


def made(client, document, path="/v1/plans"):
    return client.made(path, json=document)


@pytest.fixture(scope="module")
def plan(client):
    return made(client, LAS_VEGAS)


@pytest.fixture(scope="module")
def session(client):
    return made(client, STRIP, "/v1/spacecraft/plans")


def seen(client, plan, query="", path="/v1/plans"):
    answer = client.get(f"{path}/{plan['id']}/view{query}")
    assert answer.status_code == 200, answer.text
    return answer


def refused(client, plan, query):
    answer = client.get(f"/v1/plans/{plan['id']}/view{query}")
    assert answer.status_code == 422, answer.text
    return answer.json()


@pytest.fixture(scope="module")
def view(client, plan):
    return seen(client, plan, "?step_s=0.2").json()


def wrong(client, schema, document):
    components = client.app.openapi()["components"]
    check = Draft202012Validator(
        {"$ref": f"#/components/schemas/{schema}", "components": components}
    )
    return [error.message for error in check.iter_errors(document)]


def columns(section):
    return {name: values for name, values in section.items() if isinstance(values, list)}


def row_at(view, text):
    since = datetime.fromisoformat(text) - datetime.fromisoformat(view["epoch"])
    return view["t_s"].index(round(since.total_seconds(), 1))


def test_views_are_as_the_schema_says(client, plan, session, view):
    assert wrong(client, "PlanViewResponse", view) == []
    whole = seen(client, session, path="/v1/spacecraft/plans").json()
    assert wrong(client, "PlanViewResponse", whole) == []


def test_every_column_has_a_line_for_every_row(view, plan):
    rows = len(plan["table"]["t_s"])
    assert view["t_s"] == plan["table"]["t_s"]
    assert len(view["activity"]) == len(view["session"]) == rows
    sections = [view[name] for name in ("carrier", "boresight", "footprint", "sun", "moon")]
    target = {k: v for k, v in view["targets"][0].items() if k != "windows"}
    for section in (*sections, view["pointing"], target, *view["axes"].values()):
        assert columns(section)
        for name, values in columns(section).items():
            assert len(values) == rows, name


def test_the_axes_are_the_tables(view, plan):
    for axis in ("alpha", "beta"):
        motion, margins = view["axes"][axis], plan["margins"][axis]
        assert motion["angle_deg"] == plan["table"][f"{axis}_deg"]
        assert motion["rate_deg_s"] == plan["table"][f"{axis}_rate_deg_s"]
        for order, limit in (("acceleration_deg_s2", "acceleration"), ("jerk_deg_s3", "jerk")):
            # the judge looks at both ends of each cell, the view at one: a row's jerk apart
            largest = max(map(abs, motion[order]))
            assert largest == pytest.approx(abs(margins[limit]["extreme"]), rel=0.02)
            assert view["limits"][axis][f"{limit}_max_{order.split('_', 1)[1]}"] == pytest.approx(
                margins[limit]["limit"]
            )


def test_a_session_is_seen_as_its_plan_tells(view, plan):
    [told], [target] = plan["pointing"], view["targets"]
    first, last = row_at(view, target["start"]), row_at(view, target["stop"])
    inside = slice(first, last + 1)
    assert min(target["elevation_deg"][inside]) == pytest.approx(told["elevation_min_deg"], 1e-5)
    assert min(target["range_m"][inside]) == pytest.approx(1e3 * told["range_min_km"], 1e-6)
    assert view["activity"][first] == "track"
    assert view["activity"][first - 1] == "slew"
    assert set(view["session"]) == {0}
    off = view["pointing"]["error_arcsec"]
    assert max(off[inside]) < 0.1
    assert {*off[:first], *off[last + 1 :]} == {None}


def test_the_ellipse_is_that_of_the_budget(view, plan):
    """The budget tells the mean of both axes at the worst of eleven instants."""
    pointing = view["pointing"]
    squares = [
        (major**2 + minor**2) / 2.0
        for major, minor in zip(
            pointing["sigma_major_arcsec"], pointing["sigma_minor_arcsec"], strict=True
        )
        if major is not None
    ]
    [budget] = plan["uncertainty"]
    assert math.sqrt(max(squares)) == pytest.approx(budget["sigma_arcsec"], rel=1e-3)


def test_the_boresight_is_on_the_target(view):
    [target] = view["targets"]
    row = row_at(view, target["stop"])
    apart_deg = abs(view["boresight"]["latitude_deg"][row] - target["latitude_deg"][row])
    # its height, 610 m, is seen from 69 deg elevation: 0.002 deg
    assert apart_deg < 0.01
    corners = view["footprint"]["latitude_deg"][row]
    assert min(corners) < target["latitude_deg"][row] < max(corners)


def test_the_cameras_frame_is_the_papers(view):
    km = 350.0 * 2.0 * np.tan(np.radians(view["frame_deg"]) / 2.0)
    np.testing.assert_allclose(
        km, [5.36, 3.56], atol=0.005
    )  # the last printed digit, on the ground


def test_at_a_keyhole_the_boresight_is_in_the_plane_of_the_axes(view):
    platform = read_plan_request(json.dumps(LAS_VEGAS).encode()).platform
    outer, inner = platform.axes_platform
    turns = Rotation.from_rotvec(np.radians(view["keyholes_deg"])[:, None] * inner)
    across = turns.apply(platform.zero_direction_platform) @ np.cross(outer, inner)
    np.testing.assert_allclose(across, 0.0, atol=1e-10)  # the angles' last digit is 1e-9 deg
    assert len(across) == 2


def test_the_window_around_the_session(view):
    [target] = view["targets"]
    [window] = target["windows"]
    assert window["rise"] < target["start"] < target["stop"] < window["set"]
    assert window["closed_by"] == "elevation"


def test_the_baseline_is_the_comparisons(view, plan):
    [slew], [comparison] = view["baseline"], plan["comparison"]
    first, last = (view["t_s"].index(slew["t_s"][k]) for k in (0, -1))
    for axis in ("alpha", "beta"):
        motion = slew["axes"][axis]
        # the largest on rows beside the largest anywhere
        spline = comparison["spline"][axis]
        assert max(map(abs, motion["rate_deg_s"])) == pytest.approx(
            spline["peak_rate_deg_s"], rel=1e-3
        )
        table = view["axes"][axis]["angle_deg"]
        assert motion["angle_deg"][0] == pytest.approx(table[first], abs=1e-9)
        # what its filter leaves; the view aims by three rows' acceleration: 0.01 arcsec
        off_deg = motion["angle_deg"][-1] - table[last]
        assert off_deg == pytest.approx(spline["end_error_arcsec"] / 3600.0, abs=0.01 / 3600.0)


def test_cones_and_their_outlines(client):
    plan = made(client, SUN_CONE)
    view = seen(client, plan).json()
    assert wrong(client, "PlanViewResponse", view) == []
    for cone, margin in zip(view["keep_out"], plan["keep_out"], strict=True):
        assert cone["half_angle_deg"] == margin["half_angle_deg"]
        in_force = [
            away
            for away, counts in zip(cone["separation_deg"], cone["counts"], strict=True)
            if counts
        ]
        if margin["away_min_deg"] is not None:
            assert min(in_force) == pytest.approx(margin["away_min_deg"], abs=0.1)  # a step's turn
        outlines = np.array(cone["outline_deg"]["alpha"], dtype=float)
        assert outlines.shape == (len(cone["outline_t_s"]), 2, 37)
        np.testing.assert_array_equal(outlines[..., 0], outlines[..., -1])


def test_masks_and_their_outlines(client):
    """The boresight comes as near as the plan says; the outline is where the boresight would be."""
    arm = {
        "name": "arm",
        "margin_deg": 1.0,
        "corners_platform": [
            [0.2, 4.0, 1.2], [0.7, 4.0, 1.2], [0.8, 1.5, 2.5], [1.7, 0.9, 2.4], [1.6, 0.6, 2.5],
            [0.5, 1.1, 2.7],
        ],
    }  # fmt: skip
    named = client.get("/v1/platforms").json()["platforms"][0]
    state = LAS_VEGAS["initial_state"] | {"angles_deg": {"alpha": 30.0, "beta": -50.0}}
    beside = {"platform": named | {"name": "beside an arm", "masks": [arm]}, "initial_state": state}
    plan = made(client, LAS_VEGAS | beside)
    view = seen(client, plan, "?step_s=0.2").json()
    assert wrong(client, "PlanViewResponse", view) == []
    [mask], [margin] = view["masks"], plan["masks"]
    assert (mask["name"], mask["asked_deg"]) == ("arm", 1.0)
    assert len(mask["away_deg"]) == len(view["t_s"])
    assert min(mask["away_deg"]) == pytest.approx(margin["away_min_deg"], abs=0.1)  # a row's turn
    outline = np.array(mask["outline_platform"])
    np.testing.assert_array_equal(outline[0], outline[-1])
    corners = np.array(arm["corners_platform"])
    corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    for corner in corners:
        assert np.linalg.norm(outline - corner, axis=1).min() < 1e-5
    platform = read_plan_request(json.dumps(LAS_VEGAS).encode()).platform
    pairs_deg = np.array([mask["outline_deg"][axis] for axis in ("alpha", "beta")], dtype=float)
    told = np.isfinite(pairs_deg).all(axis=0)
    assert told.any()
    for way in range(2):
        there = boresight_platform(platform, np.radians(pairs_deg[:, way, told[way]].T))
        np.testing.assert_allclose(there, outline[told[way]], atol=2e-5)  # 0.001 deg
    with netcdf_file(io.BytesIO(seen(client, plan, "?step_s=0.2&format=netcdf").content)) as file:
        away_deg = file.variables["mask_away_deg"][:].copy()
        lies = file.variables["mask_outline_platform"][:].copy()
        assert file.mask_names == b"arm"
    np.testing.assert_allclose(away_deg, [mask["away_deg"]], atol=1e-6)
    np.testing.assert_allclose(lies, outline, atol=1e-6)


def test_the_step_is_chosen_or_asked_for(client, plan):
    rows = len(plan["table"]["t_s"])
    chosen = seen(client, plan).json()
    assert len(chosen["t_s"]) <= 1000
    assert chosen["t_s"][-1] == plan["table"]["t_s"][-1]
    coarse = seen(client, plan, "?step_s=7").json()
    assert coarse["step_s"] == 7.0
    assert coarse["t_s"] == [*np.arange(0, rows - 1, 35) / 5.0, (rows - 1) / 5.0]
    one_row = seen(client, plan, "?step_s=86400").json()
    assert one_row["t_s"] == [0.0, (rows - 1) / 5.0]


@pytest.mark.parametrize(
    "step",
    ["0", "-1", "0.1", "0.3", "nan", "inf", "1e308", "86400.2", "x", "", "0.2000001", "1_0", " 1"],
)
def test_a_step_that_can_not_be_taken(client, plan, step):
    problem = refused(client, plan, f"?step_s={step}")
    assert problem["field"] == "query.step_s"
    assert any(way in problem["detail"] for way in ("a number", "more than 0", "multiple"))


def test_a_step_of_too_many_rows_names_one_that_works(client):
    """A day of waiting before the session."""
    early = request(("initial_state.epoch", "2015-02-26T18:00:00Z"))
    plan = made(client, early)
    problem = refused(client, plan, "?step_s=0.2")
    assert problem["field"] == "query.step_s"
    least_s = float(problem["detail"].split("use ")[1].split(" or")[0])
    assert len(seen(client, plan, f"?step_s={least_s}").json()["t_s"]) <= 20_000


@pytest.mark.parametrize("query", ["pixel_arcsec=0", "pixel_arcsec=nan", "steps=1", "format=xlsx"])
def test_other_parameters_are_checked(client, plan, query):
    name = query.split("=")[0]
    assert refused(client, plan, f"?{query}")["field"] == f"query.{name}"


def test_a_pixel_is_as_wide_as_asked(client, plan):
    narrow, wide = (
        seen(client, plan, f"?step_s=10&pixel_arcsec={angle}").json() for angle in (1.0, 2.0)
    )
    first, second = (one["targets"][0]["ground_sample_across_m"][-1] for one in (narrow, wide))
    assert second == pytest.approx(2.0 * first, abs=1e-3)  # told to the millimetre
    assert first == pytest.approx(
        narrow["targets"][0]["range_m"][-1] * math.radians(1.0 / 3600.0), abs=1e-3
    )


def test_what_is_seen_is_known_again(client, plan):
    answer = seen(client, plan)
    tag = answer.headers["etag"]
    path = f"/v1/plans/{plan['id']}/view"
    again = client.get(path, headers={"If-None-Match": tag})
    assert again.status_code == 304
    assert seen(client, plan).content == answer.content
    assert seen(client, plan, "?step_s=1").headers["etag"] != tag
    assert client.head(path).status_code == 200


def test_it_is_not_computed_for_who_has_it(client, plan, monkeypatch):
    """As browsers ask again for what they keep."""
    first = seen(client, plan, "?step_s=3")

    def not_again(*_):
        raise AssertionError("it was computed once more")

    monkeypatch.setattr("app.http.routes.plan_routes.in_child", not_again)
    path, tag = f"/v1/plans/{plan['id']}/view?step_s=3", first.headers["etag"]
    assert client.get(path, headers={"If-None-Match": tag}).status_code == 304


def test_what_is_not_there(client):
    assert client.get("/v1/plans/01a203fd-cbae-73f8-8276-319f76b8842c/view").status_code == 404
    low = request(("sessions.0.target.min_elevation_deg", 89.0))
    client.post("/v1/plans", json=low)
    [plan] = client.get("/v1/plans?state=refused&limit=1").json()["plans"]
    answer = client.get(f"/v1/plans/{plan['id']}/view")
    assert answer.status_code == 409
    assert "refused" in answer.json()["detail"]


def test_a_plan_that_failed_can_be_looked_at_but_not_taken_along(client):
    plan = made(client, {**LAS_VEGAS, "slew": {"method": "spline"}})
    view = seen(client, plan).json()
    assert view["verified"] is False
    assert view["baseline"] == []
    assert max(off for off in view["pointing"]["error_arcsec"] if off is not None) > 0.1
    for name in ("netcdf", "png"):
        problem = refused(client, plan, f"?format={name}")
        assert problem["type"] == "urn:slewtrack:problem:unverified"


@pytest.mark.parametrize("name", ["json", *SEEN_AS])
def test_every_format_by_name_and_media_type(client, plan, name):
    answer = seen(client, plan, f"?format={name}")
    media_type = answer.headers["content-type"].split(";")[0]
    by_type = client.get(f"/v1/plans/{plan['id']}/view", headers={"Accept": media_type})
    assert by_type.content == answer.content
    if name != "json":
        suffix = SEEN_AS[name].suffix
        disposition = answer.headers["content-disposition"]
        how = "inline" if media_type.startswith("image/") else "attachment"
        assert disposition == f'{how}; filename="Las-Vegas{suffix}"'
    if name in DRAWN:
        assert client.get(f"/v1/plans/{plan['id']}/table?format={name}").content == answer.content


def test_netcdf_holds_the_same(client, plan, view):
    content = seen(client, plan, "?format=netcdf&step_s=0.2").content
    with netcdf_file(io.BytesIO(content), mmap=False) as file:
        compared = 0
        for section in ("carrier", "boresight", "footprint", "sun", "moon", "pointing"):
            for name, values in view[section].items():
                compare(file.variables[f"{section}_{name}"], np.array(values, dtype=float))
                compared += 1
        for name, values in columns(view["targets"][0]).items():
            if name != "windows":
                compare(file.variables[f"target_{name}"], np.array([values], dtype=float))
                compared += 1
        for axis, motion in view["axes"].items():
            compare(file.variables[f"{axis}_deg"], np.array(motion["angle_deg"]))
            compare(file.variables[f"{axis}_jerk_deg_s3"], np.array(motion["jerk_deg_s3"]))
        [slew] = view["baseline"]
        compare(file.variables["baseline_t_s"], np.array(slew["t_s"]))
        compare(
            file.variables["baseline_alpha_rate_deg_s"],
            np.array(slew["axes"]["alpha"]["rate_deg_s"]),
        )
        assert file.variables["window_session"][:].tolist() == [0]
        assert file.variables["session"][:].tolist() == view["session"]
        assert compared > 30


def compare(variable, expected):
    told = np.where(variable[:] == FILL, np.nan, variable[:])
    # the JSON's rounding: half of 1e-6 deg, 1e-4 arcsec, 1e-3 m
    np.testing.assert_allclose(told, expected, rtol=0, atol=6e-4)


def test_the_map_holds_track_swath_footprints_and_target(client, plan, view):
    shown = seen(client, plan, "?format=geojson").json()
    kinds = [feature["properties"]["kind"] for feature in shown["features"]]
    assert {"track", "boresight", "footprint", "swath", "target"} == {*kinds}
    by_kind = dict(zip(kinds, shown["features"], strict=True))
    track = by_kind["track"]["geometry"]["coordinates"]
    assert track[0] == [view["carrier"][f"{name}itude_deg"][0] for name in ("long", "lat")]
    place = by_kind["target"]["geometry"]["coordinates"]
    assert place == pytest.approx([-115.1728, 36.1147, 610.0])
    for kind in ("footprint", "swath"):
        [ring] = by_kind[kind]["geometry"]["coordinates"]
        assert ring[0] == ring[-1]
        assert around(np.array(ring), place[:2])


def around(ring, place):
    """Whether a ring leads counter-clockwise around a place."""
    off = ring - place
    turn = np.diff(np.unwrap(np.arctan2(off[:, 1], off[:, 0]))).sum()
    return turn == pytest.approx(2.0 * np.pi)


def test_kml_holds_the_same_map(client, plan):
    shown = seen(client, plan, "?format=geojson").json()
    kml = etree.fromstring(seen(client, plan, "?format=kml").content)
    space = {"k": "http://www.opengis.net/kml/2.2"}
    marks = kml.findall(".//k:Placemark", space)
    assert len(marks) == len(shown["features"])
    track = next(one for one in marks if one.findtext("k:styleUrl", None, space) == "#track")
    places = track.findtext(".//k:coordinates", None, space).split()
    expected = shown["features"][0]["geometry"]["coordinates"]
    np.testing.assert_allclose([[*map(float, p.split(","))] for p in places], expected, atol=1e-6)


def test_pictures_are_pictures(client, plan, session):
    for path, one in (("/v1/plans", plan), ("/v1/spacecraft/plans", session)):
        with Image.open(io.BytesIO(seen(client, one, "?format=png", path).content)) as picture:
            assert picture.format == "PNG"
            assert picture.width == 1200
            assert len(picture.getcolors(1 << 20)) > 5
        drawn = etree.fromstring(seen(client, one, "?format=svg", path).content)
        assert drawn.tag == "{http://www.w3.org/2000/svg}svg"
        texts = " ".join(drawn.itertext())
        assert "UTC on 20" in texts
        assert one["name"] in texts


def test_names_and_the_ground_track_are_on_the_globe(client, plan):
    packets = {one["id"]: one for one in seen(client, plan, "?format=czml").json()}
    assert packets["target-0"]["label"]["text"]
    track = packets["ground-track"]["polyline"]
    assert track["clampToGround"] is True
    degrees = np.reshape(track["positions"]["cartographicDegrees"], (-1, 3))
    shown = seen(client, plan, "?format=geojson").json()["features"][0]
    np.testing.assert_allclose(degrees[:, :2], shown["geometry"]["coordinates"], atol=1e-6)


def test_an_imaging_session_is_seen_as_the_plan_of_its_body(client, session):
    view = seen(client, session, "?step_s=0.2", "/v1/spacecraft/plans").json()
    assert view == seen(client, session, "?step_s=0.2").json()
    table, gyros = session["table"], view["gyros"]
    rates = np.transpose([view["axes"][axis]["rate_deg_s"] for axis in "xyz"])
    np.testing.assert_allclose(rates, table["omega_body_deg_s"], atol=1e-9)
    assert gyros["gimbal_deg"] == table["gimbal_deg"]
    # What the gyros hold keeps to what the judge found of it, and to the sphere.
    most_n_m_s = np.max(np.linalg.norm(gyros["momentum_n_m_s"], axis=1))
    judged_n_m_s = session["verification"]["momentum_max_n_m_s"]
    assert most_n_m_s == pytest.approx(judged_n_m_s, rel=0.01)  # which looks between rows too
    assert judged_n_m_s < gyros["momentum_max_n_m_s"] == 60.0
    [window], [target] = session["windows"], view["targets"]
    for end in ("start", "stop"):
        assert datetime.fromisoformat(target[end]) == datetime.fromisoformat(window[end])
    rows = range(window["first_row"], window["last_row"])
    assert {view["activity"][row] for row in rows} == {"track"}
    ends = [[view["boresight"][f"{name}_deg"][row] for name in ("longitude", "latitude")]
            for row in (window["first_row"], window["last_row"])]  # fmt: skip
    [feature] = STRIP["requests"]["features"]
    for end in ends:
        nearest = min(np.abs(np.subtract(end, place)).max() for place in
                      feature["geometry"]["coordinates"])  # fmt: skip
        assert nearest < 0.009  # the last row is within a row's 1.1 km of the strip's end
    north, east = (
        np.array(view["footprint"][f"{name}_deg"][rows[0]]) for name in ("latitude", "longitude")
    )
    corners = 111.2e3 * np.stack([north, east * np.cos(np.radians(north[0]))], axis=1)
    widths_m = np.linalg.norm(corners[:, None] - corners, axis=2)
    assert widths_m.max() == pytest.approx(12e3, rel=0.05)  # off nadir widens it by 2 to 4 %


def test_an_imaging_session_on_the_map_and_the_globe(client, session):
    shown = seen(client, session, "?format=geojson", "/v1/spacecraft/plans").json()
    kinds = [feature["properties"]["kind"] for feature in shown["features"]]
    assert {*kinds} == {"track", "boresight", "swath", "footprint", "target"}
    swath, asked = (shown["features"][kinds.index(kind)] for kind in ("swath", "target"))
    middle = np.mean(asked["geometry"]["coordinates"], axis=0)
    rings = [np.array(ring) for [ring] in swath["geometry"]["coordinates"]]
    assert any(around(ring, middle) for ring in rings)
    packets = seen(client, session, "?format=czml", "/v1/spacecraft/plans").json()
    ids = {packet["id"] for packet in packets}
    assert ids >= {"document", "carrier", "ground-track", "boresight", "footprint", "target-0"}


def what_is_drawn(example):
    """All of a plan that its pictures hang on, whatever its orbit comes from."""
    seen = tuple((one["target"]["mode"], "keyhole" in one) for one in example["sessions"])
    more = example.get("slew", {}).keys() & {"keep_out", "avoid_modes", "lead"}
    platform = example["platform"]
    masked = isinstance(platform, dict) and "masks" in platform
    return seen, masked, frozenset(more), "final_state" in example, "terrain" in example


# The first of those that are drawn alike.
DRAWN_ONCE = {what_is_drawn(one): name for name, (_, one) in reversed(PLAN_EXAMPLES.items())}


@pytest.mark.parametrize("name", PLAN_EXAMPLES)
def test_every_worked_example_is_planned_and_can_be_looked_at(client, name):
    plan = made(client, PLAN_EXAMPLES[name][1])
    assert wrong(client, "PlanResponse", plan) == []
    assert plan["verification"]["passed"] or name == "spline"
    view = seen(client, plan).json()
    assert wrong(client, "PlanViewResponse", view) == []
    assert len(view["targets"]) == len(PLAN_EXAMPLES[name][1]["sessions"])
    if plan["state"] == "done" and name in DRAWN_ONCE.values():
        for drawn in ("netcdf", *DRAWN.keys() - {"svg"}):  # which is the PNG's figure
            assert seen(client, plan, f"?format={drawn}").content


def test_json_holds_no_nan(client, plan):
    def refuse(constant):
        raise AssertionError(constant)

    json.loads(seen(client, plan).content, parse_constant=refuse)
