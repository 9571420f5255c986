"""Frames of horizon cameras whose limbs another model of the air gave, with their truth.

Radiance comes from tables made with SASKTRAN2 (tests/data/horizon/README.md), by the height of each
ray's lowest point above the WGS84 ellipsoid and the Sun's place there.  With the estimator and
its own renderer this shares the camera model alone: ellipsoid, Sun, ground, lens and electronics
are this file's.
"""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, RegularGridInterpolator
from scipy.special import ndtr

from estimator.camera import HorizonCamera

Floats = NDArray[np.float64]
TABLES = Path(__file__).parents[1] / "tests/data/horizon/air"
A_M, E2 = 6378137.0, 6.69437999014e-3  # WGS84
SPHERE_M = 6371.0e3  # of the tables
_OCEAN, _LAND, _CLOUD = np.array([[0.07, 0.05, 0.03], [0.07, 0.11, 0.16], [0.6, 0.6, 0.6]])
_FINE = 3  # samples a pixel's side, at the limb
_LIMB_M = (-10e3, 80e3)


@dataclass(frozen=True)
class LimbTable:
    """Logarithms of radiance over Sun's zenith angle (deg), azimuth (deg), tangent height (m)."""

    light: RegularGridInterpolator
    per_albedo: RegularGridInterpolator
    highest_m: float
    albedo: float


@cache
def limb_table(air: str, folder: Path = TABLES) -> LimbTable:
    with np.load(folder / f"{air}.npz") as held:
        sun, azimuth, tangent_m = (
            held[name] for name in ("sun_zenith_deg", "azimuth_deg", "tangent_m")
        )
        light, per_albedo = (
            held[name] * float(held["step"]) for name in ("log_radiance", "log_per_albedo")
        )
        below = tangent_m < 0.0
        # Dark below the last Sun, and above the air.
        return LimbTable(
            light=_smooth(sun, azimuth, tangent_m, light),
            per_albedo=_smooth(sun, azimuth, tangent_m[below], per_albedo),
            highest_m=float(tangent_m[-1]),
            albedo=float(held["albedo"]),
        )


def _smooth(
    sun_deg: Floats, azimuth_deg: Floats, tangent_m: Floats, values: Floats
) -> RegularGridInterpolator:
    """Linear between nodes added by a cubic along azimuth, where the given ones are coarse."""
    fine_deg = np.arange(0.0, 180.1, 5.0)
    mirrored = np.concatenate([values[:, 2:0:-1], values, values[:, -2:-4:-1]], axis=1)
    at_deg = np.concatenate([-azimuth_deg[2:0:-1], azimuth_deg, 360.0 - azimuth_deg[-2:-4:-1]])
    values = CubicSpline(at_deg, mirrored, axis=1)(fine_deg)
    return RegularGridInterpolator(
        (sun_deg, fine_deg, tangent_m), values, bounds_error=False, fill_value=None
    )


@dataclass(frozen=True)
class Weather:
    """What varies from frame to frame besides the air.

    limb_m: rms of the limb's height along the horizon, correlated over `limb_deg` of azimuth.
    """

    cloud: float
    land: float
    limb_m: float
    limb_deg: float
    seed: int


@dataclass(frozen=True)
class Electronics:
    """exposure: brightness of the frame's `percentile` against saturation."""

    exposure: float
    full_well_e: float
    read_noise_e: float
    blur_px: float
    bits: int
    percentile: float = 98.0


def sun_itrf(epoch: datetime) -> Floats:
    """Towards the Sun, to 0.02 deg (Astronomical Almanac's low precision formulas)."""
    days = (epoch - datetime(2000, 1, 1, 12, tzinfo=UTC)) / timedelta(days=1)
    anomaly = np.deg2rad(357.529 + 0.98560028 * days)
    longitude = np.deg2rad(
        280.459 + 0.98564736 * days + 1.915 * np.sin(anomaly) + 0.020 * np.sin(2.0 * anomaly)
    )
    obliquity = np.deg2rad(23.439 - 0.00000036 * days)
    x, y = np.cos(longitude), np.cos(obliquity) * np.sin(longitude)
    z = np.sin(obliquity) * np.sin(longitude)
    turned = np.deg2rad(280.46061837 + 360.98564736629 * days)
    return np.array(
        [
            np.cos(turned) * x + np.sin(turned) * y,
            np.cos(turned) * y - np.sin(turned) * x,
            z,
        ]
    )


def geodetic_up(point_m: Floats) -> tuple[Floats, Floats]:
    """Normals (n, 3) of the ellipsoid below points (n, 3), and heights above it (n,)."""
    x, y, z = np.asarray(point_m).T
    flat = np.hypot(x, y)
    latitude = np.arctan2(z, flat * (1.0 - E2))
    for _ in range(3):
        sine = np.sin(latitude)
        across_m = A_M / np.sqrt(1.0 - E2 * sine**2)
        latitude = np.arctan2(z + E2 * across_m * sine, flat)
    sine, cosine = np.sin(latitude), np.cos(latitude)
    across_m = A_M / np.sqrt(1.0 - E2 * sine**2)
    height_m = flat * cosine + z * sine - across_m * (1.0 - E2 * sine**2)
    up = np.column_stack([cosine * x / flat, cosine * y / flat, sine])
    return up, height_m


def lowest_points(r_m: Floats, ray: Floats) -> tuple[Floats, Floats, Floats]:
    """Where rays (n, 3) from r_m come nearest to the ellipsoid: points, normals, heights."""
    along_m = -(ray @ r_m)
    for _ in range(4):
        point_m = r_m + along_m[:, None] * ray
        up, height_m = geodetic_up(point_m)
        # The ray's slope against the horizon there, over the Earth's curvature.
        along_m = along_m - np.sum(up * ray, axis=1) * (A_M + np.maximum(height_m, -A_M / 2))
    point_m = r_m + along_m[:, None] * ray
    up, height_m = geodetic_up(point_m)
    return point_m, up, height_m


@dataclass(frozen=True)
class View:
    """From r_m (ITRF), with c_body_from_itrf (3, 3), under one air."""

    r_m: Floats
    c_body_from_itrf: Floats
    sun: Floats
    air: str
    weather: Weather

    def radiance(self, camera: HorizonCamera) -> Floats:
        """Blue, green, red, (height, width, 3), against white under the overhead Sun."""
        shape = (camera.height_px, camera.width_px)
        x, y = np.meshgrid(np.arange(shape[1], dtype=float), np.arange(shape[0], dtype=float))
        xy_px = np.column_stack([x.ravel(), y.ravel()])
        light, height_m = self._light(camera, xy_px)
        near = (height_m > _LIMB_M[0]) & (height_m < _LIMB_M[1])
        inside = (np.arange(_FINE) + 0.5) / _FINE - 0.5
        light[near] = np.mean(
            [self._light(camera, xy_px[near] + [dx, dy])[0] for dx in inside for dy in inside],
            axis=0,
        )
        return light.reshape(*shape, 3)

    def _light(self, camera: HorizonCamera, xy_px: Floats) -> tuple[Floats, Floats]:
        """At pixels (n, 2): radiance (n, 3) and least height of the ray (n,)."""
        ray = camera.rays_body(xy_px) @ self.c_body_from_itrf
        light = np.zeros((len(ray), 3))
        height_m = np.full(len(ray), 1e9)
        # Rays that pass the Earth by more than 300 km see nothing.
        least_m = np.linalg.norm(np.cross(self.r_m, ray), axis=1)
        seen = np.flatnonzero((ray @ self.r_m < 0.0) & (least_m < A_M + 300e3))
        point_m, up, tangent_m = lowest_points(self.r_m, ray[seen])
        tangent_m = tangent_m - self._limb_lift_m(point_m)
        height_m[seen] = tangent_m
        table = limb_table(self.air)
        air = (tangent_m >= 0.0) & (tangent_m < table.highest_m)
        light[seen[air]] = self._of_table(table, ray[seen[air]], up[air], tangent_m[air])[0]
        ground = seen[tangent_m < 0.0]
        if len(ground):
            light[ground] = self._of_ground(table, ray[ground])
        return light, height_m

    def _of_table(
        self, table: LimbTable, ray: Floats, up: Floats, tangent_m: Floats
    ) -> tuple[Floats, Floats]:
        """Radiance, and the table's arguments."""
        sine = up @ self.sun
        level_sun = self.sun - sine[:, None] * up
        level_ray = ray - np.sum(ray * up, axis=1)[:, None] * up
        cosine = np.sum(level_sun * level_ray, axis=1)
        cosine /= np.linalg.norm(level_sun, axis=1) * np.linalg.norm(level_ray, axis=1) + 1e-12
        zenith_deg = np.rad2deg(np.arccos(np.clip(sine, -1.0, 1.0)))
        azimuth_deg = np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0)))
        at = np.column_stack([np.minimum(zenith_deg, 103.0), azimuth_deg, tangent_m])
        return np.exp(table.light(at)), at

    def _of_ground(self, table: LimbTable, ray: Floats) -> Floats:
        stretch = np.array([1.0, 1.0, 1.0 / np.sqrt(1.0 - E2)])
        r, d = self.r_m * stretch / A_M, ray * stretch / A_M
        a, b, c = np.sum(d * d, axis=1), d @ r, r @ r - 1.0
        along_m = (-b - np.sqrt(np.maximum(b * b - a * c, 0.0))) / a
        point_m = self.r_m + along_m[:, None] * ray
        up = geodetic_up(point_m)[0]
        down = np.clip(-np.sum(up * ray, axis=1), 0.0, 1.0)
        # The sphere's ray that meets the ground as steeply.
        tangent_m = np.minimum(SPHERE_M * (np.sqrt(1.0 - down**2) - 1.0), -0.5e3)
        light, at = self._of_table(table, ray, up, tangent_m)
        albedo = self._albedo(point_m)
        light += (albedo - table.albedo) * np.exp(table.per_albedo(at))
        return np.maximum(light, 1e-6)

    def _albedo(self, point_m: Floats) -> Floats:
        """Of ground and clouds at points (n, 3), in three bands."""
        cloud = _waves(point_m, self.weather.seed, 3000e3)
        land = _waves(point_m, self.weather.seed + 1, 6000e3)
        cover = np.clip((self.weather.cloud - cloud) / 0.1 + 0.5, 0.0, 1.0)[:, None]
        ground = np.where((land < self.weather.land)[:, None], _LAND, _OCEAN)
        return cover * _CLOUD + (1.0 - cover) * ground

    def _limb_lift_m(self, point_m: Floats) -> Floats:
        """How much higher the air stands, a Gaussian field on the sphere's directions."""
        if self.weather.limb_m == 0.0:
            return np.zeros(len(point_m))
        nadir = -self.r_m / np.linalg.norm(self.r_m)
        east = np.cross([0.0, 0.0, 1.0], nadir)
        east /= np.linalg.norm(east)
        azimuth_rad = np.arctan2(point_m @ np.cross(nadir, east), point_m @ east)
        rng = np.random.default_rng([self.weather.seed, 7])
        order = np.arange(1, 120)
        power = np.exp(-0.5 * (order * np.deg2rad(self.weather.limb_deg)) ** 2)
        part = rng.normal(size=(2, len(order))) * np.sqrt(power / power.sum())
        around_rad = np.linspace(-np.pi, np.pi, 1441)
        phase = around_rad[:, None] * order
        lift_m = self.weather.limb_m * (np.cos(phase) @ part[0] + np.sin(phase) @ part[1])
        return np.interp(azimuth_rad, around_rad, lift_m)


def _waves(point_m: Floats, seed: int, longest_m: float) -> Floats:
    """A random field on the ground, its values spread evenly over 0..1."""
    rng = np.random.default_rng([seed, 3])
    value = np.zeros(len(point_m))
    total = 0.0
    for k in range(36):
        shrink = 1.28 ** (k // 2)
        way = rng.normal(size=3)
        way *= 2.0 * np.pi * shrink / (longest_m * np.linalg.norm(way))
        value += shrink**-0.6 * np.cos(point_m @ way + rng.uniform(0.0, 2.0 * np.pi))
        total += 0.5 * shrink**-1.2
    return ndtr(value / np.sqrt(total))


def expose(
    light: Floats, electronics: Electronics, rng: np.random.Generator
) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """The file of a frame (h, w) or (h, w, 3)."""
    seen = cv2.GaussianBlur(light, (0, 0), electronics.blur_px)
    seen = seen * (electronics.exposure / np.percentile(seen, electronics.percentile))
    noise_e = rng.normal(size=seen.shape) * np.sqrt(
        seen * electronics.full_well_e + electronics.read_noise_e**2
    )
    seen = np.clip(seen + noise_e / electronics.full_well_e, 0.0, 1.0)
    if electronics.bits == 16:
        return np.rint(seen * 65535.0).astype(np.uint16)
    return np.rint(seen * 255.0).astype(np.uint8)
