"""Rendered images of the horizon, with their truth known.

Every pixel's ray is put past the WGS84 ellipsoid in true perspective; its tangent height and
azimuth look up the radiance that `atmosphere` integrated; rays that reach the ground add
ocean, land and clouds lit by the Sun, or the night.  Nothing is shared with the estimator
but the camera model and the ellipsoid's size.
"""

from typing import Annotated

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator.atmosphere import (
    Atmosphere,
    LimbRadiance,
    limb_radiance,
    sunlight_at_ground,
    tangent_grid_m,
)
from estimator.camera import HorizonCamera
from estimator.sensor import Image, Sensor
from planner.arrays import Array
from planner.frames.geodesy import WGS84_A_M, WGS84_F
from planner.spec import Within, spec

_TILE_PX, _TILE_M = 1024, 6.0e6
_OCEAN = np.array([0.075, 0.055, 0.04])
_LAND = np.array([0.08, 0.13, 0.17])
_CLOUD = np.array([0.72, 0.72, 0.72])
_SUN_RADIUS_RAD = np.deg2rad(0.266)
_MOONLIT = 0.7  # sine of the Moon's elevation, where it shines


@spec
class Scene:
    """What there is to be seen besides the air.

    roughness_m: rms of the limb's height along the horizon, correlated over roughness_deg of
    azimuth.  moonlight: against sunlight.  glare: the veil 1 deg from the Sun, against white.
    stars: their number in the frame.  constant_limb_m: instead of the physical atmosphere, a
    textbook limb whose slant depth is 1 at this height, everywhere the same.
    """

    atmosphere: Atmosphere = Atmosphere()
    cloud_cover: Annotated[float, Within(0.0, 1.2)] = 0.4
    land: Annotated[float, Within(0.0, 1.0)] = 0.3
    roughness_m: Annotated[float, Within(0.0, 20e3)] = 0.0
    roughness_deg: Annotated[float, Within(0.1, 90.0)] = 2.0
    moonlight: Annotated[float, Within(0.0, 1.0)] = 0.0
    glare: Annotated[float, Within(0.0, 100.0)] = 0.0
    stars: Annotated[int, Within(0, 100_000)] = 0
    constant_limb_m: Annotated[float, Within(0.0, 100e3)] | None = None


class DrawnHorizon:
    """A craft above the Earth: r_itrf_m (3,), c_body_from_itrf (3, 3), sun_itrf a unit vector."""

    def __init__(
        self,
        r_itrf_m: Array,
        c_body_from_itrf: Array,
        sun_itrf: Array,
        scene: Scene,
        seed: int,
    ) -> None:
        self.r_itrf_m = r_itrf_m
        self.c_body_from_itrf = c_body_from_itrf
        self.sun_itrf = sun_itrf
        self.scene = scene
        self.range_m = float(np.linalg.norm(r_itrf_m))
        up = r_itrf_m / self.range_m
        east = np.cross([0.0, 0.0, 1.0], up) + np.array([1e-12, 0.0, 0.0])
        east /= np.linalg.norm(east)
        self.enu = np.stack([east, np.cross(up, east), up])
        self._seed = seed
        rng = np.random.default_rng([seed, 1])
        self._clouds = _texture(rng, slope=1.7)
        self._ground = _texture(rng, slope=2.2)
        self._rough_m = _roughness(rng, scene.roughness_m, scene.roughness_deg)

    def picture(self, camera: HorizonCamera, sensor: Sensor) -> Image:
        """The camera's image; the same seed and camera name give the same picture."""
        rng = np.random.default_rng([self._seed, 2, *camera.name.encode()])
        return sensor.expose(self.radiance(camera, rng), rng)

    def radiance(self, camera: HorizonCamera, rng: np.random.Generator) -> Array:
        """Radiance in blue, green, red, shape (height, width, 3); 1 for white in full sun."""
        shape = (camera.height_px, camera.width_px)
        rays = _pixel_rays_itrf(camera, self.c_body_from_itrf)
        tangent_m, ahead, unit = self._tangents(rays)
        azimuth = np.arctan2(rays @ self.enu[1], rays @ self.enu[0])
        rough = np.interp(azimuth, np.linspace(-np.pi, np.pi, len(self._rough_m)), self._rough_m)
        tangent_m = np.where(ahead, tangent_m - rough, 1e9)

        tables = self._air(azimuth, tangent_m)
        low_m = WGS84_A_M - 30e3
        reach_m = np.sqrt(max(self.range_m**2 - low_m**2, 1.0))
        half_px_m = 0.289 * camera.rad_per_px * reach_m
        light = np.zeros((len(rays), 3))
        through = np.zeros((len(rays), 3))
        for shift_m in (-half_px_m, half_px_m):
            air, clear = _look_up(tables, azimuth, tangent_m + shift_m)
            light += 0.5 * air
            through += 0.5 * clear
        ground = tangent_m < 0.0
        light[ground] += through[ground] * self._ground_light(rays[ground], unit[ground])
        scene = light.reshape(*shape, 3)
        clear = through.reshape(*shape, 3) * (tangent_m >= 0.0).reshape(*shape, 1)
        _add_stars(scene, clear, self.scene.stars, rng)
        if self.scene.glare > 0.0:
            self._add_glare(scene, camera, rays)
        return scene

    def _tangents(self, rays: Array) -> tuple[Array, NDArray[np.bool_], Array]:
        """Least height of each ray above the ellipsoid, whether it is ahead, and where."""
        stretch = np.array([1.0, 1.0, 1.0 / (1.0 - WGS84_F)])
        r, d = self.r_itrf_m * stretch, rays * stretch
        along = -(d @ r) / np.sum(d * d, axis=1)
        point = r + along[:, None] * d
        radius = np.linalg.norm(point, axis=1)
        unit = point / radius[:, None]
        # Height on the stretched sphere, laid along the ellipsoid's normal.
        true = np.linalg.norm(unit * stretch, axis=1)
        return (radius - WGS84_A_M) / true, along > 0.0, unit

    def _air(self, azimuth: Array, tangent_m: Array) -> LimbRadiance:
        near = tangent_m < 200e3
        if not np.any(near):
            near = np.ones(len(azimuth), dtype=bool)
        # The frame's own span of azimuth, unless it holds the zenith or the nadir.
        middle = np.angle(np.mean(np.exp(1j * azimuth[near])))
        offset = np.angle(np.exp(1j * (azimuth[near] - middle)))
        low, high = float(offset.min()) - 0.01, float(offset.max()) + 0.01
        grid = middle + np.linspace(low, high, 24 if high - low < 2.5 else 72)
        if self.scene.constant_limb_m is not None:
            return _textbook(grid, self.scene.constant_limb_m)
        east, north, up = self.enu @ self.sun_itrf
        air = self.scene.atmosphere
        tables = limb_radiance(air, self.range_m, grid, float(up), float(np.arctan2(north, east)))
        if self.scene.moonlight > 0.0:
            moon = limb_radiance(air, self.range_m, grid, _MOONLIT, 0.0)
            tables.radiance[...] += self.scene.moonlight * moon.radiance
        return tables

    def _ground_light(self, rays: Array, unit: Array) -> Array:
        """Light leaving the ground or cloud that rays (n, 3) hit, shape (n, 3)."""
        stretch = np.array([1.0, 1.0, 1.0 / (1.0 - WGS84_F)])
        r, d = self.r_itrf_m * stretch, rays * stretch
        length2 = np.sum(d * d, axis=1)
        along = -(d @ r) / length2
        miss2 = np.sum((r + along[:, None] * d) ** 2, axis=1)
        along -= np.sqrt(np.maximum(WGS84_A_M**2 - miss2, 0.0) / length2)
        normal = (r + along[:, None] * d) / WGS84_A_M
        east_m, north_m = WGS84_A_M * (self.enu[:2] @ normal.T)
        cosine = np.linspace(-1.0, 1.0, 401)
        table = sunlight_at_ground(self.scene.atmosphere, cosine)
        sun = normal @ self.sun_itrf
        light = np.stack([np.interp(sun, cosine, table[:, c]) for c in range(3)], axis=1)
        light += self.scene.moonlight * _MOONLIT
        land = _sample(self._ground, east_m, north_m, 0.6) < self.scene.land
        cloud = _sample(self._clouds, east_m, north_m, 1.0)
        cover = np.clip((self.scene.cloud_cover - cloud) / 0.12, 0.0, 1.0)[:, None]
        texture = 0.6 + 0.8 * _sample(self._clouds, north_m, east_m, 5.0)[:, None]
        albedo = np.where(land[:, None], _LAND * texture, _OCEAN)
        return np.asarray(light * (albedo * (1.0 - cover) + _CLOUD * texture * cover))

    def _add_glare(self, scene: Array, camera: HorizonCamera, rays: Array) -> None:
        tangent_m, ahead, _ = self._tangents(self.sun_itrf[None])
        if ahead[0] and tangent_m[0] < 0.0:
            return
        off = np.arccos(np.clip(rays @ self.sun_itrf, -1.0, 1.0)).reshape(scene.shape[:2])
        degree = np.deg2rad(1.0)
        # Scatter in the lens falls with the square of the angle (Harvey 1976, exponent -2).
        scene += (self.scene.glare * (degree / (off + 0.3 * degree)) ** 2)[..., None]
        scene[off < _SUN_RADIUS_RAD] += 1e3
        sun_px = camera.pixels((self.c_body_from_itrf @ self.sun_itrf)[None])[0]
        if not np.all(np.isfinite(sun_px)):
            return
        centre = np.array([camera.cx_px, camera.cy_px])
        for along, radius, strength in ((0.4, 0.03, 0.03), (-0.5, 0.06, 0.02), (-1.1, 0.1, 0.01)):
            x, y = centre + along * (sun_px - centre)
            ghost = np.zeros(scene.shape[:2], dtype=np.float32)
            size = round(radius * camera.width_px)
            if max(abs(x), abs(y)) < 1e4:
                cv2.circle(ghost, (round(x), round(y)), size, 1.0, -1, cv2.LINE_AA)
            scene += (self.scene.glare * 10.0 * strength * ghost)[..., None]


def _pixel_rays_itrf(camera: HorizonCamera, c_body_from_itrf: Array) -> Array:
    x, y = np.meshgrid(
        np.arange(camera.width_px, dtype=float), np.arange(camera.height_px, dtype=float)
    )
    return camera.rays_body(np.column_stack([x.ravel(), y.ravel()])) @ c_body_from_itrf


def _look_up(tables: LimbRadiance, azimuth: Array, tangent_m: Array) -> tuple[Array, Array]:
    """Radiance and transmittance (n, 3) by bilinear interpolation in the tables."""
    grid = tables.tangent_m
    middle = 0.5 * (tables.azimuth_rad[0] + tables.azimuth_rad[-1])
    step = tables.azimuth_rad[1] - tables.azimuth_rad[0]
    turn = np.angle(np.exp(1j * (azimuth - middle)))
    row = turn / step + 0.5 * (len(tables.azimuth_rad) - 1)
    row = np.clip(row, 0.0, len(tables.azimuth_rad) - 1.001)
    column = np.clip(np.interp(tangent_m, grid, np.arange(len(grid))), 0.0, len(grid) - 1.001)
    i, j = row.astype(int), column.astype(int)
    u, v = (row - i)[:, None], (column - j)[:, None]
    sky = (tangent_m > grid[-1])[:, None]
    found = []
    for table, beyond in ((tables.radiance, 0.0), (tables.transmittance, 1.0)):
        flat = table.reshape(-1, 3)
        at = i * len(grid) + j
        value = (1 - u) * ((1 - v) * flat[at] + v * flat[at + 1])
        value += u * ((1 - v) * flat[at + len(grid)] + v * flat[at + len(grid) + 1])
        found.append(np.where(sky, beyond, value))
    return found[0], found[1]


def _textbook(azimuth: Array, height_m: float) -> LimbRadiance:
    tangent = tangent_grid_m()
    depth = np.exp(-np.clip((tangent - height_m) / 7.6e3, -4.0, 40.0))
    shape = (len(azimuth), len(tangent), 3)
    radiance = 0.45 * (1.0 - np.exp(-depth))[None, :, None] * [1.1, 1.0, 0.9]
    return LimbRadiance(
        azimuth_rad=azimuth,
        tangent_m=tangent,
        radiance=np.broadcast_to(radiance, shape),
        transmittance=np.broadcast_to(np.exp(-depth)[None, :, None], shape),
    )


def _texture(rng: np.random.Generator, slope: float) -> NDArray[np.float32]:
    """A tile of fractal noise whose values are spread evenly over 0..1, and which wraps."""
    frequency = np.fft.fftfreq(_TILE_PX)
    radius = np.hypot(frequency[:, None], frequency[None, : _TILE_PX // 2 + 1])
    radius[0, 0] = 1.0
    spectrum = np.fft.rfft2(rng.standard_normal((_TILE_PX, _TILE_PX))) / radius**slope
    spectrum[radius < 4.0 / _TILE_PX] = 0.0
    noise = np.fft.irfft2(spectrum, s=(_TILE_PX, _TILE_PX))
    ranks = np.empty(noise.size, dtype=np.float32)
    ranks[np.argsort(noise, axis=None)] = np.linspace(0.0, 1.0, noise.size, dtype=np.float32)
    return ranks.reshape(noise.shape)


def _sample(tile: NDArray[np.float32], x_m: Array, y_m: Array, zoom: float) -> Array:
    scale = zoom * _TILE_PX / _TILE_M
    i, j = np.mod(x_m * scale, _TILE_PX - 1.0), np.mod(y_m * scale, _TILE_PX - 1.0)
    i0, j0 = i.astype(int), j.astype(int)
    u, v = i - i0, j - j0
    return np.asarray(
        (1 - u) * ((1 - v) * tile[i0, j0] + v * tile[i0, j0 + 1])
        + u * ((1 - v) * tile[i0 + 1, j0] + v * tile[i0 + 1, j0 + 1]),
        dtype=float,
    )


def _roughness(rng: np.random.Generator, rms_m: float, correlation_deg: float) -> Array:
    """Heights around the horizon, from -pi to pi, with a Gaussian correlation."""
    count = 1440
    lag = np.arange(count) * 360.0 / count
    order = np.fft.rfftfreq(count, 1.0 / count)
    power = np.exp(-0.25 * (order * np.deg2rad(correlation_deg)) ** 2)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(len(lag))) * power, n=count)
    noise *= rms_m / max(float(np.std(noise)), 1e-12)
    return np.append(noise, noise[0])


def _add_stars(scene: Array, clear: Array, count: int, rng: np.random.Generator) -> None:
    if count == 0:
        return
    height, width = scene.shape[:2]
    x = rng.integers(1, width - 1, count)
    y = rng.integers(1, height - 1, count)
    # Star counts rise fourfold a magnitude: Euclidean counts, flux^-1.5.
    flux = 0.02 * rng.random(count) ** (-1.0 / 1.5)
    scene[y, x] += np.minimum(flux, 1.0)[:, None] * clear[y, x]
