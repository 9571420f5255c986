"""A frame without a usable limb says why; one way to each reason not met elsewhere."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from horizon_cases import camera, case, ring
from scipy.spatial.transform import Rotation

from estimator.errors import Reason
from estimator.pipeline import estimate_vertical
from estimator.prediction import predict_horizon
from estimator.rendering.atmosphere import Atmosphere
from estimator.rendering.scene import Scene
from estimator.rendering.sensor import Sensor
from estimator.surroundings import Surroundings


@pytest.fixture(scope="module")
def pair():
    return case(np.random.default_rng(3101), ring(2))


@pytest.fixture(scope="module")
def alone(pair):
    """The request of the first camera alone."""
    return replace(pair.request, cameras=pair.request.cameras[:1])


def below_limb_px(request):
    """How far each pixel of the first camera's frame lies below the limb."""
    around = Surroundings(request.epoch, request.position, request.body)
    q = Rotation.from_quat(request.predicted.q_body_from_eci_xyzw)
    limb_px = predict_horizon(request.cameras[0], around, q).limb_px
    y, x = np.mgrid[0:480, 0:640]
    return y - np.interp(x, *limb_px[np.argsort(limb_px[:, 0])].T)


@pytest.mark.parametrize(
    ("half_width_px", "sky", "noise", "reason"),
    [(10.0, 20.0, 1.0, Reason.BLURRED), (25.0, 3.0, 0.0, Reason.NO_HORIZON)],
)
def test_a_terminator_taken_for_the_limb(alone, half_width_px, sky, noise, reason):
    # Dusk on the ground takes some 10 deg of Sun, 1100 km; here 80 and 200, right at the limb.
    soft = 100.0 * (1.0 + np.tanh(below_limb_px(alone) / half_width_px)) + sky
    soft += np.random.default_rng(1).normal(0.0, noise, (480, 640))
    assert estimate_vertical([soft.clip(0.0, 255.0).astype(np.uint8)], alone).reason is reason


def test_a_disc_with_the_night_behind_is_no_earth_and_the_suns_glare_no_layer(
    pair, alone, monkeypatch
):
    # 60 px, 250 km of light: no airglow, but no Earth either.
    crescent = np.where(below_limb_px(alone)[..., None] > 60.0, 3, pair.images[0]).astype(np.uint8)
    assert estimate_vertical([crescent], alone).reason is Reason.GLOWING_LAYER
    monkeypatch.setattr(Surroundings, "is_sun_in_frame", lambda *_: True)
    answer = estimate_vertical([crescent], alone)
    assert answer.reason is answer.cameras[0].reason is Reason.SUN_IN_FRAME


def test_a_bright_limb_before_a_dark_sea_is_no_airglow():
    """In thin, clean air it is as bright against what lies behind as a layer of airglow."""
    air = Atmosphere(air_density=0.7, dust_optical_depth=0.0, haze_optical_depth=0.0, ozone=0.0)
    sea = Scene(atmosphere=air, cloud_cover=0.0, land=0.0, roughness_m=800.0)
    one = case(np.random.default_rng(3110), ring(2), scene=sea, sensor=Sensor())
    answer = estimate_vertical(one.images, one.request)
    assert [camera.reason for camera in answer.cameras] == [None, None]
    off = answer.geocentric.axes_body @ (answer.geocentric.nadir_body - one.geocentric_body)
    # Four sigma in two dimensions.
    assert off @ np.linalg.solve(answer.geocentric.covariance_rad2, off) < 19.3


def test_an_edge_sharper_than_air_is_no_limb(alone):
    drawn = np.where(below_limb_px(alone) > 0.0, 200, 5).astype(np.uint8)
    assert estimate_vertical([drawn], alone).reason is Reason.SHARP


@pytest.mark.parametrize(("left_px", "is_enough"), [(45.0, False), (230.0, True)])
def test_too_short_an_arc(pair, alone, left_px, is_enough):
    """Some 25 deg of limb are enough only where a prediction vouches for it."""
    mask = (((left_px, 0.0), (640.0, 0.0), (640.0, 480.0), (left_px, 480.0)),)
    request = replace(alone, cameras=(replace(alone.cameras[0], mask=mask),))
    reason = estimate_vertical(pair.images[:1], request).reason
    assert reason is (None if is_enough else Reason.SHORT_ARC)
    blind = replace(request, predicted=None)
    assert estimate_vertical(pair.images[:1], blind).reason is Reason.SHORT_ARC


def test_a_broken_arc(pair, alone):
    broken = pair.images[0].copy()
    broken[:, np.arange(640) % 160 > 40] = 1
    assert estimate_vertical([broken], alone).reason is Reason.BROKEN_ARC


def test_a_limb_higher_than_any_daylight():
    one = case(
        np.random.default_rng(3110),
        ring(4),
        scene=Scene(constant_limb_m=52e3, cloud_cover=0.0, land=0.0),
        sensor=Sensor(),
    )
    assert estimate_vertical(one.images, one.request).reason is Reason.LIMB_HEIGHT


def test_a_sun_too_low_for_one_camera():
    one = case(np.random.default_rng(3120), ring(1), sun_deg=(0.0, 4.0))
    assert estimate_vertical(one.images, one.request).reason is Reason.LOW_SUN


def test_cameras_that_contradict_each_other(pair):
    # 40 px are 4 deg: as if the second camera were mounted that far off.
    moved = cv2.warpAffine(
        pair.images[1],
        np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 40.0]]),
        (640, 480),
        borderMode=cv2.BORDER_REPLICATE,
    )
    answer = estimate_vertical([pair.images[0], moved], pair.request)
    assert answer.reason is Reason.CAMERAS_DISAGREE


def test_a_camera_that_looks_elsewhere(pair):
    cameras = (pair.request.cameras[0], camera("up", 270.0, down_deg=-35.0))
    clear = np.random.default_rng(3130).integers(0, 4, (480, 640, 3)).astype(np.uint8)
    clear[200:280, 300:380] = 200  # a neighbour
    answer = estimate_vertical([pair.images[0], clear], replace(pair.request, cameras=cameras))
    assert answer.cameras[0].used
    assert answer.cameras[1].reason is Reason.ELSEWHERE
