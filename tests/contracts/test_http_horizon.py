"""The horizon over HTTP measures, predicts and draws, and takes no file amiss."""

import base64
import json

import cv2
import erfa
import numpy as np
import other_body
import pytest
from fastapi.testclient import TestClient
from scipy.spatial.transform import Rotation, RotationSpline
from upload_cases import ANSWERED, REFUSED

from app.http.app import create_app
from app.requests.examples import ESTIMATE_EXAMPLE, LAS_VEGAS, PICTURE_EXAMPLES, PREDICTION_EXAMPLES
from app.settings import Settings

AHEAD = ESTIMATE_EXAMPLE["cameras"][0]
RIGHT = ESTIMATE_EXAMPLE["cameras"][1]

ESTIMATES = "/v1/horizon/estimates"
ONE_CAMERA = {**ESTIMATE_EXAMPLE, "cameras": [AHEAD]}
FOUR_SIGMA = 18.4  # chi-square of two degrees of freedom, one in 10,000


@pytest.fixture(scope="module")
def pictures(pytestconfig):
    examples = pytestconfig.rootpath / "examples"
    return [(examples / f"horizon_{name}.png").read_bytes() for name in ("ahead", "right")]


def post(client, request, images):
    files = [("images", (f"{k}.png", content)) for k, content in enumerate(images)]
    return client.post(ESTIMATES, data={"request": json.dumps(request)}, files=files)


def refused(answer, slug, field=None, status=422):
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["type"] in (f"urn:slewtrack:problem:{slug}", slug), problem
    assert problem.get("field") == field, problem
    return problem


@pytest.fixture(scope="module")
def estimate(client, pictures):
    answer = post(client, {**ESTIMATE_EXAMPLE, "overlay": True}, pictures)
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_the_nadir_of_the_example_is_the_body_axis_it_was_rendered_with(estimate):
    """LVLH at zero angles: +Z is geocentric nadir by definition."""
    assert estimate["verdict"] == "consistent"
    nadir, axes = np.array(estimate["nadir_body"]), np.array(estimate["axes_body"])
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-8)  # the answer's digits
    np.testing.assert_allclose(axes @ nadir, 0.0, atol=1e-8)
    off_deg = np.degrees(axes @ (nadir - [0.0, 0.0, 1.0]))
    covariance = np.array(estimate["covariance_deg2"])
    assert off_deg @ np.linalg.solve(covariance, off_deg) < FOUR_SIGMA
    assert estimate["sigma_deg"] == pytest.approx(np.sqrt(np.trace(covariance)), rel=1e-6)
    assert estimate["sigma_deg"] < 0.1
    assert estimate["check"]["angle_deg"] == pytest.approx(np.linalg.norm(off_deg), rel=1e-3)
    assert 2.0 < estimate["limb_height_km"] < 45.0


def test_geodetic_nadir_is_that_of_erfa(estimate):
    x, y, z = np.array(ESTIMATE_EXAMPLE["position"]["position_km"]) * 1e3
    _, latitude, _ = erfa.gc2gd(1, [x, y, z])
    geocentric = np.arctan2(z, np.hypot(x, y))
    between = np.degrees(np.arccos(np.dot(estimate["nadir_body"], estimate["nadir_geodetic_body"])))
    # Both nadirs carry the same error of the attitude; a hundredth of a degree is the heading's.
    assert between == pytest.approx(np.degrees(latitude - geocentric), abs=0.01)


def test_cameras_tell_what_they_saw(estimate):
    assert [camera["name"] for camera in estimate["cameras"]] == ["ahead", "right"]
    for camera in estimate["cameras"]:
        assert camera["used"]
        assert camera["reason"] is None
        assert 30.0 < camera["arc_deg"] < 90.0
        assert 0.0 < camera["residual_px"] < 1.0
        overlay = cv2.imdecode(
            np.frombuffer(base64.b64decode(camera["overlay_png"]), np.uint8), cv2.IMREAD_UNCHANGED
        )
        assert overlay.shape == (480, 640, 3)
        assert np.any(overlay[..., 1] > overlay[..., 0].astype(int) + 100)  # green limb points


def test_the_request_may_be_a_file_too(client, pictures):
    parts = [("request", ("r.json", json.dumps(ESTIMATE_EXAMPLE), "application/json"))]
    parts += [("images", ("a.png", content, "image/png")) for content in pictures]
    answer = client.post(ESTIMATES, files=parts)
    assert answer.status_code == 200, answer.text
    assert answer.json()["cameras"][0]["overlay_png"] is None


@pytest.mark.parametrize("name", REFUSED)
def test_files_that_are_no_whole_images_are_refused(client, name):
    problem = refused(post(client, ONE_CAMERA, [REFUSED[name]]), "invalid-image", "images.0")
    assert "Traceback" not in json.dumps(problem)


@pytest.mark.parametrize("name", ANSWERED)
def test_odd_files_show_no_horizon(client, name):
    answer = post(client, ONE_CAMERA, [ANSWERED[name]])
    assert answer.status_code == 200, answer.text
    assert answer.json()["verdict"] == "not_observable"
    assert answer.json()["nadir_body"] is None
    assert answer.json()["reason"]


def test_too_many_pixels_are_refused_before_they_are_decoded(client):
    large = {**AHEAD, "width_px": 7071, "height_px": 7071, "cx_px": 3535.0, "cy_px": 3535.0}
    answer = post(client, {**ONE_CAMERA, "cameras": [large]}, [b"\x89PNG\r\n\x1a\n"])
    assert "25000000" in refused(answer, "invalid-camera", "cameras")["detail"]


def test_images_and_cameras_must_come_out(client, pictures):
    refused(post(client, ESTIMATE_EXAMPLE, pictures[:1]), "invalid-camera", "images")


@pytest.mark.parametrize(
    ("parts", "field"),
    [
        ([("images", ("a.png", b"x"))], "request"),
        ([("request", ("r.json", b"{}"))], "images"),
        ([("request", ("r.json", b"{}")), ("pictures", ("a.png", b"x"))], "pictures"),
        ([("request", ("r.json", b" " * 2_000_000)), ("images", ("a.png", b"x"))], "request"),
        ([("request", ("r.json", b"{")), ("images", ("a.png", b"x"))], None),
        ([("images", (f"{k}.png", b"x")) for k in range(40)], None),
    ],
)
def test_other_parts_are_refused(client, parts, field):
    refused(client.post(ESTIMATES, files=parts), "invalid-request", field)


def test_fields_of_the_request_are_named(client, pictures):
    camera = {**AHEAD, "fx_px": float("nan")}
    answer = post(client, {**ONE_CAMERA, "cameras": [camera]}, pictures[:1])
    refused(answer, "invalid-request", "cameras.0.fx_px")


@pytest.mark.parametrize(
    ("headers", "content", "status"),
    [
        ({"Content-Type": "application/json"}, b"{}", 415),
        ({"Content-Type": "multipart/form-data"}, b"--x--", 422),
        ({"Content-Type": "multipart/form-data; boundary=x"}, b"no boundary here", 422),
        ({"Content-Type": "multipart/form-data; boundary=x"}, b"--x\r\n\r\nno name\r\n--x--", 422),
        ({"Content-Type": "multipart/form-data; boundary=x"}, b" " * 10_001, 413),
    ],
)
def test_bodies_that_are_no_form_are_refused(headers, content, status):
    with TestClient(create_app(Settings(max_upload_bytes=10_000))) as client:
        answer = client.post(ESTIMATES, content=content, headers=headers)
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"


@pytest.fixture(scope="module")
def prediction(client):
    answer = client.post("/v1/horizon/predictions", json=PREDICTION_EXAMPLES["pass"][1])
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_a_view_per_instant_and_camera(prediction):
    seen = [(view["at"], view["camera"], view["usable"]) for view in prediction["views"]]
    day, night = "2015-02-27T17:37:00.000Z", "2015-02-27T18:15:00.000Z"
    assert seen == [
        (day, "ahead", True), (day, "right", True), (night, "ahead", False),
        (night, "right", False),
    ]  # fmt: skip
    for view in prediction["views"][2:]:
        assert view["reason"] == "night_side"
        assert view["limb_in_frame"]
        assert not view["lit"]
        assert view["sigma_deg"] is None


def test_the_limb_is_predicted_where_a_round_earth_has_it(prediction):
    """A sphere of the Earth's radius there and 17.5 km of air; flattening bends it by 0.1 deg."""
    r_km = np.linalg.norm(ESTIMATE_EXAMPLE["position"]["position_km"])
    dip = np.arccos((6371.0 + 17.5) / r_km)
    for view, camera in zip(prediction["views"][:2], (AHEAD, RIGHT), strict=True):
        pixel = np.array(view["limb_px"])
        plane = (pixel - [camera["cx_px"], camera["cy_px"]]) / camera["fx_px"]
        ray = np.column_stack([plane, np.ones(len(plane))])
        body = Rotation.from_quat(camera["q_camera_from_body_xyzw"]).inv().apply(ray)
        below = np.arcsin(body[:, 2] / np.linalg.norm(body, axis=1))
        np.testing.assert_allclose(np.degrees(below), np.degrees(dip), atol=0.2)
        azimuth = np.unwrap(np.arctan2(body[:, 1], body[:, 0]))
        # Both ends of the line lie up to a step of 1.3 deg inside the frame.
        assert np.degrees(np.ptp(azimuth)) == pytest.approx(view["arc_deg"], abs=2.0)


def test_the_sun_is_where_erfa_has_it(prediction):
    """erfa's epv00 for the Earth; aberration and light time make 0.006 deg."""
    earth, _ = erfa.epv00(*erfa.dtf2d("UTC", 2015, 2, 27, 17, 37, 0.0))
    sun = -earth["p"] / np.linalg.norm(earth["p"])
    q = Rotation.from_quat(ESTIMATE_EXAMPLE["predicted"]["q_body_from_eci_xyzw"])
    for view, camera in zip(prediction["views"][:2], (AHEAD, RIGHT), strict=True):
        in_camera = Rotation.from_quat(camera["q_camera_from_body_xyzw"]).apply(q.apply(sun))
        off_deg = np.degrees(np.arccos(in_camera[2]))
        assert view["sun_angle_deg"] == pytest.approx(off_deg, abs=0.01)
        assert not view["sun_in_frame"]


def test_the_predicted_sigma_is_that_of_the_estimate(client, pictures, prediction):
    alone = post(client, ONE_CAMERA, pictures[:1]).json()
    # The picture's own scatter of the limb is a draw of the expected one.
    assert alone["sigma_deg"] == pytest.approx(prediction["views"][0]["sigma_deg"], rel=0.3)


@pytest.mark.parametrize(
    ("change", "slug", "field"),
    [
        ({"instants": ["2015-02-27T17:37:00"]}, "invalid-request", "instants.0"),
        ({"instants": ["2015-06-27T17:37:00Z"]}, "outside-coverage", None),
        ({"body": {"a_km": 9000.0, "b_km": 9000.0}}, "invalid-input", "body"),
    ],
)
def test_predictions_are_refused_with_the_field(client, change, slug, field):
    body = {**PREDICTION_EXAMPLES["pass"][1], **change}
    answer = client.post("/v1/horizon/predictions", json=body)
    assert answer.status_code == 422, answer.text
    assert answer.json()["type"].endswith(slug), answer.text
    if field is not None:
        assert answer.json()["field"] == field


def test_a_plan_says_what_its_cameras_will_see(client):
    body = {**LAS_VEGAS, "horizon_cameras": [AHEAD, RIGHT]}
    plan = client.post("/v1/plans", json=body).json()
    checks = plan["horizon_checks"]
    assert [(c["session"], c["camera"], c["usable"]) for c in checks] == [
        (0, "ahead", True),
        (0, "right", True),
    ]
    session = LAS_VEGAS["sessions"][0]
    for check in checks:
        assert {view["camera"] for view in check["views"]} == {check["camera"]}
        moments = [view["at"][:19] + "Z" for view in check["views"]]
        assert moments == [session["start"], "2015-02-27T17:37:05Z", session["stop"]]


def test_the_plan_of_a_body_says_what_its_cameras_will_see(client):
    """As predicted with the attitude that SciPy's spline through the table's rows has."""
    request = other_body.body_request(sessions=1)
    plan = client.post("/v1/plans", json={**request, "horizon_cameras": [AHEAD, RIGHT]}).json()
    table = plan["table"]
    rows = Rotation.from_quat(np.transpose([table[f"q_eci_from_body_{part}"] for part in "xyzw"]))
    q_eci_from_body = RotationSpline(table["t_s"], rows)
    checks = plan["horizon_checks"]
    assert [check["camera"] for check in checks] == ["ahead", "right"]
    assert any(view["usable"] for check in checks for view in check["views"])
    for k in range(3):
        at = checks[0]["views"][k]["at"]
        since = np.datetime64(at[:-1]) - np.datetime64(table["epoch"][:-1])
        q_body_from_eci = q_eci_from_body(since / np.timedelta64(1, "s")).inv()
        law = {"law": "inertial", "epoch": at, "q_body_from_eci_xyzw": [*q_body_from_eci.as_quat()]}
        body = {"orbit": request["orbit"], "attitude": law, "cameras": [AHEAD, RIGHT]}
        answer = client.post("/v1/horizon/predictions", json={**body, "instants": [at]})
        for check, view in zip(checks, answer.json()["views"], strict=True):
            seen = check["views"][k]
            assert (seen["usable"], seen["arc_deg"]) == (view["usable"], view["arc_deg"])
            # 1e-6 deg between two curves through rows of 13 decimals are 1e-5 pixels.
            np.testing.assert_allclose(seen["limb_px"], view["limb_px"], atol=1e-3)


@pytest.fixture(scope="module")
def picture(client):
    answer = client.post(
        "/v1/horizon/images",
        json=PICTURE_EXAMPLES["ahead"][1],
        headers={"Accept": "application/json"},
    )
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_the_example_picture_is_the_one_rendered(pictures, picture):
    rendered = cv2.imdecode(
        np.frombuffer(base64.b64decode(picture["image_png"]), np.uint8), cv2.IMREAD_UNCHANGED
    )
    kept = cv2.imdecode(np.frombuffer(pictures[0], np.uint8), cv2.IMREAD_UNCHANGED)
    # Another processor may round a pixel's noise the other way.
    assert np.mean(rendered != kept) < 1e-3
    np.testing.assert_allclose(picture["nadir_body"], [0.0, 0.0, 1.0], atol=1e-8)
    np.testing.assert_allclose(
        picture["position_itrf_km"], ESTIMATE_EXAMPLE["position"]["position_km"], atol=1e-6
    )


def test_a_picture_comes_as_png_by_itself(client):
    small = {**AHEAD, "width_px": 64, "height_px": 48, "fx_px": 55.4, "fy_px": 55.4}
    small |= {"cx_px": 31.5, "cy_px": 23.5}
    sensor = {"bits": 16, "colour": True}
    body = {**PICTURE_EXAMPLES["ahead"][1], "camera": small, "sensor": sensor}
    answer = client.post("/v1/horizon/images", json=body)
    assert answer.headers["content-type"] == "image/png"
    pixels = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert pixels.shape == (48, 64, 3)
    assert pixels.dtype == np.uint16
