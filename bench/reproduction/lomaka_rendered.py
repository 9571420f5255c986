"""The paper's method and the product's estimator on the same rendered frames.

The limb is the paper's: sharp and everywhere at one height, here 17.5 km above WGS84, from
500 km.  Two 4:3 cameras 60 deg wide, 22 deg below the level so that the horizon is in the middle.
"""

from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from horizon_cases import ring
from scipy.spatial.transform import Rotation

from estimator.pipeline import estimate_vertical
from estimator.rendering.atmosphere import Atmosphere
from estimator.rendering.scene import HorizonRenderer, Scene
from estimator.rendering.sensor import Sensor
from estimator.request import Body, HorizonRequest, Position, PredictedAttitude
from estimator.surroundings import Surroundings
from planner.base.arrays import Array
from reproduction.lomaka_method import paper_nadir

EPOCH = datetime(2026, 3, 20, 12, tzinfo=UTC)
POSITION = Position(frame="ITRF", position_km=(6878.0, 0.0, 0.0))
LEVEL = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
SHARP = Scene(constant_limb_m=17.5e3, cloud_cover=0.0, land=0.0)
REAL = Scene(atmosphere=Atmosphere(), roughness_m=800.0)
MAP_DEG = (-12.0, -6.0, 0.0, 6.0, 12.0)
SWEEP_DEG = (-14.0, -12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0, 14.0)


class Errors(NamedTuple):
    """Of the nadir by three methods, deg; NaN where a method gives none."""

    as_printed: float
    unit_rays: float
    estimator: float


@lru_cache(maxsize=256)
def errors_deg(pitch_deg: float, yaw_deg: float) -> Errors:
    """At one attitude of the craft."""
    request, images, truth = frames(pitch_deg, yaw_deg, SHARP, Sensor())
    found = [paper_nadir(images, request.cameras, unit_rays) for unit_rays in (False, True)]
    answer = estimate_vertical(images, request)
    found.append(answer.geocentric.nadir_body if answer.geocentric else None)
    return Errors(*(_off_deg(nadir, truth) for nadir in found))


def sweep(pitches_deg: tuple[float, ...]) -> Array:
    """Errors over pitch, yaw zero: (n, 3)."""
    return np.array([errors_deg(pitch, 0.0) for pitch in pitches_deg])


def error_map() -> Array:
    """Errors over MAP_DEG of yaw and pitch: (5, 5, 3)."""
    return np.array([[errors_deg(pitch, yaw) for pitch in MAP_DEG] for yaw in MAP_DEG])


class RealAir(NamedTuple):
    """On frames with real air: mean height of the limb found, km, and rms errors, deg."""

    limb_km: float
    unit_rays: float
    estimator: float


@lru_cache(maxsize=1)
def real_air() -> RealAir:
    """What the estimator and the paper's method make of four frames with real air."""
    heights_km, errors = [], []
    for pitch, yaw in ((3.0, -2.0), (-7.0, 5.0), (8.0, 8.0), (-4.0, -9.0)):
        request, images, truth = frames(pitch, yaw, REAL, Sensor(colour=True))
        answer = estimate_vertical(images, request)
        if answer.geocentric is None or answer.limb_height_m is None:
            raise RuntimeError(f"no vertical in a plain daylight frame: {answer.reason}")
        heights_km.append(answer.limb_height_m / 1e3)
        found = (paper_nadir(images, request.cameras, True), answer.geocentric.nadir_body)
        errors.append([_off_deg(nadir, truth) for nadir in found])
    unit_rays, estimator = np.sqrt(np.mean(np.square(errors), axis=0))
    return RealAir(float(np.mean(heights_km)), float(unit_rays), float(estimator))


def frames(
    pitch_deg: float, yaw_deg: float, scene: Scene, sensor: Sensor
) -> tuple[HorizonRequest, list, Array]:
    """A request, its two images and the true geocentric nadir in body axes."""
    around = Surroundings(EPOCH, POSITION, Body())
    tilt = Rotation.from_euler("xy", [yaw_deg, pitch_deg], degrees=True).as_matrix()
    c_body_from_itrf = tilt @ LEVEL
    cameras = ring(2)
    horizon = HorizonRenderer(around.limb.r_itrf_m, c_body_from_itrf, around.sun_itrf, scene, 3)
    images = [horizon.picture(one, sensor) for one in cameras]
    q = Rotation.from_matrix(c_body_from_itrf @ around.c_itrf_from_eci).as_quat()
    request = HorizonRequest(epoch=EPOCH, position=POSITION, cameras=cameras)
    told = PredictedAttitude(q_body_from_eci_xyzw=tuple(q.tolist()), sigma_deg=1.0)
    truth = np.asarray(c_body_from_itrf @ around.limb.nadir_itrf)
    return replace(request, predicted=told), images, truth


def _off_deg(nadir: Array | None, truth: Array) -> float:
    if nadir is None:
        return float("nan")
    across = np.linalg.norm(np.cross(nadir, truth))
    return float(np.rad2deg(np.arctan2(across, nadir @ truth)))
