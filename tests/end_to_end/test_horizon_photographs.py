"""The estimator on photographs taken from the ISS."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from estimator.camera import HorizonCamera
from estimator.check import Verdict
from estimator.errors import Reason
from estimator.images import decode_image
from estimator.overlay import draw_overlay, encode_png
from estimator.pipeline import estimate_vertical
from estimator.request import Body, HorizonRequest, Position

DATA = Path(__file__).parents[1] / "data" / "horizon"
NIGHT = ("iss030e227588", "iss045e024950", "iss047e007555", "iss071e234765")


def look(name, focal_mm, hour_utc=12, lens_sigma=None, **body):
    """The craft over 0 N 0 E, 418 km up; the sensor is 36 mm wide."""
    image = decode_image((DATA / f"{name}.jpg").read_bytes())
    height, width = image.shape[:2]
    focal_px = focal_mm / 36.0 * width
    camera = HorizonCamera(
        name="window",
        width_px=width,
        height_px=height,
        fx_px=focal_px,
        fy_px=focal_px,
        cx_px=0.5 * (width - 1),
        cy_px=0.5 * (height - 1),
        q_camera_from_body_xyzw=(0.0, 0.0, 0.0, 1.0),
        lens_sigma=lens_sigma,
    )
    request = HorizonRequest(
        epoch=datetime(2020, 11, 20, hour_utc, tzinfo=UTC),
        position=Position(frame="ITRF", position_km=(6796.1, 0.0, 0.0)),
        cameras=(camera,),
        body=Body(**body),
    )
    return image, camera, estimate_vertical([image], request)


def test_day_limb_is_followed_to_a_fifth_of_a_pixel():
    image, camera, answer = look("iss_day_20201120", 51.0, lens_sigma=0.0)
    assert answer.verdict is Verdict.MEASURED
    # Rms of 0.2 px is 0.3 km: the limb's own roughness is no less.
    assert answer.cameras[0].residual_px < 0.2
    # The daylight limb, 17.5 +- 4 km.
    assert 10e3 < answer.limb_height_m < 25e3
    # Down in the picture, and a camera on the horizon: 60-70 deg from nadir.
    nadir = answer.geodetic.nadir_body
    assert nadir[1] > 0.8
    assert 55.0 < np.rad2deg(np.arccos(nadir[2])) < 75.0
    picture = draw_overlay(image, camera, answer.cameras[0], answer)
    assert decode_image(encode_png(picture)).shape == image.shape


def test_flipped_day_limb_has_its_nadir_flipped():
    image, camera, answer = look("iss_day_20201120", 51.0)
    request = HorizonRequest(
        epoch=datetime(2020, 11, 20, 12, tzinfo=UTC),
        position=Position(frame="ITRF", position_km=(6796.1, 0.0, 0.0)),
        cameras=(camera,),
    )
    flipped = estimate_vertical([np.ascontiguousarray(image[::-1])], request)
    mirrored = answer.geodetic.nadir_body * [1.0, -1.0, 1.0]
    # The same pixels, but with the light from the other hand, so other headings are likelier.
    within = 0.5 * answer.geodetic.sigma_rad
    np.testing.assert_allclose(flipped.geodetic.nadir_body, mirrored, rtol=0, atol=within)


@pytest.mark.parametrize("lens_sigma", [0.0, None])
def test_a_focal_length_a_tenth_off_is_suspected(lens_sigma):
    _, _, answer = look("iss_day_20201120", 45.0, lens_sigma=lens_sigma)
    assert answer.verdict is Verdict.NOT_OBSERVABLE
    assert answer.reason is Reason.RESIDUALS


@pytest.mark.parametrize("name", NIGHT)
def test_night_frames_are_refused_at_night(name):
    _, _, answer = look(name, 28.0, hour_utc=0)
    assert answer.reason is Reason.NIGHT_SIDE


@pytest.mark.parametrize("name", NIGHT)
def test_airglow_is_refused_even_where_the_clock_says_day(name):
    _, _, answer = look(name, 24.0)
    assert answer.verdict is Verdict.NOT_OBSERVABLE


def test_night_mode_finds_the_airglow():
    _, _, answer = look(
        "iss045e024950", 28.0, hour_utc=0, limb_height_km=90.0, limb_height_sigma_km=6.0
    )
    assert answer.verdict is Verdict.MEASURED
    # The layer lies at 80-96 km; its upper edge is what is seen.
    assert 70e3 < answer.limb_height_m < 105e3
