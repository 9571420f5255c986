"""Requests about the horizon are read with exactly their fields, and within their bounds."""

import json

import pytest
from pydantic import TypeAdapter, ValidationError

from app.requests.examples import ESTIMATE_EXAMPLE, LAS_VEGAS, PICTURE_EXAMPLES, PREDICTION_EXAMPLES
from app.requests.plan import read_plan_request
from app.work.horizon import PICTURE_READER, PREDICTION_READER
from estimator.request import HorizonRequest
from planner.base.errors import InvalidRequest

AHEAD = ESTIMATE_EXAMPLE["cameras"][0]

CAMERA = AHEAD | {"distortion": [0.01, 0, 0, 0, 0], "mask": [[[0, 0], [100, 0], [0, 100]]]}
BODY = ESTIMATE_EXAMPLE | {
    "cameras": [CAMERA],
    "body": {"a_km": 6378.137, "b_km": 6356.752, "limb_height_km": 20, "limb_height_sigma_km": 4},
    "overlay": True,
}
READ = TypeAdapter(HorizonRequest)


def test_the_whole_request_is_read():
    request = READ.validate_json(json.dumps(BODY))
    assert request.cameras[0].mask == (((0, 0), (100, 0), (0, 100)),)
    assert request.overlay


def test_what_may_be_left_out():
    short = {k: BODY[k] for k in ("epoch", "position")}
    short["cameras"] = [{k: v for k, v in CAMERA.items() if k not in ("distortion", "mask")}]
    assert READ.validate_json(json.dumps(short)).predicted is None


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("epoch",), "2026-03-20T12:00:00", "offset"),
        (("position", "position_km"), [100.0, 0.0, 0.0], "above"),
        (("cameras",), [], "1 to 16"),
        (("cameras",), [CAMERA, CAMERA], "names"),
        (("cameras", 0, "q_camera_from_body_xyzw"), [0, 0, 0, 2], "unit quaternion"),
        (("cameras", 0, "focal_mm"), 50.0, "focal_mm"),
        (("body", "b_km"), 7000.0, "b_km"),
    ],
)
def test_nonsense_is_refused_with_a_way_out(path, value, said):
    body = json.loads(json.dumps(BODY))
    at = body
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    with pytest.raises(ValidationError, match=said):
        READ.validate_json(json.dumps(body))


PREDICTION = PREDICTION_EXAMPLES["pass"][1]
PICTURE = PICTURE_EXAMPLES["ahead"][1]


def refused(read, document, says):
    with pytest.raises(InvalidRequest) as refusal:
        read(json.dumps(document).encode())
    assert says in str(refusal.value)


def test_pictures_of_four_megapixels_are_rendered_and_of_more_not():
    def of(width_px, height_px):
        return PICTURE | {"camera": AHEAD | {"width_px": width_px, "height_px": height_px}}

    assert PICTURE_READER.read(json.dumps(of(2100, 2000)).encode()).camera.width_px == 2100
    refused(PICTURE_READER.read, of(2101, 2000), "4200000 pixels are rendered, not 4202000")
    refused(PICTURE_READER.read, PICTURE | {"at": "2015-02-27T17:37:00"}, "offset")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"instants": []}, "must come to 1 to 2000, not 0 x 2"),
        ({"instants": ["2015-02-27T17:37:00Z"] * 1001}, "must come to 1 to 2000, not 1001 x 2"),
        ({"instants": ["2015-02-27T17:37:00"]}, "offset"),
        ({"instants": ["2015-02-27T00:00:00Z", "2015-03-02T00:00:01Z"]}, "within 3 days"),
        ({"cameras": [AHEAD, AHEAD]}, "need names of their own"),
    ],
)
def test_views_that_are_too_many_or_too_far_apart_are_not_foretold(change, says):
    refused(PREDICTION_READER.read, PREDICTION | change, says)


def test_three_days_and_two_thousand_views_are_foretold():
    first, last = "2015-02-27T00:00:00Z", "2015-03-02T00:00:00Z"
    most = PREDICTION | {"instants": [first] * 999 + [last]}
    assert len(PREDICTION_READER.read(json.dumps(most).encode()).instants) == 1000


def test_cameras_of_a_plan_have_names_of_their_own():
    refused(
        read_plan_request, LAS_VEGAS | {"horizon_cameras": [AHEAD, AHEAD]}, "names of their own"
    )
