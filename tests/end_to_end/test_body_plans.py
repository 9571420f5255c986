"""Plans of spacecraft that turn as a whole, by the same request with another platform."""

import json

import numpy as np
import pytest
from repository import ROOT
from waiting import PatientClient

from app.http.app import create_app
from app.requests.plan import read_plan_request
from planner.planning.sessions.pipeline import make_plan

SMALLSAT = {
    "kind": "body",
    "name": "smallsat",
    "agility": {
        "limits": "magnitude",
        "rate_max_deg_s": 3.0,
        "acceleration_max_deg_s2": 0.5,
        "jerk_max_deg_s3": 0.3,
        "settle_s": 4.0,
    },
    "off_nadir_max_deg": 60.0,
    "camera": {"type": "frame", "field_of_view_deg": [2.0, 1.5]},
}
STAR = {"mode": "star", "name": "Vega"}


def body_request(**changes):
    """The example of three sessions, with its platform exchanged."""
    request = json.loads((ROOT / "examples" / "three_sessions.json").read_text())
    del request["attitude"]
    request["initial_state"] = {"epoch": request["initial_state"]["epoch"]}
    return request | {"platform": SMALLSAT} | changes


def planned(request):
    return make_plan(read_plan_request(json.dumps(request).encode()))


@pytest.fixture(scope="module")
def client():
    with PatientClient(create_app()) as client:
        yield client


@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_three_cities_and_back_to_idle(objective):
    plan = planned(body_request(final_state="idle", slew={"objective": objective}))
    assert plan.verification.passed
    assert [segment.session for segment in plan.segments if segment.kind == "track"] == [0, 1, 2]
    rates_deg_s = np.degrees(np.linalg.norm(plan.table.rate_rad_s, axis=1))
    assert rates_deg_s.max() <= 3.0 * (1.0 + 1e-6)
