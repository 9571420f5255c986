"""The functions of `slewtrack` do what the service does with the same JSON."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import slewtrack
from planner.base.errors import InvalidRequest, NotVisible, Refusal

EXAMPLES = Path(__file__).parents[2] / "examples"


def document(name):
    return json.loads((EXAMPLES / name).read_text())


def test_a_plan_of_bytes_a_dictionary_or_a_request():
    body = (EXAMPLES / "las_vegas_2015.json").read_bytes()
    plans = [
        slewtrack.plan(asked) for asked in (body, json.loads(body), slewtrack.read_request(body))
    ]
    for plan in plans:
        assert plan.verification.passed
        np.testing.assert_array_equal(plan.table.angle_rad, plans[0].table.angle_rad)


def test_opportunities_and_a_campaign():
    found = slewtrack.opportunities(document("opportunities_sky.json"))
    assert found.windows
    campaign = slewtrack.campaign(document("campaign_cities.json"))
    assert campaign.passes


def test_the_vertical_of_two_pictures():
    images = [(EXAMPLES / f"horizon_{side}.png").read_bytes() for side in ("ahead", "right")]
    estimate = slewtrack.estimate_vertical(images, document("horizon_estimate.json"))
    assert estimate.geocentric is not None


def test_an_imaging_session():
    told = []
    plan = slewtrack.plan_imaging(document("spacecraft_four_modes.json"), progress=told.append)
    assert plan.verification.passed
    assert told[-1].done == told[-1].of == plan.stabilisation.runs


def test_what_can_not_be_read_names_the_field():
    with pytest.raises(InvalidRequest) as refused:
        slewtrack.plan(document("las_vegas_2015.json") | {"platform": "hubble"})
    assert isinstance(refused.value, Refusal)
    assert refused.value.field == "platform"


def test_a_refusal_near_the_longest_span_a_request_may_have_is_a_refusal():
    """Starts that are tried end later than any request may."""
    asked = document("las_vegas_2015.json")
    asked["initial_state"]["epoch"] = "2015-02-26T17:26:30Z"
    asked["sessions"][0] |= {"start": "2015-02-27T17:25:20Z", "stop": "2015-02-27T17:26:20Z"}
    with pytest.raises(NotVisible) as refused:
        slewtrack.plan(asked)
    assert refused.value.earliest_feasible_start_utc is not None


def test_importing_it_loads_neither_solvers_nor_compilers():
    heavy = "{'casadi', 'numba', 'cv2', 'scipy', 'fastapi'}"
    check = f"import sys, slewtrack; assert not {heavy} & set(sys.modules), sys.modules"
    subprocess.run([sys.executable, "-c", check], check=True)
