"""Heights of the ground from grids: files by GDAL, grids whose heights are known everywhere."""

import base64
import copy
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import given, settings
from hypothesis import strategies as st
from planner_values import plan_of, read_request

from app.cli.changes import with_settings
from app.requests.campaign import read_campaign_request
from app.requests.examples import PLAN_EXAMPLES, message
from app.requests.plan import read_plan_request
from app.store.packed import pack, unpack
from app.work.campaign import choose
from app.work.plan import packed_plan, stored_plan
from app.work.searches import read_opportunity_request
from planner.base.errors import InvalidMessage, InvalidRequest, VerificationFailed
from planner.planning.opportunities import find_opportunities
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.messages.geographic_grid import read_ascii_grid, read_geotiff
from planner.world.targets import GroundPathTarget, GroundTarget
from planner.world.targets.ground_path import PathPoint
from planner.world.targets.terrain import Terrain

FILES = Path(__file__).parents[1] / "data/terrain"
WHOLE = sorted({path.name for path in FILES.glob("*.tif")} - {"utm.tif", "int16_lzw_tiled.tif"})
ASC = message("terrain.asc")
OVER_TERRAIN = PLAN_EXAMPLES["terrain"][1]
START = utc_from_text("2015-02-27T17:36:20Z")
PLACE = {"latitude_deg": 36.12, "longitude_deg": -115.17}


def known_m(latitude_deg, longitude_deg):
    """Of the files: 10 column + 7 row + row column."""
    row = (38.0 - latitude_deg) / 0.02 - 0.5
    column = (longitude_deg + 5.0) / 0.01 - 0.5
    return 10.0 * column + 7.0 * row + row * column


def tiff(name, **members):
    content = base64.b64encode((FILES / name).read_bytes()).decode()
    given = {"format": "geotiff", "content": content, "height_datum": "ellipsoid"}
    return Terrain(**given | members)


def ascii_text(heights_m, west_deg, south_deg, cell_deg, nodata=-9999):
    rows, columns = heights_m.shape
    header = f"ncols {columns}\nnrows {rows}\nxllcenter {west_deg!r}\nyllcenter {south_deg!r}\n"
    header += f"cellsize {cell_deg!r}\nNODATA_value {nodata}\n"
    return header + "\n".join(" ".join(f"{h:.4f}" for h in row) for row in heights_m)


def hills(shift_m=0.0):
    """Over Las Vegas, 3 km from top to top; the height at a place."""
    latitude_deg = np.linspace(36.5, 35.7, 161)[:, None]
    longitude_deg = np.linspace(-115.7, -114.7, 201)[None]
    heights_m = 700.0 + shift_m + 150.0 * np.sin(200.0 * latitude_deg) * np.cos(180 * longitude_deg)
    content = ascii_text(heights_m, -115.7, 35.7, 0.005)
    return Terrain(format="ascii_grid", content=content, height_datum="ellipsoid")


@pytest.mark.parametrize("name", WHOLE)
def test_a_geotiff_by_gdal_has_its_values_where_gdal_has_them(name):
    grid = read_geotiff((FILES / name).read_bytes())
    rng = np.random.default_rng(46)
    latitude_deg = rng.uniform(37.77, 37.99, 200)
    longitude_deg = rng.uniform(-4.995, -4.845, 200)
    found = grid.at(latitude_deg, longitude_deg)
    # Whole numbers below 2^24 are exact in 32 bits; places are told to 1e-14 of 360 deg.
    np.testing.assert_allclose(found, known_m(latitude_deg, longitude_deg), atol=1e-8)


def test_a_file_says_what_its_heights_are_above():
    assert read_geotiff((FILES / "egm96.tif").read_bytes()).above_ellipsoid is False
    assert read_geotiff((FILES / "ellipsoid.tif").read_bytes()).above_ellipsoid is True
    assert read_geotiff((FILES / "bigtiff.tif").read_bytes()).above_ellipsoid is None
    with pytest.raises(ValueError, match=r"height_datum is 'ellipsoid', but .* above the geoid"):
        tiff("egm96.tif")
    with pytest.raises(ValueError, match=r"height_datum is 'geoid', but .* above the ellipsoid"):
        tiff("ellipsoid.tif", height_datum="geoid", geoid_height_m=50.0)
    above_geoid = tiff("egm96.tif", height_datum="geoid", geoid_height_m=50.5)
    assert above_geoid.height_m(37.9, -4.9) == pytest.approx(known_m(37.9, -4.9) + 50.5)


def test_cells_of_an_ascii_grid_by_corner_and_centre_are_the_same():
    by_corner = read_ascii_grid(ASC)
    by_centre = read_ascii_grid(
        ASC.replace("corner -115.40", "center -115.375").replace(
            "yllcorner 35.95", "yllcenter 35.975"
        )
    )
    assert by_centre.north_deg == pytest.approx(by_corner.north_deg)
    at = np.array([35.975, 36.225, 36.0]), np.array([-115.375, -115.375, -115.35])
    for grid in (by_corner, by_centre):
        # The south-west cell, the north-west one, and a half of four around it.
        expected = [990.0, 1190.0, (990.0 + 920.0 + 980.0 + 890.0) / 4.0]
        np.testing.assert_allclose(grid.at(*at), expected, rtol=1e-6)


def test_a_grid_across_the_antimeridian_reaches_both_sides():
    heights_m = np.arange(12.0).reshape(3, 4)
    grid = read_ascii_grid(ascii_text(heights_m, 179.0, -1.0, 1.0))
    assert grid.at(np.zeros(3), np.array([179.5, -179.5, 181.25])).tolist() == [4.5, 5.5, 6.25]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"content": ASC.replace("1190", "-9999")}, "has no value at 36.2"),
        ({"content": ASC.replace("1190", "nan")}, "has no value at 36.2"),
        ({"content": ASC.replace("1190", "-32768")}, "has no value at 36.2"),
        ({"content": ASC.replace("1190", "high")}, "holds what is no number"),
        ({"content": ASC.replace("nrows 6", "nrows 7")}, "7 rows and 10 columns has 60 values"),
        ({"content": ASC.replace("nrows 6", "nrows 600000000")}, "16000000 cells"),
        ({"content": ASC.replace("cellsize 0.05", "cellsize 30")}, "no part of the Earth"),
        ({"content": ASC.replace("cellsize 0.05\n", "")}, "no part of the Earth"),
        ({"content": ""}, "begins with ncols"),
        ({"format": "geotiff"}, "given in base64"),
        ({"format": "geotiff", "content": "QUJD"}, "no TIFF"),
        ({"height_datum": "geoid"}, "geoid_height_m: is required"),
        ({"geoid_height_m": 3.0}, "geoid_height_m: must be left out"),
    ],
)
def test_what_tells_no_height_is_refused(change, told):
    given = {"format": "ascii_grid", "content": ASC, "height_datum": "ellipsoid"}
    document = copy.deepcopy(OVER_TERRAIN) | {"terrain": given | change}
    target = {"mode": "ground", "latitude_deg": 36.21, "longitude_deg": -115.36}
    document["sessions"][0]["target"] = target
    with pytest.raises(InvalidRequest) as refused:
        read_request(document)
    assert told in refused.value.detail
    assert refused.value.field.startswith(("terrain", "sessions.0.target"))


def test_a_projected_grid_and_one_too_large_are_refused():
    with pytest.raises(InvalidMessage, match=r"not EPSG:32630: .*gdalwarp"):
        read_geotiff((FILES / "utm.tif").read_bytes())
    content = bytearray((FILES / "bigtiff.tif").read_bytes())
    for tag in (256, 257):  # width and height of the directory, 16 bits each
        place = content.index(tag.to_bytes(2, "little") + (3).to_bytes(2, "little"))
        content[place + 12 : place + 14] = (60_000).to_bytes(2, "little")
    with pytest.raises(InvalidMessage, match="16000000 cells, not 60000 x 60000"):
        read_geotiff(bytes(content))


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(WHOLE), st.data())
def test_a_damaged_geotiff_is_read_or_refused(name, data):
    content = bytearray((FILES / name).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    try:
        grid = read_geotiff(bytes(content[: data.draw(st.integers(8, len(content)))]))
    except InvalidMessage:
        return
    assert grid.values.dtype == np.float32


def test_a_cell_without_data_is_refused_only_beside_it():
    terrain = tiff("int16_lzw_tiled.tif")
    assert terrain.height_m(37.79, -4.895) == pytest.approx(known_m(37.79, -4.895))
    with pytest.raises(ValueError, match=r"the terrain has no value at 37\.93\d*, -4\.95"):
        terrain.height_m(37.932, -4.952)
    with pytest.raises(ValueError, match=r"doesn't reach 38\.10000, -4\.95"):
        terrain.height_m(38.1, -4.95)


def test_a_ground_target_stands_on_the_terrain_unless_it_says_its_height():
    terrain = tiff("point.tif")
    target = GroundTarget(latitude_deg=37.9, longitude_deg=-4.9).standing_on(terrain)
    _, _, height_m = geodetic_from_itrf(target.r_target_itrf_m(Instants(START, np.zeros(1))))
    assert height_m[0] == pytest.approx(known_m(37.9, -4.9), abs=1e-6)
    told = replace(target, terrain=None, height_m=12.0)
    assert told.standing_on(terrain) is told
    with pytest.raises(ValueError, match="both say how high"):
        replace(target, height_m=12.0)


def test_a_line_lies_on_the_terrain_in_the_mean_and_keeps_its_speed():
    terrain = hills()
    ends = (36.0, -115.4), (36.3, -114.9)
    points = tuple(PathPoint(latitude_deg=a, longitude_deg=b) for a, b in ends)
    target = GroundPathTarget(
        points=points, speed_m_s=500.0, corner_s=2.0, start=START, terrain=terrain
    )
    length_m = Geodesic.WGS84.Inverse(*ends[0], *ends[1])["s12"]
    assert target.duration_s == pytest.approx(length_m / 500.0, rel=1e-9)
    t_s = np.linspace(0.0, target.duration_s, 4001)
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(
        target.r_target_itrf_m(Instants(START, t_s))
    )
    latitude_deg, longitude_deg = np.degrees([latitude_rad, longitude_rad])
    ground_m = 700.0 + 150.0 * np.sin(200.0 * latitude_deg) * np.cos(180.0 * longitude_deg)
    # Bilinear between cells of 0.005 deg, which 200 rad a degree turn by 1 rad: lower by a tenth.
    assert abs(np.mean(height_m - ground_m)) < 3.0
    assert np.std(height_m) > 30.0
    # Whatever the slope, over the ellipsoid: between samples of 0.03 s of a geodesic.
    a, b = (
        zip(latitude_deg, longitude_deg, strict=True),
        zip(latitude_deg[1:], longitude_deg[1:], strict=True),
    )
    steps_m = [
        Geodesic.WGS84.Inverse(*p, *q)["s12"] for p, q in list(zip(a, b, strict=False))[::40]
    ]
    np.testing.assert_allclose(np.array(steps_m) / (t_s[1] - t_s[0]), 500.0, rtol=1e-5)


def test_a_line_with_its_heights_written_out_is_the_same_line():
    target = GroundPathTarget(
        points=tuple(PathPoint(latitude_deg=a, longitude_deg=-115.2) for a in (36.0, 36.2)),
        speed_m_s=300.0,
        start=START,
    ).standing_on(hills())
    at = Instants(START, np.linspace(0.0, target.duration_s, 50))
    written = target.with_heights()
    assert written.terrain is None
    # Angles turn to degrees and back; a nanometre of 6e6 m is their last digit.
    off_m = written.r_target_itrf_m(at) - target.r_target_itrf_m(at)
    assert np.abs(off_m).max() < 1e-6
    told = target.assumed("sessions.0.target")
    assert len(told.members["points"]) == len(written.points) == 19


def over_point():
    document = copy.deepcopy(OVER_TERRAIN)
    document["sessions"][0]["target"] = {"mode": "ground", **PLACE}
    return document


@pytest.fixture(scope="module")
def point_plan():
    return plan_of(over_point())


def test_the_judge_finds_a_point_on_other_ground(point_plan):
    """1 m of height is 0.4 arcsec or more from 500 km, four times what is allowed."""
    assert point_plan.verification.passed
    assert point_plan.verification.taken_as_given == ("orbit",)
    asked = point_plan.scenario
    terrain = replace(asked.terrain, geoid_height_m=asked.terrain.geoid_height_m + 1.0)
    target = replace(asked.sessions[0].target, terrain=terrain)
    other = replace(asked, terrain=terrain, sessions=(replace(asked.sessions[0], target=target),))
    verdict = verify(point_plan.table, other)
    assert not verdict.passed
    assert {finding.limit for finding in verdict.findings} == {"pointing"}


def test_the_judge_finds_a_line_off_the_terrain(monkeypatch):
    request = read_request(OVER_TERRAIN)
    assert make_plan(request).verification.findings == ()
    read_m = Terrain.heights_m
    monkeypatch.setattr(
        Terrain, "heights_m", lambda self, *place_deg: read_m(self, *place_deg) + 40.0
    )
    with pytest.raises(VerificationFailed, match=r"lies \+40\.0 m off the terrain in the mean"):
        plan_of(OVER_TERRAIN)


def test_windows_and_campaigns_are_those_of_the_height_written_out():
    orbit = OVER_TERRAIN["orbit"]
    asked = {
        "platform": "iss-hrc",
        "orbit": orbit,
        "targets": [{"id": "LV", "target": {"mode": "ground", **PLACE}}],
        "start": "2015-02-27T12:00:00Z",
        "stop": "2015-02-28T12:00:00Z",
    }
    over = read_opportunity_request(
        json.dumps(asked | {"terrain": OVER_TERRAIN["terrain"]}).encode()
    )
    height_m = over.targets[0].target.ground_height_m
    assert 500.0 < height_m < 700.0
    asked["targets"][0]["target"]["height_m"] = height_m
    told = read_opportunity_request(json.dumps(asked).encode())
    found, expected = (find_opportunities(one) for one in (over, told))
    assert repr(found.windows) == repr(expected.windows)
    assert len(expected.windows) > 0
    del asked["targets"][0]["target"]["height_m"]
    asked["targets"][0]["session_s"] = 20.0
    campaign = read_campaign_request(
        json.dumps(asked | {"terrain": OVER_TERRAIN["terrain"]}).encode()
    )
    assert campaign.opportunities().targets[0].target.ground_height_m == height_m


def test_a_line_of_the_plane_is_refused_over_terrain():
    document = copy.deepcopy(OVER_TERRAIN)
    target = document["sessions"][0]["target"]
    target["points"] = target["points"][1:]
    target["line"] = "plane"
    document["sessions"][0]["stop"] = "2015-02-27T17:37:00Z"
    with pytest.raises(InvalidRequest, match="can't follow the terrain"):
        read_request(document)
    target["line"] = "geodesic"
    target["points"][0]["height_m"] = 600.0
    with pytest.raises(InvalidRequest, match=r"points\.1\.height_m is left out"):
        read_request(document)


def test_a_file_is_set_by_its_name_on_the_command_line(tmp_path):
    text = with_settings(b"{}", [f"terrain.content=@{FILES / 'point.tif'}"])
    assert base64.b64decode(json.loads(text)["terrain"]["content"]).startswith(b"II*\0")
    (tmp_path / "dem.asc").write_text(ASC)
    text = with_settings(b"{}", [f"terrain.content=@{tmp_path / 'dem.asc'}"])
    assert json.loads(text)["terrain"]["content"] == ASC


def test_a_kept_plan_stands_on_the_same_ground(point_plan):
    body = json.dumps(over_point()).encode()
    kept = stored_plan(body, unpack(pack(packed_plan(point_plan))))
    assert kept.scenario.sessions == point_plan.scenario.sessions


def test_a_pass_of_a_campaign_has_the_heights_and_not_the_grid():
    body = json.dumps(
        {
            "platform": "iss-hrc",
            "orbit": OVER_TERRAIN["orbit"],
            "terrain": OVER_TERRAIN["terrain"],
            "targets": [{"id": "LV", "target": {"mode": "ground", **PLACE}, "session_s": 20.0}],
            "start": "2015-02-27T17:00:00Z",
            "stop": "2015-02-27T18:30:00Z",
        }
    ).encode()
    [part] = choose(body).parts
    request = read_plan_request(part.request)
    assert request.terrain is None
    expected_m = read_campaign_request(body).targets[0].target.ground_height_m
    assert request.sessions[0].target.ground_height_m == expected_m
