"""Plan, look, correct, plan again: a frame of the horizon makes the next plan surer, rightly.

Over HTTP, with rendered frames: the answers of one request go into the next as they are.
"""

import base64
import copy
import json

import numpy as np
import pytest
from planner_values import read_request
from scipy.spatial.transform import Rotation
from waiting import PatientClient

from app.http.app import create_app
from app.requests.examples import ESTIMATE_EXAMPLE, LAS_VEGAS
from planner.world.frames.time_scales import Instants, utc_from_text

AHEAD = ESTIMATE_EXAMPLE["cameras"][0]
RIGHT = ESTIMATE_EXAMPLE["cameras"][1]

MEAN = {"law": "lvlh", "yaw_deg": -4.0, "pitch_deg": -2.0, "roll_deg": 0.8}
# An error that the law's own figures allow: 1 sigma of the mean about Y, the swing at its 1.3
# sigma about X, growing towards the session as a sinusoid of the orbital rate would.
LOOKS = {"2015-02-27T17:28:20Z": (0.25, 0.05, 0.0), "2015-02-27T17:34:20Z": (0.30, 0.05, 0.0)}
SESSION_TURN_DEG = (0.31, 0.05, 0.0)


@pytest.fixture(scope="module")
def client():
    with PatientClient(create_app()) as client:
        yield client


def picture(client, attitude, at, camera):
    """The service's rendering with the carrier so turned, and what it tells of it."""
    body = {"orbit": LAS_VEGAS["orbit"], "attitude": attitude, "camera": camera, "at": at,
            "scene": {"cloud_cover": 0.5, "roughness_m": 800.0},
            "sensor": {"blur_px": 0.7, "bits": 8}, "seed": 3}  # fmt: skip
    answer = client.post("/v1/horizon/images", json=body, headers={"Accept": "application/json"})
    assert answer.status_code == 200, answer.text
    return answer.json()


def turned(turn_deg):
    """The mean attitude with the body turned further by a rotation vector in body axes."""
    angles = [MEAN[name] for name in ("yaw_deg", "pitch_deg", "roll_deg")]
    law = Rotation.from_euler("ZYX", angles, degrees=True).inv()
    true = Rotation.from_rotvec(turn_deg, degrees=True) * law
    yaw_deg, pitch_deg, roll_deg = true.inv().as_euler("ZYX", degrees=True)
    return {"law": "lvlh", "yaw_deg": yaw_deg, "pitch_deg": pitch_deg, "roll_deg": roll_deg}


def look(client, at, turn_deg):
    """The correction that two rendered frames give."""
    frames = [picture(client, turned(turn_deg), at, camera) for camera in (AHEAD, RIGHT)]
    planned = picture(client, MEAN, at, AHEAD)
    asked = {
        "epoch": at,
        "position": {"frame": "ITRF", "position_km": planned["position_itrf_km"]},
        "cameras": [AHEAD, RIGHT],
        "predicted": {"q_body_from_eci_xyzw": planned["q_body_from_eci_xyzw"], "sigma_deg": 0.5},
    }
    files = [("images", (f"{k}.png", base64.b64decode(frame["image_png"])))
             for k, frame in enumerate(frames)]  # fmt: skip
    answer = client.post("/v1/horizon/estimates", data={"request": json.dumps(asked)}, files=files)
    assert answer.status_code == 200, answer.text
    return answer.json()["correction"]


@pytest.fixture(scope="module")
def corrections(client):
    return [look(client, at, turn_deg) for at, turn_deg in LOOKS.items()]


def request(corrections=()):
    document = copy.deepcopy(LAS_VEGAS)
    document["attitude"] = MEAN | ({"corrections": list(corrections)} if corrections else {})
    return document


def plan(client, corrections=()):
    return client.post("/v1/plans", json=request(corrections))


def test_the_measured_turn_is_the_one_rendered(corrections):
    for correction, turn_deg in zip(corrections, LOOKS.values(), strict=True):
        off_deg = np.array(correction["turn_body_deg"]) - turn_deg
        covariance = np.array(correction["covariance_deg2"])
        assert off_deg @ np.linalg.solve(covariance, off_deg) < 18.4  # 1 in 10,000, two free
        assert np.hypot(*off_deg[:2]) < 0.1


def test_the_next_plan_is_surer_and_points_where_the_carrier_is(client, corrections):
    before, after = plan(client).json(), plan(client, corrections).json()
    assert before["state"] == after["state"] == "done", after
    probabilities = [one["uncertainty"][0]["probability_in_frame"] for one in (before, after)]
    assert probabilities[0] < 0.75 < 0.9 < probabilities[1]
    attitude = {
        name: next(c for c in one["uncertainty"][0]["contributions"] if c["cause"] == "attitude")
        for name, one in (("before", before), ("after", after))
    }
    assert attitude["after"]["sigma_arcsec"] < 0.5 * attitude["before"]["sigma_arcsec"]
    assert "corrected by 2 corrections" in attitude["after"]["basis"]
    assert any("the attitude follows 2 corrections" in text for text in after["warnings"])


def test_the_law_follows_the_carrier(corrections):
    """To the size that its budget tells, from three times that before."""
    law = read_request(request(corrections)).attitude
    middle = Instants(utc_from_text("2015-02-27T17:37:05Z"), np.zeros(1))
    off_deg = np.rad2deg(law.turn_rad(middle)[0]) - SESSION_TURN_DEG
    told_deg = np.rad2deg(np.sqrt(np.sum(law.errors(middle).modes_body_rad[:, 0] ** 2, axis=0)))
    assert (np.abs(off_deg) < 3.0 * told_deg).all()
    assert np.hypot(*off_deg[:2]) < np.hypot(*SESSION_TURN_DEG[:2]) / 3.0


def test_a_frame_that_contradicts_the_law_is_refused(client, corrections):
    """5 sigma of the mean and swing about Y are 0.28 deg."""
    wrong = {**corrections[1], "turn_body_deg": [0.3, 0.45, 0.0]}
    answer = plan(client, [corrections[0], wrong])
    assert answer.status_code == 422
    problem = answer.json()
    assert problem["field"] == "attitude.corrections"
    assert "sigma from the law" in problem["detail"]
