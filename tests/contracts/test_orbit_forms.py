"""Elements are read in every form in which people have them."""

import json

import numpy as np
import pytest
from planner_values import plan_of, read_request

from app.requests.examples import LAS_VEGAS, message
from planner.base.errors import InvalidRequest, OutsideCoverage
from planner.world.frames.time_scales import Instants, utc_from_text

OMM = message("elements.json")

[ELEMENTS] = json.loads(OMM)
LINES = [LAS_VEGAS["orbit"]["line1"], LAS_VEGAS["orbit"]["line2"]]
START, STOP = map(utc_from_text, ("2015-02-27T17:00:00Z", "2015-02-27T18:00:00Z"))


def states(orbit):
    read = read_request({**LAS_VEGAS, "orbit": orbit}).orbit
    return read.ephemeris(START, STOP).states(Instants(START, np.linspace(0.0, 3600.0, 7)))


@pytest.mark.parametrize(
    "content",
    [
        "\n".join(LINES),
        "ISS (ZARYA)\n" + "\n".join(LINES) + "\n",
        "0 ISS (ZARYA)             \r\n" + "  \r\n".join(LINES) + "\r\n\r\n",
        "1 2 3\n" + "\n".join(LINES),  # a name may look like a line
    ],
)
def test_two_and_three_lines_in_one_text(content):
    asked = states({"source": "tle", "content": content})
    assert (asked.r_sat_eci_m == states(LAS_VEGAS["orbit"]).r_sat_eci_m).all()


@pytest.mark.parametrize("form", [dict, lambda found: [found], lambda found: json.dumps([found])])
def test_an_omm_in_json_as_it_is(form):
    asked = states({"source": "omm", "content": form(ELEMENTS)})
    assert (asked.r_sat_eci_m == states({"source": "omm", "content": OMM}).r_sat_eci_m).all()


@pytest.mark.parametrize(
    "content",
    [[], [1], {}, {"EPOCH": {"a": 1}}, {"EPOCH": None}, [[]], True,
     {**ELEMENTS, "MEAN_MOTION": float("nan")},
     {**ELEMENTS, "MEAN_MOTION": 10.0**300},
     {**ELEMENTS, "ECCENTRICITY": True},
     {**ELEMENTS, "OBJECT_NAME": "ISS\u0000"}],
)  # fmt: skip
def test_an_omm_that_is_none_is_refused_at_its_field(content):
    request = {**LAS_VEGAS, "orbit": {"source": "omm", "content": content}}
    with pytest.raises(InvalidRequest) as refusal:
        read_request(request)
    assert all(error.field.startswith("orbit.content") for error in refusal.value.errors)


def test_elements_too_old_are_refused_at_the_text_they_came_in():
    late = {"start": "2015-04-27T17:36:20Z", "stop": "2015-04-27T17:37:20Z"}
    request = {
        **LAS_VEGAS,
        "orbit": {"source": "tle", "content": "\n".join(LINES)},
        "initial_state": {},
        "sessions": [LAS_VEGAS["sessions"][0] | late],
    }
    with pytest.raises(OutsideCoverage) as refusal:
        plan_of(request)
    assert refusal.value.field == "orbit.content"
