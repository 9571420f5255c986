"""A plan over HTTP holds what the contract promises, and its table comes in every format."""

import hashlib
import io
import json
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from refusal_cases import SHORT, request
from scipy.interpolate import CubicHermiteSpline
from scipy.io import netcdf_file

from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES
from planner.output.export import EXPORTERS

JSON = {"Content-Type": "application/json"}


@pytest.fixture(scope="module")
def plan(client):
    return client.made("/v1/plans", content=json.dumps(LAS_VEGAS), headers=JSON)


def utc(text: str) -> datetime:
    assert text.endswith("Z")
    return datetime.fromisoformat(text).astimezone(UTC)


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


def example(client, name):
    return client.made("/v1/plans", json=PLAN_EXAMPLES[name][1])


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


def test_a_cone_whose_body_the_earth_hides_never_counts(client):
    cones = [{"body": body, "half_angle_deg": 25.0} for body in ("jupiter", "mercury")]
    document = request(("slew.keep_out", cones))
    by_number = client.post("/v1/plans", json=document).json()["keep_out"]
    assert [margin["number"] for margin in by_number] == [0, 1]
    hidden = by_number[0]  # Jupiter rises at 17:45 for the ISS
    assert hidden["away_min_deg"] is None
    assert hidden["margin_deg"] is None
    assert hidden["at"] is None


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


def post(client, accept="*/*", query="", document=SHORT):
    return client.post(f"/v1/plans{query}", json=document, headers={"Accept": accept})


def assert_is(answer, name):
    assert answer.status_code == 201, answer.text
    assert answer.headers["content-type"].split(";")[0] == EXPORTERS[name].media_type
    suffix = EXPORTERS[name].suffix
    assert answer.headers["content-disposition"] == f'attachment; filename="Las-Vegas{suffix}"'
    assert "accept" in answer.headers["vary"].lower()


@pytest.mark.parametrize("name", EXPORTERS)
def test_every_format(client, name):
    """By its media type, but for JSON's, which is the whole answer's."""
    asked = {"query": "?format=json"} if name == "json" else {"accept": EXPORTERS[name].media_type}
    assert_is(post(client, **asked), name)


@pytest.mark.parametrize(
    ("accept", "name"),
    [
        ("*/*", None),
        ("application/json", None),
        ("application/*", None),
        ("text/csv;q=0.9, application/json;q=0.1", "csv"),
        ("text/csv;q=0.2, application/json;q=0.3", None),
        ("application/json;q=0, */*", "csv"),
        ("text/*", "csv"),
        ("application/*;q=0.1, application/x-netcdf;q=0.2", "netcdf"),
    ],
)
def test_the_weights_of_accept_decide(client, accept, name):
    answer = post(client, accept)
    if name is None:
        assert answer.headers["content-type"] == "application/json"
        assert answer.json()["state"] == "done"
    else:
        assert_is(answer, name)


@pytest.mark.parametrize("accept", ["image/gif", "application/json;q=0", "*/*;q=0"])
def test_nothing_else_is_admitted(client, accept):
    answer = post(client, accept)
    assert answer.status_code == 406
    assert "text/csv" in answer.json()["detail"]


def test_an_unknown_format_names_those_there_are(client):
    problem = post(client, query="?format=xlsx").json()
    assert problem["status"] == 422
    assert problem["field"] == "query.format"
    assert "netcdf" in problem["detail"]


def test_a_dry_run_answers_json_whatever_the_format(client):
    answer = post(client, query="?dry_run=true&format=csv")
    assert answer.status_code == 200
    assert answer.json()["valid"] is True


def test_a_table_that_failed_its_verification_is_not_handed_out(client):
    document = {**LAS_VEGAS, "slew": {"method": "spline"}}
    problem = post(client, query="?format=csv", document=document).json()
    assert problem["type"] == "urn:slewtrack:problem:unverified"
    assert problem["status"] == 422
    assert problem["limit"] == "pointing"
    whole = post(client, document=document).json()
    assert whole["state"] == "failed"
    assert whole["verification"]["passed"] is False


@pytest.mark.parametrize("name", ['a"; filename="b', "", "Ω$", "x" * 200])
def test_a_plans_name_can_not_break_the_header(client, name):
    answer = post(client, query="?format=csv", document={**SHORT, "name": name})
    assert answer.status_code == 201
    assert "set-cookie" not in answer.headers
    assert len(answer.headers["content-disposition"]) < 120
