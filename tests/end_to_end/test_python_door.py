"""The functions of `slewtrack` do what the service does with the same JSON."""

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import slewtrack
from app.here import Desk
from app.requests.examples import SPACECRAFT_EXAMPLES

EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS = EXAMPLES / "las_vegas_2015.json"
FUNCTIONS = [name for name in slewtrack.__all__ if inspect.isfunction(getattr(slewtrack, name))]
METHODS = [
    name
    for name, _ in inspect.getmembers(slewtrack.Client, inspect.isfunction)
    if not name.startswith("_") and name != "close"
]


def document(name):
    return json.loads((EXAMPLES / name).read_text())


def test_a_plan_of_a_file_its_bytes_or_a_dictionary():
    body = LAS_VEGAS.read_bytes()
    plans = [slewtrack.plan(asked) for asked in (LAS_VEGAS, body, json.loads(body))]
    for plan in plans:
        assert plan.passed
        np.testing.assert_array_equal(plan.table["alpha_deg"], plans[0].table["alpha_deg"])
    assert slewtrack.get(plans[1]) == plans[1]
    assert slewtrack.request(plans[2].id) == json.loads(body)


def test_answers_say_what_they_hold():
    plan = slewtrack.plan(LAS_VEGAS)
    assert repr(plan).startswith(
        "Plan('Las Vegas', passed, 1 warnings, Columns(1151 rows from 2015"
    )
    assert "alpha_deg" in repr(plan.table)
    found = slewtrack.opportunities(document("opportunities_gallery.json"))
    assert repr(found).startswith("Opportunities(92 windows of Las Vegas, Boston")
    assert found.windows[0].closest["elevation_deg"] <= found.windows[0].highest_deg


def test_opportunities_and_a_campaign():
    found = slewtrack.opportunities(document("opportunities_sky.json"))
    assert found.windows
    told = []
    campaign = slewtrack.campaign(EXAMPLES / "campaign_cities.json", progress=told.append)
    assert campaign.value <= campaign.bound
    assert [one.looks[0].target for one in campaign.passes] == ["Los Angeles", "Boston"]
    assert all(slewtrack.get(one.plan).passed for one in campaign.passes)
    assert [now.done for now in told if now.stage == "plans"] == [0, 1, 2]
    assert slewtrack.export_campaign(campaign, "csv").startswith(b"pass,target")
    with pytest.raises(slewtrack.Refused, match="must be one of csv, geojson, json, kml, zip"):
        slewtrack.export_campaign(campaign, "netcdf")


def test_the_vertical_of_two_pictures():
    images = [EXAMPLES / f"horizon_{side}.png" for side in ("ahead", "right")]
    estimate = slewtrack.estimate_vertical(images, document("horizon_estimate.json"))
    assert estimate.verdict == "consistent"
    assert np.linalg.norm(estimate.nadir_body) == pytest.approx(1.0, abs=1e-8)  # of 9 decimals


def test_flights_and_telemetry_of_a_plan():
    """Its own table, as if flown: only the digits of its CSV are off."""
    plan = slewtrack.plan(LAS_VEGAS)
    flown = slewtrack.fly(plan, {"runs": 4, "seed": 1})
    assert (flown.flown, flown["plan"]) == (4, plan.id)
    found = slewtrack.compare(plan, slewtrack.export(plan, "csv"))
    assert (found.plan, found.axes["alpha"]["max_arcsec"] < 0.001) == (plan.id, True)
    picture = slewtrack.draw_comparison(plan.id, slewtrack.export(plan, "csv"))
    assert picture.startswith(b"\x89PNG")


def test_an_imaging_session():
    told = []
    changes = {"simulation_runs": 0}
    request = SPACECRAFT_EXAMPLES["geojson"][1] | changes
    plan = slewtrack.spacecraft.plan(request, progress=told.append)
    assert plan.passed
    assert plan.table["q_body_from_eci_xyzw"].shape == (len(plan.table.t_s), 4)
    assert [told[0].state, told[-1].state] == ["queued", "done"]
    assert slewtrack.spacecraft.view(plan, step_s=10.0)["carrier.latitude_deg"].size


def test_names_are_completed():
    assert [star.name for star in slewtrack.stars("veg")] == ["Vega"]
    platform, *bodies = slewtrack.platforms()
    assert platform.name == "iss-hrc"
    assert [body.name for body in bodies] == ["smallsat-120kg", "agile-cmg"]
    assert slewtrack.plan(document("las_vegas_2015.json") | {"platform": platform}).passed


def test_what_only_a_service_has_is_refused():
    with pytest.raises(slewtrack.Refused, match=r"slewtrack\.Client"):
        slewtrack.spacecraft.plans()
    with pytest.raises(slewtrack.Refused, match="made no"):
        slewtrack.view("01a203fd-cbae-73f8-8276-319f76b8842c")


def test_waiting_ends_and_goes_on():
    """The work begins anew where its time was over, and is done when somebody waits for it."""
    with pytest.raises(slewtrack.NotFinished) as late:
        slewtrack.plan(LAS_VEGAS, timeout_s=0.0)
    assert slewtrack.wait(late.value.job_id).passed


def test_the_oldest_of_many_plans_are_let_go(monkeypatch):
    monkeypatch.setattr(Desk, "kept_max", 1)
    first, second = slewtrack.plan(LAS_VEGAS), slewtrack.plan(LAS_VEGAS)
    assert slewtrack.export(second, "csv")
    with pytest.raises(slewtrack.Refused, match="let go"):
        slewtrack.export(first, "csv")


def test_a_refusal_near_the_longest_span_a_request_may_have_is_a_refusal():
    """Starts that are tried end later than any request may."""
    asked = document("las_vegas_2015.json")
    asked["initial_state"]["epoch"] = "2015-02-26T17:26:30Z"
    asked["sessions"][0] |= {"start": "2015-02-27T17:25:20Z", "stop": "2015-02-27T17:26:20Z"}
    with pytest.raises(slewtrack.Refused) as refused:
        slewtrack.plan(asked)
    problem = refused.value.problem
    assert problem.type.endswith(":not-visible")
    assert problem.earliest_feasible_start is not None


def test_only_what_is_meant_is_shown():
    assert dir(slewtrack) == sorted(slewtrack.__all__)
    assert set(FUNCTIONS) <= set(METHODS)


@pytest.mark.parametrize("name", METHODS)
def test_every_call_is_documented(name):
    """Arguments, answer, exceptions and an example that calls it with such arguments."""
    call = getattr(slewtrack.Client("http://here"), name)
    text = inspect.getdoc(call)
    parameters = inspect.signature(call).parameters
    assert "self" not in parameters
    for section in ("Args:", "Returns:", "Raises:", "Example"):
        assert section in text or (section == "Args:" and not parameters)
    for parameter in parameters:
        assert re.search(rf"^    {parameter}: \S", text, re.M)
    example = text.rpartition(">>> ")[2]
    compile(example, "example", "eval")
    assert re.search(rf"client\.{name}\(", example)


def test_importing_it_loads_neither_solvers_nor_compilers():
    heavy = "{'casadi', 'numba', 'cv2', 'scipy', 'fastapi', 'httpx'}"
    check = f"import sys, slewtrack; assert not {heavy} & set(sys.modules), sys.modules"
    subprocess.run([sys.executable, "-c", check], check=True)
