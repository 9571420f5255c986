"""Rendered images of the horizon, with their truth known.

Every pixel's ray is put past the WGS84 ellipsoid in true perspective; its tangent height and
azimuth look up the radiance that `atmosphere` integrated; rays that reach the ground add
ocean, land and clouds lit by the Sun, or the night.  Nothing is shared with the estimator
but the camera model and the ellipsoid's size.
"""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.rendering.atmosphere import (
    Atmosphere,
    LimbRadiance,
    interpolate,
    limb_radiance,
    sunlight_at_ground,
    tangent_grid_m,
)
from estimator.rendering.sensor import Image, Sensor
from planner.base.arrays import Array
from planner.base.spec import Within, spec
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F

_TILE_PX, _TILE_M = 1024, 6.0e6
_OCEAN = np.array([0.075, 0.055, 0.04])
_LAND = np.array([0.08, 0.13, 0.17])
_CLOUD = np.array([0.72, 0.72, 0.72])
_SUN_RADIUS_RAD = np.deg2rad(0.266)
_MOONLIT = 0.7  # sine of the Moon's elevation, where it shines
_STRETCH = np.array([1.0, 1.0, 1.0 / (1.0 - WGS84_F)])  # makes the ellipsoid a sphere


@spec
class Scene:
    """Ground, clouds, light and stars of the picture.

    cloud_cover: share of the Earth under clouds; from 1.12 on they are thick everywhere.
    land: share of the ground that is land.
    roughness_m: rms of the limb's height along the horizon.
    roughness_deg: azimuth over which that height is correlated.
    moonlight: against sunlight.
    glare: the veil 1 deg from the Sun, against white.
    stars: their number in the frame.
    constant_limb_m: instead of the physical atmosphere, a textbook limb whose slant depth is 1 at
    this height, everywhere the same. E.g. `16000.0`.
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


class HorizonRenderer:
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
        self._clouds = _texture(rng, exponent=1.7)
        self._ground = _texture(rng, exponent=2.2)
        self._rough_m = _roughness(rng, scene.roughness_m, scene.roughness_deg)

    def picture(self, camera: HorizonCamera, sensor: Sensor) -> Image:
        """The camera's image; the same seed and camera name give the same picture."""
        rng = np.random.default_rng([self._seed, 2, *camera.name.encode()])
        return sensor.expose(self.radiance(camera, rng), rng)

    def radiance(self, camera: HorizonCamera, rng: np.random.Generator) -> Array:
        """Radiance in blue, green, red, shape (height, width, 3); 1 for white in full sun."""
        shape = (camera.height_px, camera.width_px)
        ray_itrf = _pixel_rays_itrf(camera, self.c_body_from_itrf)
        tangent_m, ahead = self._tangents_m(ray_itrf)
        azimuth_rad = np.arctan2(ray_itrf @ self.enu[1], ray_itrf @ self.enu[0])
        around_rad = np.linspace(-np.pi, np.pi, len(self._rough_m))
        rough_m = np.interp(azimuth_rad, around_rad, self._rough_m)
        tangent_m = np.where(ahead, tangent_m - rough_m, 1e9)

        tables = self._air(azimuth_rad, tangent_m)
        low_m = WGS84_A_M - 30e3
        reach_m = np.sqrt(max(self.range_m**2 - low_m**2, 1.0))
        half_px_m = 0.289 * camera.rad_per_px * reach_m
        radiance = np.zeros((len(ray_itrf), 3))
        transmittance = np.zeros((len(ray_itrf), 3))
        for shift_m in (-half_px_m, half_px_m):
            air, clear = _look_up(tables, azimuth_rad, tangent_m + shift_m)
            radiance += 0.5 * air
            transmittance += 0.5 * clear
        ground = tangent_m < 0.0
        radiance[ground] += transmittance[ground] * self._ground_light(ray_itrf[ground])
        picture = radiance.reshape(*shape, 3)
        sky = transmittance.reshape(*shape, 3) * ~ground.reshape(*shape, 1)
        _add_stars(picture, sky, self.scene.stars, rng)
        if self.scene.glare > 0.0:
            self._add_glare(picture, camera, ray_itrf)
        return picture

    def _lowest_points(self, ray_itrf: Array) -> tuple[Array, Array, Array, Array]:
        """Of rays (n, 3), stretched with the ellipsoid to a sphere: the rays, their squared
        lengths, the lengths to their lowest points, and those points."""
        stretched_m, ray = self.r_itrf_m * _STRETCH, ray_itrf * _STRETCH
        length2 = np.sum(ray * ray, axis=1)
        along = -(ray @ stretched_m) / length2
        return ray, length2, along, stretched_m + along[:, None] * ray

    def _tangents_m(self, ray_itrf: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Least height of each ray above the ellipsoid, and whether it is ahead."""
        _, _, along, point_m = self._lowest_points(ray_itrf)
        radius_m = np.linalg.norm(point_m, axis=1)
        # Height on the stretched sphere, laid along the ellipsoid's normal.
        normal = np.linalg.norm(point_m / radius_m[:, None] * _STRETCH, axis=1)
        return (radius_m - WGS84_A_M) / normal, along > 0.0

    def _air(self, azimuth_rad: Array, tangent_m: Array) -> LimbRadiance:
        near = tangent_m < 200e3
        if not np.any(near):
            near = np.ones(len(azimuth_rad), dtype=bool)
        # The frame's own span of azimuth, unless it holds the zenith or the nadir.
        middle = np.angle(np.mean(np.exp(1j * azimuth_rad[near])))
        offset = np.angle(np.exp(1j * (azimuth_rad[near] - middle)))
        low, high = float(offset.min()) - 0.01, float(offset.max()) + 0.01
        grid = middle + np.linspace(low, high, 24 if high - low < 2.5 else 72)
        if self.scene.constant_limb_m is not None:
            return _textbook(grid, self.scene.constant_limb_m)
        east, north, up = self.enu @ self.sun_itrf
        air = self.scene.atmosphere
        tables = limb_radiance(air, self.range_m, grid, float(up), float(np.arctan2(north, east)))
        if self.scene.moonlight > 0.0:
            moon = limb_radiance(air, self.range_m, grid, _MOONLIT, 0.0)
            tables.radiance_ratio[...] += self.scene.moonlight * moon.radiance_ratio
        return tables

    def _ground_light(self, ray_itrf: Array) -> Array:
        """Light leaving the ground or cloud that rays (n, 3) hit, shape (n, 3)."""
        ray, length2, along, lowest_m = self._lowest_points(ray_itrf)
        miss2 = np.sum(lowest_m**2, axis=1)
        along -= np.sqrt(np.maximum(WGS84_A_M**2 - miss2, 0.0) / length2)
        normal = (self.r_itrf_m * _STRETCH + along[:, None] * ray) / WGS84_A_M
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

    def _add_glare(self, radiance_ratio: Array, camera: HorizonCamera, ray_itrf: Array) -> None:
        tangent_m, ahead = self._tangents_m(self.sun_itrf[None])
        if ahead[0] and tangent_m[0] < 0.0:
            return
        size = radiance_ratio.shape[:2]
        off_rad = np.arccos(np.clip(ray_itrf @ self.sun_itrf, -1.0, 1.0)).reshape(size)
        degree = np.deg2rad(1.0)
        # Scatter in the lens falls with the square of the angle (Harvey 1976, exponent -2).
        radiance_ratio += (self.scene.glare * (degree / (off_rad + 0.3 * degree)) ** 2)[..., None]
        radiance_ratio[off_rad < _SUN_RADIUS_RAD] += 1e3
        sun_px = camera.pixels((self.c_body_from_itrf @ self.sun_itrf)[None])[0]
        if not np.all(np.isfinite(sun_px)):
            return
        centre_px = np.array([camera.cx_px, camera.cy_px])
        for along, radius, strength in ((0.4, 0.03, 0.03), (-0.5, 0.06, 0.02), (-1.1, 0.1, 0.01)):
            x, y = centre_px + along * (sun_px - centre_px)
            ghost = np.zeros(size, dtype=np.float32)
            radius_px = round(radius * camera.width_px)
            if max(abs(x), abs(y)) < 1e4:
                import cv2  # no request needs it

                cv2.circle(ghost, (round(x), round(y)), radius_px, 1.0, -1, cv2.LINE_AA)
            radiance_ratio += (self.scene.glare * 10.0 * strength * ghost)[..., None]


def _pixel_rays_itrf(camera: HorizonCamera, c_body_from_itrf: Array) -> Array:
    x, y = np.meshgrid(
        np.arange(camera.width_px, dtype=float), np.arange(camera.height_px, dtype=float)
    )
    return camera.rays_body(np.column_stack([x.ravel(), y.ravel()])) @ c_body_from_itrf


def _look_up(tables: LimbRadiance, azimuth_rad: Array, tangent_m: Array) -> tuple[Array, Array]:
    """Radiance and transmittance (n, 3) by bilinear interpolation in the tables."""
    grid_rad, grid_m = tables.azimuth_rad, tables.tangent_m
    middle_rad = 0.5 * (grid_rad[0] + grid_rad[-1])
    turn_rad = np.angle(np.exp(1j * (azimuth_rad - middle_rad)))
    row = turn_rad / (grid_rad[1] - grid_rad[0]) + 0.5 * (len(grid_rad) - 1)
    row = np.clip(row, 0.0, len(grid_rad) - 1.001)
    column = np.interp(tangent_m, grid_m, np.arange(len(grid_m)))
    column = np.clip(column, 0.0, len(grid_m) - 1.001)
    radiance, transmittance = np.zeros((len(row), 3)), np.ones((len(row), 3))
    low = tangent_m <= grid_m[-1]  # above it is sky
    radiance[low] = interpolate(tables.radiance_ratio, row[low], column[low])
    transmittance[low] = interpolate(tables.transmittance, row[low], column[low])
    return radiance, transmittance


def _textbook(azimuth_rad: Array, height_m: float) -> LimbRadiance:
    tangent_m = tangent_grid_m()
    depth = np.exp(-np.clip((tangent_m - height_m) / 7.6e3, -4.0, 40.0))
    shape = (len(azimuth_rad), len(tangent_m), 3)
    radiance = 0.45 * (1.0 - np.exp(-depth))[None, :, None] * [1.1, 1.0, 0.9]
    return LimbRadiance(
        azimuth_rad=azimuth_rad,
        tangent_m=tangent_m,
        radiance_ratio=np.broadcast_to(radiance, shape),
        transmittance=np.broadcast_to(np.exp(-depth)[None, :, None], shape),
    )


def _texture(rng: np.random.Generator, exponent: float) -> NDArray[np.float32]:
    """A tile of fractal noise, its values spread evenly over 0..1, which wraps.

    exponent: amplitudes fall with this power of the frequency.
    """
    frequency = np.fft.fftfreq(_TILE_PX)
    radius = np.hypot(frequency[:, None], frequency[None, : _TILE_PX // 2 + 1])
    radius[0, 0] = 1.0
    spectrum = np.fft.rfft2(rng.standard_normal((_TILE_PX, _TILE_PX))) / radius**exponent
    spectrum[radius < 4.0 / _TILE_PX] = 0.0
    noise = np.fft.irfft2(spectrum, s=(_TILE_PX, _TILE_PX))
    ranks = np.empty(noise.size, dtype=np.float32)
    ranks[np.argsort(noise, axis=None)] = np.linspace(0.0, 1.0, noise.size, dtype=np.float32)
    return ranks.reshape(noise.shape)


def _sample(tile: NDArray[np.float32], x_m: Array, y_m: Array, zoom_factor: float) -> Array:
    scale = zoom_factor * _TILE_PX / _TILE_M
    row, column = (np.mod(at_m * scale, _TILE_PX - 1.0) for at_m in (x_m, y_m))
    return interpolate(tile, row, column)


def _roughness(rng: np.random.Generator, rms_m: float, correlation_deg: float) -> Array:
    """Heights around the horizon, from -pi to pi, with a Gaussian correlation."""
    count = 1440
    lag = np.arange(count) * 360.0 / count
    order = np.fft.rfftfreq(count, 1.0 / count)
    power = np.exp(-0.25 * (order * np.deg2rad(correlation_deg)) ** 2)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(len(lag))) * power, n=count)
    noise *= rms_m / max(float(np.std(noise)), 1e-12)
    return np.append(noise, noise[0])


def _add_stars(
    radiance_ratio: Array, transmittance: Array, count: int, rng: np.random.Generator
) -> None:
    if count == 0:
        return
    height, width = radiance_ratio.shape[:2]
    x = rng.integers(1, width - 1, count)
    y = rng.integers(1, height - 1, count)
    # Star counts rise fourfold a magnitude: Euclidean counts, flux^-1.5.
    flux = 0.02 * rng.random(count) ** (-1.0 / 1.5)
    radiance_ratio[y, x] += np.minimum(flux, 1.0)[:, None] * transmittance[y, x]
