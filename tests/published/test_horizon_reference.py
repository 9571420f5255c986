"""The estimator finds what published images and tables say."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimator.camera import HorizonCamera
from estimator.images import decode_image
from estimator.limb.low_sun import chapman_path, sun_rise_m
from estimator.limb.points import gumbel_shift
from estimator.pipeline import estimate_vertical
from estimator.request import Body, HorizonRequest, Position

DATA = Path(__file__).parents[1] / "data" / "horizon"


@pytest.mark.parametrize("limb_height_sigma_km", [0.0, 0.001, 1.0])
def test_found_image_within_a_tenth_of_a_pixel(limb_height_sigma_km):
    """UWCubeSat FOUND: camera at x = 10378137 m, RA 140, dec 0, 85 mm, 20 um pixels."""
    boresight = np.array([np.cos(np.deg2rad(140.0)), np.sin(np.deg2rad(140.0)), 0.0])
    down = np.array([0.0, 0.0, -1.0])
    c = np.stack([np.cross(down, boresight), down, boresight])
    camera = HorizonCamera(
        name="found",
        width_px=512,
        height_px=512,
        fx_px=4250.0,
        fy_px=4250.0,
        cx_px=255.5,
        cy_px=255.5,
        q_camera_from_body_xyzw=tuple(Rotation.from_matrix(c).as_quat().tolist()),
        lens_sigma=0.0,
    )
    request = HorizonRequest(
        epoch=datetime(2026, 3, 20, 12, tzinfo=UTC),
        position=Position(frame="ITRF", position_km=(10378.137, 0.0, 0.0)),
        cameras=(camera,),
        body=Body(
            a_km=6378.137,
            b_km=6378.137,
            limb_height_km=0.0,
            limb_height_sigma_km=limb_height_sigma_km,
        ),
    )
    image = decode_image((DATA / "found_example_earth1.png").read_bytes())
    answer = estimate_vertical([image], request)
    assert answer.geocentric is not None
    off = np.linalg.norm(answer.geocentric.nadir_body - [-1.0, 0.0, 0.0])
    assert np.rad2deg(off) * 3600.0 < 4.85  # its makers state an error of 1339.65 arcsec


def test_chapman_path_in_its_known_limits():
    zenith, horizontal, sunk = chapman_path(np.deg2rad([90.0, 0.0, -2.0]))
    assert zenith == pytest.approx(1.0, abs=2e-3)  # 1 - 1/X, X = 838 scale heights
    x = 6371.0 / 7.6
    assert horizontal == pytest.approx(np.sqrt(np.pi * x / 2.0), rel=1e-3)  # Chapman 1931
    assert sunk > 2.0 * horizontal


@pytest.mark.parametrize(
    ("sun_deg", "rise_km", "within_km"), [(10, 1, 0.7), (0, 5, 2), (-4, 20, 4)]
)
def test_low_sun_lifts_the_limb_as_observed(sun_deg, rise_km, within_km):
    # Design notes' values for the daylight limb; their scatter is a third of the rise.
    rise = sun_rise_m(np.deg2rad(np.array([float(sun_deg)])))[0] / 1e3
    assert rise == pytest.approx(rise_km, abs=within_km)


def test_blurred_gumbel_moves_from_mode_towards_mean():
    assert gumbel_shift(0.0) == pytest.approx(0.0, abs=0.01)  # the mode of Gumbel's law
    # Towards its mean, Euler's constant, less third cumulant / (2 variance): 2.404, 36 + 1.645.
    expected = 0.5772 - 2.404 / (2.0 * 37.645)
    assert gumbel_shift(6.0) == pytest.approx(expected, abs=0.01)  # one step of the table
