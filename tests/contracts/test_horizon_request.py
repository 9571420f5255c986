"""Do the request's classes carry exactly the fields of POST /v1/horizon/estimates?"""

import json

import pytest
from pydantic import TypeAdapter, ValidationError

from estimator.request import HorizonRequest

CAMERA = {
    "name": "pitch",
    "width_px": 640,
    "height_px": 480,
    "fx_px": 554.0,
    "fy_px": 554.0,
    "cx_px": 319.5,
    "cy_px": 239.5,
    "distortion": [0.01, 0, 0, 0, 0],
    "q_camera_from_body_xyzw": [0, 0, 0, 1],
    "mask": [[[0, 0], [100, 0], [0, 100]]],
}
BODY = {
    "epoch": "2026-03-20T12:00:00Z",
    "position": {"frame": "EME2000", "position_km": [6800.0, 0.0, 0.0]},
    "cameras": [CAMERA],
    "body": {"a_km": 6378.137, "b_km": 6356.752, "limb_height_km": 20, "limb_height_sigma_km": 4},
    "predicted": {"q_body_from_eci_xyzw": [0, 0, 0, 1], "sigma_deg": 0.5},
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
        (("cameras", 0, "fx_px"), -1.0, r"1..1e\+06"),
        (("cameras", 0, "width_px"), 10**6, "16..16384"),
        (("cameras", 0, "q_camera_from_body_xyzw"), [0, 0, 0, 2], "unit quaternion"),
        (("cameras", 0, "focal_mm"), 50.0, "focal_mm"),
        (("body", "limb_height_sigma_km"), -1.0, "0..100"),
        (("body", "b_km"), 7000.0, "b_km"),
        (("predicted", "sigma_deg"), 400.0, "0..180"),
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
