"""Images of the horizon benchmark, and their truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from estimator.camera import HorizonCamera
from estimator.images import Pixels
from estimator.limb.geometry import Limb
from estimator.rendering.atmosphere import Atmosphere
from estimator.rendering.scene import HorizonRenderer, Scene
from estimator.rendering.sensor import Sensor
from estimator.request import Body, HorizonRequest, Position, PredictedAttitude
from estimator.surroundings import Surroundings
from planner.world.frames.geodesy import itrf_from_geodetic

Floats = NDArray[np.float64]
COLOUR = Sensor(colour=True)


@dataclass(frozen=True)
class Case:
    """A request with its images, and the true nadirs in body axes."""

    images: tuple[Pixels, ...]
    request: HorizonRequest
    geocentric_body: Floats
    geodetic_body: Floats


def angle_deg(a: Floats, b: Floats) -> float:
    """Between two directions."""
    return float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))


def camera(
    name: str,
    azimuth_deg: float,
    width: int = 640,
    height: int = 480,
    down_deg: float = 22.0,
    width_deg: float = 60.0,
) -> HorizonCamera:
    """A camera on a body whose +Z is nadir, looking down at the horizon."""
    azimuth, down = np.deg2rad([azimuth_deg, down_deg])
    z = np.array([np.cos(azimuth) * np.cos(down), np.sin(azimuth) * np.cos(down), np.sin(down)])
    # Image rows run down, towards nadir.
    y = np.array([0.0, 0.0, 1.0]) - z[2] * z
    y /= np.linalg.norm(y)
    c_camera_from_body = np.stack([np.cross(y, z), y, z])
    focal_px = 0.5 * width / np.tan(np.deg2rad(0.5 * width_deg))
    return HorizonCamera(
        name=name,
        width_px=width,
        height_px=height,
        fx_px=focal_px,
        fy_px=focal_px,
        cx_px=0.5 * (width - 1),
        cy_px=0.5 * (height - 1),
        q_camera_from_body_xyzw=tuple(Rotation.from_matrix(c_camera_from_body).as_quat().tolist()),
        lens_sigma=0.0,
        readout_s=0.0,
    )


class RollingShutter:
    """A camera on a turning body whose rows are exposed one after another, for a renderer."""

    def __init__(self, stated: HorizonCamera, rate_body_deg_s: Floats) -> None:
        self._stated, self._rate_rad_s = stated, np.deg2rad(rate_body_deg_s)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stated, name)

    def rays_body(self, xy_px: Floats) -> Floats:
        """On the body's axes in the middle of the exposure."""
        exposed_s = self._stated.readout_s * ((xy_px[:, 1] + 0.5) / self._stated.height_px - 0.5)
        turn = Rotation.from_rotvec(exposed_s[:, None] * self._rate_rad_s)
        return np.asarray(turn.apply(self._stated.rays_body(xy_px)))


def ring(count: int, width: int = 640, height: int = 480) -> tuple[HorizonCamera, ...]:
    """Cameras 90 deg apart."""
    return tuple(camera(f"c{k}", 90.0 * k, width, height) for k in range(count))


def random_air(rng: np.random.Generator) -> Scene:
    """Clouds, land, dust, ozone and scale height as they vary; 0.8 km of limb roughness."""
    return Scene(
        atmosphere=Atmosphere(
            air_scale_m=rng.uniform(6.8e3, 8.4e3),
            dust_optical_depth=rng.uniform(0.03, 0.3),
            dust_scale_m=rng.uniform(1.0e3, 2.5e3),
            haze_optical_depth=float(np.exp(rng.uniform(np.log(6e-4), np.log(5e-3)))),
            ozone=rng.uniform(0.7, 1.3),
        ),
        cloud_cover=rng.uniform(0.1, 0.8),
        land=rng.uniform(0.0, 0.8),
        roughness_m=800.0,
    )


def other_air(rng: np.random.Generator) -> Scene:
    """Thinner, denser and cleaner air than the estimator was made with, without ozone."""
    return replace(
        random_air(rng),
        atmosphere=Atmosphere(
            air_scale_m=rng.uniform(7.0e3, 8.0e3),
            air_density=rng.uniform(0.6, 1.5),
            dust_optical_depth=rng.uniform(0.0, 0.1),
            haze_optical_depth=0.0,
            ozone=0.0,
            diffuse_share=rng.uniform(0.0, 0.35),
        ),
    )


def case(
    rng: np.random.Generator,
    cameras: tuple[HorizonCamera, ...],
    *,
    scene: Scene | None = None,
    sensor: Sensor = COLOUR,
    sun_deg: tuple[float, float] = (35.0, 90.0),
    sun_from_boresight_deg: tuple[float, float] = (0.0, 180.0),
    attitude_deg: float = 8.0,
    predicted_off_deg: float | None = 0.0,
    true_cameras: Sequence[HorizonCamera | RollingShutter] | None = None,
) -> Case:
    """One frame per camera from a random place, time and attitude.

    sun_deg: elevation of the Sun at the craft; sun_from_boresight_deg: from the first camera's
    axis.  predicted_off_deg: the prediction's largest error, None for no prediction.
    true_cameras: those that take the picture, when they differ from those the estimator knows.
    """
    while True:
        epoch, place_rad = _draw_place(rng)
        position, around = _surroundings(epoch, place_rad, rng.uniform(350e3, 700e3))
        limb, level = around.limb, _draw_level(rng, around.limb)
        tilt = Rotation.from_euler("xyz", rng.uniform(-attitude_deg, attitude_deg, 3), degrees=True)
        c_body_from_itrf = tilt.as_matrix() @ level
        sun_body = c_body_from_itrf @ around.sun_itrf
        off = np.rad2deg(np.arccos(sun_body @ cameras[0].boresight_body))
        low, high = sun_from_boresight_deg
        if sun_deg[0] <= _sun_deg(around) <= sun_deg[1] and low <= off <= high:
            break
    horizon = HorizonRenderer(
        limb.r_itrf_m,
        c_body_from_itrf,
        around.sun_itrf,
        scene or random_air(rng),
        int(rng.integers(1 << 30)),
    )
    images = tuple(horizon.picture(c, sensor) for c in true_cameras or cameras)
    predicted = None
    if predicted_off_deg is not None:
        axis = rng.normal(size=3)
        axis *= np.deg2rad(predicted_off_deg) * rng.uniform() / np.linalg.norm(axis)
        c = Rotation.from_rotvec(axis).as_matrix() @ c_body_from_itrf @ around.c_itrf_from_eci
        predicted = PredictedAttitude(
            q_body_from_eci_xyzw=tuple(Rotation.from_matrix(c).as_quat().tolist()),
            # Rms of one component of an error spread evenly over 0..largest.
            sigma_deg=max(predicted_off_deg / 3.0, 0.05),
        )
    return Case(
        images=images,
        request=HorizonRequest(
            epoch=epoch, position=position, cameras=cameras, predicted=predicted
        ),
        geocentric_body=c_body_from_itrf @ limb.nadir_itrf,
        geodetic_body=c_body_from_itrf @ limb.nadir_geodetic_itrf,
    )


def _draw_place(rng: np.random.Generator) -> tuple[datetime, tuple[float, float]]:
    """An epoch of 2026, latitude and longitude."""
    epoch = datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=rng.uniform(0.0, 3.15e7))
    return epoch, (np.arcsin(rng.uniform(-0.85, 0.85)), rng.uniform(-np.pi, np.pi))


def _surroundings(
    epoch: datetime, place_rad: tuple[float, float], height_m: float
) -> tuple[Position, Surroundings]:
    r_itrf_m = itrf_from_geodetic(*place_rad, height_m)
    position = Position(frame="ITRF", position_km=tuple((r_itrf_m / 1e3).tolist()))
    return position, Surroundings(epoch, position, Body())


def _draw_level(rng: np.random.Generator, limb: Limb) -> Floats:
    """Axes of a level body from ITRF at a random heading, (3, 3)."""
    heading = rng.uniform(0.0, 2.0 * np.pi)
    x = np.cos(heading) * limb.axes_itrf[0] + np.sin(heading) * limb.axes_itrf[1]
    return np.stack([x, np.cross(limb.nadir_itrf, x), limb.nadir_itrf])


def _sun_deg(around: Surroundings) -> float:
    """Elevation of the Sun at the craft."""
    return float(np.rad2deg(np.arcsin(-around.sun_itrf @ around.limb.nadir_itrf)))


NEGATIVES = (
    "black", "white", "noise", "stars", "moon", "ground", "cloud deck", "airglow", "straight edge",
    "text", "blobs", "terminator", "straight, soft", "straight, fading as air",
    "straight, fading as sRGB", "straight, a ramp", "red limb", "limb without air", "aurora",
)  # fmt: skip


def negative(kind: str, rng: np.random.Generator) -> tuple[Pixels, HorizonRequest]:
    """An image without a usable horizon, at an epoch and place where it would be day."""
    if kind in ("ground", "cloud deck"):
        return _looking_down(rng, kind == "cloud deck"), case_frame(rng)
    if kind in ("airglow", "terminator", "aurora"):
        return _night(rng, kind)
    if kind in ("red limb", "limb without air"):
        return _other_planet(rng, airless=kind == "limb without air")
    image = _DRAWN[kind](rng) + rng.normal(0.0, 1.0, _SHAPE)
    return np.asarray(np.clip(np.rint(image), 0, 255), dtype=np.uint8), case_frame(rng)


_SHAPE = (480, 640)
_Y, _X = np.mgrid[0:480, 0:640].astype(float)


def _dark(rng: np.random.Generator) -> Floats:
    return rng.normal(2.0, 1.0, _SHAPE)


def _stars(rng: np.random.Generator) -> Floats:
    image = _dark(rng)
    for _ in range(400):
        image[rng.integers(0, 480), rng.integers(0, 640)] += rng.uniform(20.0, 3000.0)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 0.9))


def _moon(rng: np.random.Generator) -> Floats:
    radius, (cx, cy) = rng.uniform(10.0, 150.0), rng.uniform([150, 120], [490, 360])
    phase = rng.uniform(-1.0, 1.0)
    disc = np.hypot(_X - cx, _Y - cy) < radius
    lit = (_X - cx) > phase * np.sqrt(np.maximum(radius**2 - (_Y - cy) ** 2, 0.0))
    return np.asarray(_dark(rng) + cv2.GaussianBlur(200.0 * (disc & lit), (0, 0), 0.8))


def _edge(rng: np.random.Generator) -> Floats:
    angle, offset = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-100.0, 100.0)
    side = (_X - 320.0) * np.cos(angle) + (_Y - 240.0) * np.sin(angle) > offset
    return np.asarray(_dark(rng) + cv2.GaussianBlur(rng.uniform(60, 220) * side, (0, 0), 1.5))


def _soft(rng: np.random.Generator, profile: Callable[[Floats], Floats]) -> Floats:
    """A straight edge as wide as a limb or wider; profile: of widths inwards, from 0 to 1."""
    angle, offset = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-150.0, 150.0)
    inwards_px = (_X - 320.0) * np.cos(angle) + (_Y - 240.0) * np.sin(angle) - offset
    width_px = np.exp(rng.uniform(np.log(4.0), np.log(25.0)))
    return np.asarray(3.0 + rng.uniform(80.0, 350.0) * profile(inwards_px / width_px))


def _text(rng: np.random.Generator) -> Floats:
    page = np.zeros(_SHAPE, dtype=np.uint8)
    for _ in range(12):
        place = (int(rng.integers(-50, 450)), int(rng.integers(20, 470)))
        cv2.putText(page, "NO HORIZON 0123", place, 2, rng.uniform(0.5, 3.0), 230, 2)
    return _dark(rng) + page


def _blobs(rng: np.random.Generator) -> Floats:
    image = _dark(rng)
    for _ in range(int(rng.integers(2, 9))):
        axes = (int(rng.integers(20, 300)), int(rng.integers(20, 300)))
        place = (int(rng.integers(0, 640)), int(rng.integers(0, 480)))
        level = rng.uniform(40.0, 240.0)
        cv2.ellipse(image, place, axes, rng.uniform(0.0, 180.0), 0, 360, level, -1)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0))


_DRAWN: dict[str, Callable[[np.random.Generator], Floats]] = {
    "black": lambda rng: 0.4 * _dark(rng),
    "white": lambda rng: 255.0 - 3.0 * rng.random(_SHAPE),
    "noise": lambda rng: rng.normal(120.0, 50.0, _SHAPE),
    "stars": _stars,
    "moon": _moon,
    "straight edge": _edge,
    "straight, soft": lambda rng: _soft(rng, lambda w: 0.5 * (1.0 + np.tanh(w))),
    "straight, fading as air": lambda rng: _soft(
        rng, lambda w: 1.0 - np.exp(-np.exp(np.clip(w, -50.0, 50.0)))
    ),
    "straight, fading as sRGB": lambda rng: _soft(rng, lambda w: np.exp(np.minimum(w, 0.0))),
    "straight, a ramp": lambda rng: _soft(rng, lambda w: np.clip(w / 3.0, 0.0, 1.0)),
    "text": _text,
    "blobs": _blobs,
}


def case_frame(rng: np.random.Generator) -> HorizonRequest:
    """A request in daylight, without a prediction, for one camera."""
    return _request(rng, (30.0, 80.0), 22.0)[0]


def _request(
    rng: np.random.Generator, sun_deg: tuple[float, float], down_deg: float
) -> tuple[HorizonRequest, Surroundings]:
    while True:
        epoch, place_rad = _draw_place(rng)
        position, around = _surroundings(epoch, place_rad, 420e3)
        if sun_deg[0] < _sun_deg(around) < sun_deg[1]:
            cameras = (camera("c0", 0.0, down_deg=down_deg),)
            return HorizonRequest(epoch=epoch, position=position, cameras=cameras), around


def _seen(
    rng: np.random.Generator, around: Surroundings, seen_by: HorizonCamera, scene: Scene
) -> Pixels:
    level = _draw_level(rng, around.limb)
    seed = int(rng.integers(1 << 30))
    return HorizonRenderer(around.limb.r_itrf_m, level, around.sun_itrf, scene, seed).picture(
        seen_by, COLOUR
    )


def _looking_down(rng: np.random.Generator, clouds: bool) -> Pixels:
    request, around = _request(rng, (30.0, 80.0), 75.0)
    scene = Scene(cloud_cover=0.95 if clouds else rng.uniform(0.1, 0.6), land=rng.uniform(0, 0.8))
    return _seen(rng, around, request.cameras[0], scene)


def _night(rng: np.random.Generator, kind: str) -> tuple[Pixels, HorizonRequest]:
    """Airglow over a moonlit Earth; or only the terminator, the limb being out of frame.

    The request claims daylight: the image alone has to give the night away.
    """
    sun_deg = (-5.0, 10.0) if kind == "terminator" else (-60.0, -30.0)
    down_deg = 60.0 if kind == "terminator" else 22.0
    request, around = _request(rng, sun_deg, down_deg)
    height_m = (100e3, 110e3) if kind == "aurora" else (86e3, 96e3)
    glow = Atmosphere(airglow=rng.uniform(0.002, 0.02), airglow_height_m=rng.uniform(*height_m))
    scene = Scene(atmosphere=glow, moonlight=rng.choice([0.0, 3e-3]), stars=100)
    image = _seen(rng, around, request.cameras[0], scene)
    return image, case_frame(rng)


def _other_planet(rng: np.random.Generator, *, airless: bool) -> tuple[Pixels, HorizonRequest]:
    """A limb as large as the Earth's, of dust reddish throughout or without any air.

    Brightness alone tells neither from the Earth's air: dust fades as air does.
    """
    request, around = _request(rng, (30.0, 80.0), 22.0)
    limb = Scene(constant_limb_m=rng.uniform(12e3, 25e3), cloud_cover=0.0)
    if airless:
        limb = Scene(atmosphere=Atmosphere(air_density=1e-3, dust_optical_depth=0.0), land=1.0)
    grey = _seen(rng, around, request.cameras[0], limb).mean(axis=2, keepdims=True)
    tint = np.ones(3) if airless else np.array([rng.uniform(0.3, 0.6), rng.uniform(0.5, 0.8), 1.0])
    noise = rng.normal(0.0, 1.5, (*_SHAPE, 3))
    image = np.clip(np.rint(grey * tint + noise), 0, 255).astype(np.uint8)
    return image, request
