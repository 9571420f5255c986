"""The example requests are read as the API would read them, and hostile ones refused."""

import json
from pathlib import Path
from typing import get_args

import pytest
from pydantic import TypeAdapter, ValidationError

from app.requests.examples import SPACECRAFT_EXAMPLES
from app.requests.json_reader import VALUES_MAX
from app.requests.spacecraft import read_spacecraft_request
from planner.base.errors import InvalidMessage, InvalidRequest
from planner.spacecraft.requests import ImagingPlanRequest, Request

EXAMPLES = Path(__file__).parents[2] / "examples"
SCHEMA = TypeAdapter(ImagingPlanRequest)


def example():
    return json.loads((EXAMPLES / "spacecraft_four_modes.json").read_text(encoding="utf-8"))


def test_the_example_holds_every_mode():
    request = SCHEMA.validate_json(json.dumps(example()))
    modes, _ = get_args(Request)
    assert {type(one) for one in request.requests} == set(get_args(modes))


def test_features_and_request_say_the_same():
    text = (EXAMPLES / "spacecraft_four_modes.geojson").read_text(encoding="utf-8")
    by_features = json.dumps(example() | {"requests": json.loads(text)}).encode()
    assert read_spacecraft_request(by_features) == SCHEMA.validate_json(json.dumps(example()))


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("requests", 0, "geometry", "coordinates"), [[0.0, 0.0]], "2 to 64"),
        (("requests", 0, "geometry", "coordinates"), [[0.0, 0.0], [99.0, 99.0]], "off the map"),
        (("requests", 0, "surprise"), 1, "Unexpected"),
        (("requests", 1, "name"), "strip", "two requests are named 'strip'; names must differ"),
        (("start",), "2024-06-01T10:00:00", "UTC offset"),
        (("start",), "2024-06-01T10:00:00.1Z", "multiple of 0.2"),
        (("stop",), "2024-06-01T09:00:00Z", "10 to 3600 s"),
        (("spacecraft",), "teapot", "unknown"),
        (("settings",), {"rate_axis_max_deg_s": 99.0}, r"rate_axis_max_deg_s \(99\) .* the 3.5 "),
        (("settings",), {"torque_max_n_m": 31.0}, r"settings.torque_max_n_m \(31\) .* the 30 "),
        (("settings",), {"torque_rate_max_n_m_s": 151.0}, "settings.torque_rate_max_n_m_s"),
        (("settings",), {"rate_axis_max_deg_s": 0.05}, r"\(0.05\) is less than the 0.1 "),
        (("settings",), {"torque_max_n_m": 0.5}, r"torque_max_n_m \(0.5\) .* leave no torque"),
    ],
)
def test_bad_values_are_refused_by_name(path, value, message):
    document = example()
    place = document
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    with pytest.raises(ValidationError, match=message):
        SCHEMA.validate_json(json.dumps(document))


def test_a_stereo_pair_has_one_measure_of_its_two_moments():
    document = example()
    document["requests"][1].update({"gap_s": 100.0, "look_angle_deg": 24.0})
    with pytest.raises(ValidationError, match=r"look_angle_deg .* and gap_s .* leave one out"):
        SCHEMA.validate_json(json.dumps(document))


@pytest.mark.parametrize("mode", range(4))
@pytest.mark.parametrize(
    "change",
    [{"name": ""}, {"window_start": "2024-06-01T10:05:00Z", "window_stop": "2024-06-01T10:04:00Z"}],
)
def test_every_mode_is_asked_the_same(mode, change):
    document = example()
    document["requests"][mode].update(change)
    with pytest.raises(ValidationError, match=next(iter(change))):
        SCHEMA.validate_json(json.dumps(document))


@pytest.mark.parametrize("requests", [{}, {"features": []}, {"features": 1}, {"features": [1]}])
def test_hostile_geojson_is_refused(requests):
    with pytest.raises(InvalidMessage):
        read_spacecraft_request(json.dumps(example() | {"requests": requests}).encode())


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('"start": "2024-06-01T10:00:20Z"', "'start' is given 2 times"),
        (f'"x": [{"0," * VALUES_MAX}0]', f"more than {VALUES_MAX} values"),
    ],
    ids=["a field twice", "too many values"],
)
def test_features_are_read_as_strictly_as_a_list(more, said):
    """RFC 8259, section 4: which of two fields of one name counts is anybody's guess."""
    text = json.dumps(SPACECRAFT_EXAMPLES["geojson"][1])
    assert read_spacecraft_request(text.encode()).name == "One strip"
    with pytest.raises(InvalidRequest, match=said):
        read_spacecraft_request(f"{text[:-1]}, {more}}}".encode())
