"""A request that is written is read as the same request."""

import json
from pathlib import Path

import pytest

from app.requests.plan import read_plan_request, write_plan_request

EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS = json.loads((EXAMPLES / "las_vegas_2015.json").read_text())
FIELDS = {
    "nothing more": {},
    "null where that is no default": {"slew": {"filter_cutoff_hz": None, "lead": "all"}},
    "nested values": {
        "slew": {
            "lead": {"max_duration_s": 30.0},
            "keep_out": [{"body": "Sun", "half_angle_deg": 20.0}],
            "avoid_modes": [{"frequency_hz": 0.7, "damping": 0.01}],
        },
        "final_state": {"angles_deg": {"alpha": 1.0, "beta": -2.5}},
        "on_conflict": "least_loss",
    },
    "another kind of each union": {
        "attitude": {
            "law": "inertial",
            "epoch": "2015-02-27T17:36:00.25Z",
            "q_body_from_eci_xyzw": [0.0, 0.0, 0.6, 0.8],
        },
        "final_state": "rest",
        "final_by": "2015-02-27T18:00:00Z",
    },
    "a leap second": {"initial_state": {"epoch": "2016-12-31T23:59:60.4Z"}},
}


@pytest.mark.parametrize("fields", FIELDS.values(), ids=FIELDS)
def test_a_written_request_is_read_as_the_same(fields):
    document = LAS_VEGAS | fields
    if "initial_state" in fields:
        document["initial_state"] = LAS_VEGAS["initial_state"] | fields["initial_state"]
        times = {"start": "2017-01-01T00:01:00Z", "stop": "2017-01-01T00:02:00Z"}
        document["sessions"] = [LAS_VEGAS["sessions"][0] | times]
    request = read_plan_request(json.dumps(document).encode())
    written = write_plan_request(request, {"platform": "iss-hrc"}, ())
    assert read_plan_request(written) == request
    assert len(written) < 1.5 * len(json.dumps(document))  # what is as by default is left out


def test_words_stay_as_they_were_sent():
    """A name of a place, an orbit as it was copied from a page."""
    orbit = {"source": "tle", "content": "ISS\n{line1}\n{line2}".format(**LAS_VEGAS["orbit"])}
    place = {"mode": "place", "name": "Las Vegas, Nevada, US"}
    document = LAS_VEGAS | {"orbit": orbit}
    document["sessions"] = [LAS_VEGAS["sessions"][0] | {"target": place}]
    request = read_plan_request(json.dumps(document).encode())
    words = {"platform": "iss-hrc", "orbit": orbit}
    written = write_plan_request(request, words, [place])
    assert read_plan_request(written) == request
    assert json.loads(written)["orbit"] == orbit
    assert json.loads(written)["sessions"][0]["target"] == place
