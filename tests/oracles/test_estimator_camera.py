"""The camera model agrees with OpenCV's, and the limb with ERFA's geodesy."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimator.camera import HorizonCamera
from estimator.limb.geometry import Limb
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M, itrf_from_geodetic, up_itrf

BENT = (-0.28, 0.09, 6e-4, -4e-4, -0.012)


def camera(distortion=BENT):
    q = Rotation.from_euler("xyz", [20.0, -35.0, 70.0], degrees=True)
    return HorizonCamera(
        name="c",
        width_px=640,
        height_px=480,
        fx_px=520.0,
        fy_px=510.0,
        cx_px=310.0,
        cy_px=250.0,
        distortion=distortion,
        q_camera_from_body_xyzw=tuple(q.as_quat().tolist()),
    )


def test_projection_is_opencvs():
    c = camera()
    rng = np.random.default_rng(1)
    ray_camera = np.column_stack([rng.uniform(-0.5, 0.5, (200, 2)), np.ones(200)])
    intrinsics = np.array([[c.fx_px, 0.0, c.cx_px], [0.0, c.fy_px, c.cy_px], [0.0, 0.0, 1.0]])
    theirs, _ = cv2.projectPoints(
        ray_camera, np.zeros(3), np.zeros(3), intrinsics, np.array(c.distortion)
    )
    ours = c.pixels(c.q_camera_from_body.inv().apply(ray_camera))
    np.testing.assert_allclose(ours, theirs[:, 0], rtol=0, atol=1e-9)  # rounding of 500 px


def test_rays_undo_the_projection():
    c = camera()
    pixel = np.stack(np.meshgrid(np.linspace(0, 639, 9), np.linspace(0, 479, 9)), -1)
    pixel = pixel.reshape(-1, 2)
    np.testing.assert_allclose(c.pixels(c.rays_body(pixel)), pixel, rtol=0, atol=1e-6)


def test_distortion_that_folds_over_is_refused():
    with pytest.raises(ValueError, match="folds the image over"):
        camera(distortion=(-1.2, 0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("latitude_deg", [-89.999, -47.0, 0.0, 12.0, 80.0])
def test_geodetic_nadir_is_erfas(latitude_deg):
    latitude, longitude = np.deg2rad([latitude_deg, -71.0])
    limb = Limb(itrf_from_geodetic(latitude, longitude, 420e3), WGS84_A_M, WGS84_B_M)
    down = -up_itrf(latitude, longitude)
    # 1e-9 rad is 0.2 milliarcsec.
    np.testing.assert_allclose(limb.nadir_geodetic_itrf, down, rtol=0, atol=1e-9)


def test_limb_rays_touch_the_ellipsoid():
    limb = Limb(itrf_from_geodetic(0.8, 0.3, 500e3), WGS84_A_M, WGS84_B_M)
    height_m = 17.5e3
    rays = limb.directions_itrf(np.linspace(0.0, 2.0 * np.pi, 50), height_m)
    points = limb.touch_points_m(rays, height_m)
    axes = np.array([WGS84_A_M, WGS84_A_M, WGS84_B_M]) + height_m
    np.testing.assert_allclose(np.sum((points / axes) ** 2, axis=1), 1.0, rtol=0, atol=1e-12)
    normal = points / axes**2
    along = np.sum(rays * normal, axis=1) / np.linalg.norm(normal, axis=1)
    # A ray that leaves the tangent plane by 1e-7 rad misses the limb by 1e-14 of the radius.
    np.testing.assert_allclose(along, 0.0, rtol=0, atol=1e-7)


def test_limb_of_a_sphere_is_its_closed_form():
    limb = Limb(np.array([5e6, -3e6, 4e6]), 6.371e6, 6.371e6)
    rays = limb.directions_itrf(np.linspace(0.0, 6.0, 20), 10e3)
    sine = (6.371e6 + 10e3) / np.linalg.norm([5e6, -3e6, 4e6])
    np.testing.assert_allclose(rays @ limb.nadir_itrf, np.sqrt(1 - sine**2), rtol=0, atol=1e-12)
