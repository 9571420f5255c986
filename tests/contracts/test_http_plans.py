"""A plan over HTTP holds what the contract promises."""

import hashlib
import io
import json
import math
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from refusal_cases import request
from scipy.interpolate import CubicHermiteSpline
from scipy.io import netcdf_file
from skyfield.api import EarthSatellite, load, wgs84

from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES

JSON = {"Content-Type": "application/json"}


@pytest.fixture(scope="module")
def plan(client):
    answer = client.post("/v1/plans", content=json.dumps(LAS_VEGAS), headers=JSON)
    assert answer.status_code == 201, answer.text
    return answer.json()


def utc(text: str) -> datetime:
    assert text.endswith("Z")
    return datetime.fromisoformat(text).astimezone(UTC)


def test_table_rows_stand_on_the_grid(plan):
    table = plan["table"]
    assert set(table) == {
        "epoch", "step_s", "t_s", "alpha_deg", "beta_deg", "alpha_rate_deg_s", "beta_rate_deg_s",
    }  # fmt: skip
    assert table["epoch"] == "2015-02-27T17:34:00.0Z"
    assert table["step_s"] == 0.2
    rows = 230 * 5 + 1  # 17:34:00 to 17:37:50
    assert table["t_s"] == [k / 5 for k in range(rows)]
    for column in ("alpha_deg", "beta_deg", "alpha_rate_deg_s", "beta_rate_deg_s"):
        assert len(table[column]) == rows
        assert all(math.isfinite(value) for value in table[column])


def test_table_starts_from_the_initial_state(plan):
    table = plan["table"]
    for axis in ("alpha", "beta"):
        assert table[f"{axis}_deg"][0] == pytest.approx(0.0, abs=1e-9)  # the table's resolution
        assert table[f"{axis}_rate_deg_s"][0] == pytest.approx(0.0, abs=1e-9)


def test_rates_are_those_of_the_angles(plan):
    """A smooth curve's rate by central differences; 0.2 s^2/6 times a jerk of 1 deg/s3 at most."""
    table = plan["table"]
    for axis in ("alpha", "beta"):
        angle = np.array(table[f"{axis}_deg"])
        rate = np.array(table[f"{axis}_rate_deg_s"])
        np.testing.assert_allclose((angle[2:] - angle[:-2]) / 0.4, rate[1:-1], atol=0.2**2 / 6)


def test_segments_cover_the_table(plan):
    slew, track = plan["segments"]
    assert (slew["kind"], track["kind"]) == ("slew", "track")
    assert utc(slew["start"]) == utc(plan["table"]["epoch"])
    assert slew["stop"] == track["start"] == "2015-02-27T17:36:20.0Z"
    assert track["stop"] == "2015-02-27T17:37:50.0Z"


def test_margins_are_those_of_the_curve_between_rows(plan):
    """The extreme of the same Hermite, found by SciPy on a 1 ms grid."""
    table = plan["table"]
    t_s = np.array(table["t_s"])
    fine_s = np.arange(0.0, t_s[-1], 1e-3)
    for axis in ("alpha", "beta"):
        flown = CubicHermiteSpline(t_s, table[f"{axis}_deg"], table[f"{axis}_rate_deg_s"])
        margins = plan["margins"][axis]
        assert margins["rate"]["limit"] == 3.0
        assert margins["rate"]["unit"] == "deg/s"
        fastest = np.abs(flown(fine_s, nu=1)).max()
        # Half a step of 1 ms at 1 deg/s2 from the grid's nearest point.
        assert abs(margins["rate"]["extreme"]) == pytest.approx(fastest, abs=5e-4)
        assert margins["rate"]["margin"] == pytest.approx(3.0 - fastest, abs=5e-4)
        assert margins["angle_max"]["limit"] == 175.0
        assert margins["angle_max"]["extreme"] == pytest.approx(flown(fine_s).max(), abs=1e-3)
        assert margins["acceleration"]["margin"] >= 0.0


def test_pointing_is_within_the_promise(plan):
    [session] = plan["pointing"]
    assert session["session"] == 0
    assert 0.0 <= session["rms_arcsec"] <= session["max_arcsec"] <= 0.1
    assert session["ground_max_m"] < 1.0  # 0.1 arcsec from 800 km, at 30 deg elevation
    assert session["elevation_min_deg"] > 0.0


def test_the_budget_is_the_sum_of_its_contributions(plan):
    """Independent errors of equal weight per image axis: their squares add."""
    [budget] = plan["uncertainty"]
    assert budget["session"] == 0
    for member in ("sigma_arcsec", "ground_m"):
        squares = sum(part[member] ** 2 for part in budget["contributions"])
        assert math.sqrt(squares) == pytest.approx(budget[member], rel=1e-6)
    assert {part["cause"] for part in budget["contributions"]} >= {"orbit", "attitude", "clock"}
    assert 0.0 < budget["probability_in_frame"] < 1.0


def example(client, name):
    answer = client.post("/v1/plans", json=PLAN_EXAMPLES[name][1])
    assert answer.status_code == 201, answer.text
    return answer.json()


ON_THE_EARTH = {
    "ground_max_m", "across_max_m", "elevation_min_deg", "range_min_km", "closest_at",
    "range_max_km",
}  # fmt: skip
IN_THE_SKY = {"limb_clearance_min_deg", "limb_clearance_min_at", "refraction_max_arcsec"}


def told(pointing):
    return {name for name in ON_THE_EARTH | IN_THE_SKY if pointing[name] is not None}


def test_pointing_at_a_star_tells_no_metres(client):
    star = example(client, "star")
    assert told(star["pointing"][0]) == IN_THE_SKY
    assert star["pointing"][0]["limb_clearance_min_deg"] > 0.0
    [budget] = star["uncertainty"]
    assert budget["ground_m"] is None
    assert all(part["ground_m"] is None for part in budget["contributions"])


def test_pointing_at_a_planet_tells_its_distance(client):
    [pointing] = example(client, "body")["pointing"]
    assert told(pointing) == IN_THE_SKY | {"range_min_km"}
    assert pointing["range_min_km"] / 149_597_870.7 == pytest.approx(9.9, abs=1.2)  # 8.0 to 11.1 au


def test_a_test_motion_looks_at_nothing(client):
    plan = example(client, "test_motion")
    [pointing] = plan["pointing"]
    assert told(pointing) == set()
    assert pointing["max_arcsec"] <= 0.1
    assert plan["uncertainty"] == []
    assert plan["verification"]["taken_as_given"] == ["motion"]


def test_a_cone_is_kept_out_of(client):
    [margin] = example(client, "keep_out")["keep_out"]
    assert margin["about"] == "the Sun"
    # 0.1 arcsec, as for pointing
    assert margin["margin_deg"] >= -0.1 / 3600.0
    assert margin["away_min_deg"] == pytest.approx(25.0 + margin["margin_deg"])


def test_a_mask_is_kept_out_of(client):
    [margin] = example(client, "masks")["masks"]
    assert margin["name"] == "arm"
    assert margin["asked_deg"] == 1.0
    assert margin["margin_deg"] >= 0.0
    assert margin["away_min_deg"] == pytest.approx(1.0 + margin["margin_deg"])


def test_a_cone_whose_body_the_earth_hides_never_counts(client):
    cones = [{"body": body, "half_angle_deg": 25.0} for body in ("jupiter", "mercury")]
    document = request(("slew.keep_out", cones))
    by_number = client.post("/v1/plans", json=document).json()["keep_out"]
    assert [margin["number"] for margin in by_number] == [0, 1]
    hidden = by_number[0]  # Jupiter rises at 17:45 for the ISS
    assert hidden["away_min_deg"] is None
    assert hidden["margin_deg"] is None
    assert hidden["at"] is None


def test_suppressed_modes_swing_a_hundredth_of_the_splines(client):
    """The issue's promise at more than 1.3 of the least time; here there is ten times that."""
    [comparison] = example(client, "avoid_modes")["comparison"]
    left = comparison["residual_vibration"]
    assert [mode["frequency_hz"] for mode in left] == [0.1, 0.35]
    for mode in left:
        for axis in ("alpha", "beta"):
            assert mode["ocp_arcsec"][axis] <= mode["spline_arcsec"][axis] / 100.0


def test_sessions_that_conflict_are_shortened_as_asked(client):
    plan = example(client, "sequence")
    starts = [session["start"] for session in PLAN_EXAMPLES["sequence"][1]["sessions"]]
    stops = [session["stop"] for session in PLAN_EXAMPLES["sequence"][1]["sessions"]]
    flown = plan["pointing"]
    lost_s = sum(
        (utc(b["start"]) - utc(a)).total_seconds() for a, b in zip(starts, flown, strict=True)
    )
    lost_s += sum(
        (utc(a) - utc(b["stop"])).total_seconds() for a, b in zip(stops, flown, strict=True)
    )
    assert lost_s > 1.0
    assert sum("least_loss" in warning for warning in plan["warnings"]) == 2


def test_provenance(plan):
    provenance = plan["provenance"]
    digest = hashlib.sha256(json.dumps(LAS_VEGAS).encode()).hexdigest()
    assert provenance["input_sha256"] == digest
    assert {"slewtrack", "python", "casadi", "numpy"} <= set(provenance["versions"])
    assert abs((datetime.now(UTC) - utc(provenance["planned_at"])).total_seconds()) < 600


def test_solver(plan):
    solver = plan["solver"]
    assert solver["wall_s"] > 0.0
    assert [run["session"] for run in solver["slews"]] == [0]
    assert solver["slews"][0]["minimum_s"] < solver["slews"][0]["duration_s"]


def test_a_dry_run_plans_nothing(client):
    body = json.dumps(LAS_VEGAS)
    answer = client.post("/v1/plans?dry_run=true", content=body, headers=JSON)
    assert answer.status_code == 200
    said = answer.json()
    assert (said["valid"], said["flies"], said["rows"]) == (True, True, 1151)
    assert "table" not in said
    assert said["provenance"]["input_sha256"] == hashlib.sha256(body.encode()).hexdigest()


def test_a_dry_run_says_what_its_plan_would(client):
    kept = len(client.get("/v1/plans?limit=200").json()["plans"])
    [session] = LAS_VEGAS["sessions"]
    soon = LAS_VEGAS | {"sessions": [session | {"start": "2015-02-27T17:34:02Z"}]}
    dry = client.post("/v1/plans?dry_run=true", json=soon)
    assert dry.status_code == 422
    assert dry.json()["earliest_feasible_start"] == "2015-02-27T17:34:27.200Z"
    spline = client.post("/v1/plans?dry_run=true", json=PLAN_EXAMPLES["spline"][1]).json()
    assert not spline["flies"]
    assert spline["warnings"]
    assert len(client.get("/v1/plans?limit=200").json()["plans"]) == kept


def test_a_platform_copied_from_the_list_plans_the_same(client, plan):
    [iss_hrc] = [
        entry
        for entry in client.get("/v1/platforms").json()["platforms"]
        if entry["name"] == "iss-hrc"
    ]
    again = client.post("/v1/plans", json=request(("platform", iss_hrc)))
    assert again.status_code == 201, again.text
    for column in ("alpha_deg", "beta_deg"):
        # Degrees at 1e-12 in the list, amplified by nothing: the table's own resolution.
        np.testing.assert_allclose(again.json()["table"][column], plan["table"][column], atol=2e-9)


def test_an_offset_other_than_z_is_the_same_instant(client, plan):
    answer = client.post(
        "/v1/plans", json=request(("sessions.0.start", "2015-02-27T09:36:20-08:00"))
    )
    assert answer.json()["table"]["alpha_deg"] == plan["table"]["alpha_deg"]


def _overhead_request(moment: datetime):
    """A request for the point under the satellite at a moment, by Skyfield."""
    orbit = LAS_VEGAS["orbit"]
    satellite = EarthSatellite(orbit["line1"], orbit["line2"])
    below = wgs84.subpoint_of(satellite.at(load.timescale(builtin=True).from_datetime(moment)))
    return request(
        ("sessions.0.target.latitude_deg", below.latitude.degrees),
        ("sessions.0.target.longitude_deg", below.longitude.degrees),
        ("sessions.0.start", (moment - timedelta(seconds=30)).isoformat()),
        ("sessions.0.stop", (moment + timedelta(seconds=30)).isoformat()),
        ("initial_state.epoch", (moment - timedelta(seconds=200)).isoformat()),
    )


@pytest.mark.parametrize(("age_days", "warns"), [(2.9, False), (3.1, True), (29.0, True)])
def test_an_old_tle_is_used_with_a_warning(client, age_days, warns):
    """The target lies under the satellite as Skyfield sees it, so an old TLE is no obstacle."""
    elements_utc = datetime(2015, 2, 27, 11, 33, tzinfo=UTC)
    moment = elements_utc + timedelta(days=age_days)
    answer = client.post("/v1/plans", json=_overhead_request(moment))
    assert answer.status_code == 201, answer.text
    plan = answer.json()
    # 1 s along the track is 1 deg of elevation: Skyfield's and our frames differ by far less.
    assert plan["pointing"][0]["range_min_km"] == pytest.approx(410, abs=15)
    assert any("days" in warning for warning in plan["warnings"]) == warns


def test_the_spline_says_which_limits_it_breaks(client):
    """A moving start towards a near stop: the cubic overshoots, and the plan says so."""
    document = request(
        ("slew", {"method": "spline"}),
        ("initial_state.epoch", "2015-02-27T17:35:00Z"),
        ("initial_state.angles_deg.alpha", 172.0),
        ("initial_state.rates_deg_s.alpha", 1.5),
    )
    plan = client.post("/v1/plans", json=document).json()
    assert plan["state"] == "failed"
    assert not plan["verification"]["passed"]
    broken = [finding for finding in plan["verification"]["findings"] if finding["axis"] == "alpha"]
    assert {finding["limit"] for finding in broken} >= {"rate", "angle_max"}
    assert plan["margins"]["alpha"]["angle_max"]["margin"] < 0.0
    assert any("alpha" in warning for warning in plan["warnings"])


def test_a_plan_that_waits_and_parks(client):
    """Its stretches, as answered and in the NetCDF file that is written from what is kept."""
    asked = PLAN_EXAMPLES["long_lead"][1]
    dry = client.post("/v1/plans?dry_run=true", content=json.dumps(asked), headers=JSON)
    assert dry.status_code == 200
    answer = client.post("/v1/plans", content=json.dumps(asked), headers=JSON)
    assert answer.status_code == 201, answer.text
    told = answer.json()
    assert [(part["kind"], part["session"]) for part in told["segments"]] == [
        ("wait", 0), ("slew", 0), ("track", 0), ("slew", None),
    ]  # fmt: skip
    assert utc(told["segments"][1]["stop"]) - utc(told["segments"][1]["start"]) == timedelta(
        seconds=120
    )
    assert [told["table"][f"{axis}_deg"][-1] for axis in ("alpha", "beta")] == [0.0, 0.0]
    for part in (told["solver"]["slews"], told["comparison"]):
        assert [slew["session"] for slew in part] == [0, None]
    waited_until = told["segments"][0]["stop"]
    assert told["slow_stretches"]
    assert all(utc(slow["start"]) >= utc(waited_until) for slow in told["slow_stretches"])
    file = client.get(f"/v1/plans/{told['id']}/table?format=netcdf")
    with netcdf_file(io.BytesIO(file.content), mmap=False) as stored:
        session = stored.variables["session"][:]
    rows = round(
        (utc(told["segments"][3]["stop"]) - utc(told["segments"][3]["start"])).total_seconds() * 5
    )
    assert session.tolist() == [0] * (len(session) - rows - 1) + [-1] * (rows + 1)
