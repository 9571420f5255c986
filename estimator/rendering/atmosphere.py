"""The brightness of the air along a ray past the Earth: the renderer's physics.

Single scattering of sunlight in a spherical atmosphere, integrated along every ray:
Rayleigh scattering, dust near the ground and in a stratospheric layer, ozone absorption,
the Earth's own shadow, a grey allowance for multiple scattering, and the airglow layer.
Nothing here knows where the estimator thinks the limb is: its height comes out of the
integral.  Neglects refraction (0.2 km at 17 km) and polarisation.
Source: Chandrasekhar 1960, ch. I; Bucholtz 1995 for Rayleigh cross-sections.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.spec import Within, spec

EARTH_M = 6371.0e3
TOP_M = 110.0e3
# Three bands, blue, green, red, as in an OpenCV image: 460, 540, 620 nm.
RAYLEIGH_PER_M = np.array([27.3e-6, 14.1e-6, 8.0e-6])  # Bucholtz 1995, table 3, sea level
OZONE_VERTICAL = np.array([0.003, 0.026, 0.036])  # 300 DU; Chappuis band, Brion 1998
SUN_COLOUR = np.array([1.0, 1.0, 0.95])
AIRGLOW_COLOUR = np.array([0.25, 1.0, 0.45])  # OI 557.7 nm, with sodium and OH in the red
_OPAQUE = 60.0


@spec
class Atmosphere:
    """Composition of the air; the defaults are a clear day.

    air_scale_m: scale height of the air.
    air_density: at sea level, against the usual.
    dust_optical_depth: vertical, of the dust near the ground.
    dust_scale_m: scale height of that dust.
    haze_optical_depth: vertical, of a layer in the stratosphere at 18 km.
    ozone: against the usual amount.
    diffuse_share: of sunlight, scattered more than once.
    airglow: brightness along the limb as a fraction of white.
    airglow_height_m: of the airglow's layer above the ellipsoid.
    """

    air_scale_m: Annotated[float, Within(1e3, 20e3)] = 7.6e3
    air_density: Annotated[float, Within(1e-3, 10.0)] = 1.0
    dust_optical_depth: Annotated[float, Within(0.0, 10.0)] = 0.10
    dust_scale_m: Annotated[float, Within(100.0, 20e3)] = 1.6e3
    haze_optical_depth: Annotated[float, Within(0.0, 1.0)] = 0.0015
    ozone: Annotated[float, Within(0.0, 10.0)] = 1.0
    diffuse_share: Annotated[float, Within(0.0, 1.0)] = 0.35
    airglow: Annotated[float, Within(0.0, 100.0)] = 0.0
    airglow_height_m: Annotated[float, Within(20e3, 110e3)] = 90.0e3


@dataclass(frozen=True)
class LimbRadiance:
    """Radiance and transmittance on a grid of sun-relative azimuth and tangent height.

    azimuth_rad (k,), tangent_m (m,) rising, radiance_ratio and transmittance (k, m, 3): radiance
    in units of a white Lambertian surface under the overhead Sun.
    """

    azimuth_rad: Array
    tangent_m: Array
    radiance_ratio: Array
    transmittance: Array


def tangent_grid_m() -> Array:
    """Tangent heights at which the integral is done: fine through the limb, coarse below."""
    return np.concatenate(
        [
            -np.geomspace(6.0e6, 2.0e3, 40),
            np.arange(-1.0e3, 50.0e3, 0.5e3),
            np.arange(50.0e3, TOP_M + 1.0, 2.0e3),
        ]
    )


def limb_radiance(
    air: Atmosphere, range_m: float, azimuth_rad: Array, sun_up: float, sun_azimuth_rad: float
) -> LimbRadiance:
    """Radiance of rays leaving a craft at the given azimuths about its nadir.

    range_m: the craft from the Earth's centre.  sun_up: cosine of the angle between the
    zenith and the Sun; azimuths (k,) and the Sun's are about nadir from a common origin.
    """
    tangent_m = tangent_grid_m()
    grazing = np.clip((EARTH_M + tangent_m) / range_m, -1.0, 1.0)
    zenith_part = np.sqrt(1.0 - grazing**2)  # of the ray's direction, downwards
    flat = np.sqrt(max(1.0 - sun_up**2, 0.0))
    along_sun = flat * np.cos(azimuth_rad - sun_azimuth_rad)
    # Sun in the ray's own plane: `ahead` along it, `above` along the vertical at its lowest point.
    ahead = along_sun[:, None] * grazing - sun_up * zenith_part
    above = along_sun[:, None] * zenith_part + sun_up * grazing
    path_m, length_m = _paths_m(tangent_m)
    step_m = length_m[..., None]
    up_m = EARTH_M + tangent_m[:, None]
    height_m = np.maximum(np.hypot(up_m, path_m) - EARTH_M, 0.0)
    sun_cosine = (above[..., None] * up_m + ahead[..., None] * path_m) / (height_m + EARTH_M)

    air_per_m, dust_per_m, ozone_per_m = _in_colour(*_densities(air, height_m))
    total_per_m = air_per_m + dust_per_m + ozone_per_m
    depth = np.cumsum(total_per_m * step_m, axis=1) - 0.5 * total_per_m * step_m
    weight = np.exp(-depth) * step_m
    lit = np.exp(-_sun_depth(air)(height_m[None], sun_cosine))
    # Light scattered more than once: grey, from a bright ground under the same Sun.
    diffuse = (
        air.diffuse_share
        * np.clip(sun_cosine + 0.1, 0.0, 1.0)[..., None]
        * np.exp(-height_m / 30e3)[None, ..., None]
    )
    glow = np.exp(-0.5 * ((height_m - air.airglow_height_m) / 3.5e3) ** 2)
    rayleigh = 0.75 * (1.0 + ahead**2)
    dust = _henyey_greenstein(ahead, 0.65)
    radiance = np.zeros((*ahead.shape, 3))
    for extinction_per_m, phase in ((air_per_m, rayleigh), (dust_per_m, dust)):
        light = SUN_COLOUR * (phase[..., None, None] * lit + diffuse)
        radiance += 0.25 * np.einsum("mpc,kmpc->kmc", weight * extinction_per_m, light)
    # 5.6e5 m of glow lie along a ray through the layer's middle.
    radiance += air.airglow / 5.6e5 * np.sum(glow * length_m, axis=1)[:, None] * AIRGLOW_COLOUR
    transmittance = np.exp(-np.sum(total_per_m * step_m, axis=1))
    return LimbRadiance(
        azimuth_rad=azimuth_rad,
        tangent_m=tangent_m,
        radiance_ratio=radiance,
        transmittance=np.broadcast_to(transmittance, radiance.shape),
    )


def sunlight_at_ground(air: Atmosphere, sun_cosine: Array) -> Array:
    """Direct and diffuse sunlight on level ground, shape (..., 3), 1 for the bare overhead Sun."""
    direct = np.exp(-_sun_depth(air)(np.zeros_like(sun_cosine), sun_cosine))
    level = np.clip(sun_cosine, 0.0, 1.0)[..., None]
    twilight = 0.12 * np.exp(np.minimum(sun_cosine, 0.0) / 0.05)[..., None]
    return np.asarray(direct * level + twilight * np.clip(level + 0.25, 0.0, 1.0))


def interpolate(table: Array | NDArray[np.float32], row_index: Array, column_index: Array) -> Array:
    """Bilinear: a table (k, m, ...) at rows and columns (n,) counted from 0, (n, ...)."""
    i = np.minimum(row_index.astype(int), table.shape[0] - 2)
    j = np.minimum(column_index.astype(int), table.shape[1] - 2)
    further = (..., *[None] * (table.ndim - 2))
    u, v = (row_index - i)[further], (column_index - j)[further]
    return np.asarray(
        (1 - u) * ((1 - v) * table[i, j] + v * table[i, j + 1])
        + u * ((1 - v) * table[i + 1, j] + v * table[i + 1, j + 1])
    )


class _SunDepth:
    """Optical depth from a height towards the Sun, by a table over height and sun cosine."""

    def __init__(self, air: Atmosphere) -> None:
        self.height_m = np.concatenate(
            [np.linspace(0.0, 60e3, 61), np.linspace(64e3, 0.99 * TOP_M, 12)]
        )
        self.cosine = np.concatenate(
            [np.linspace(-0.5, -0.2, 13)[:-1], np.linspace(-0.2, 0.2, 81), np.linspace(0.25, 1, 16)]
        )
        radius_m = EARTH_M + self.height_m[:, None, None]
        mu = self.cosine[None, :, None]
        lowest_m = radius_m * np.sqrt(1.0 - mu**2)
        blocked = (mu < 0.0) & (lowest_m < EARTH_M)
        end_m = np.sqrt((EARTH_M + TOP_M) ** 2 - lowest_m**2)
        start_m = radius_m * mu
        # Quadratic spacing about the lowest point of the path, where the air is dense.
        w0 = np.sign(start_m) * np.sqrt(np.abs(start_m) / end_m)
        w = np.linspace(0.0, 1.0, 97)[None, None, :] * (1.0 - w0) + w0
        x_m = end_m * w * np.abs(w)
        middle_m = 0.5 * (x_m[..., 1:] + x_m[..., :-1])
        height_m = np.maximum(np.sqrt(lowest_m**2 + middle_m**2) - EARTH_M, 0.0)
        columns = [
            np.sum(density * np.diff(x_m, axis=-1), axis=-1)
            for density in _densities(air, height_m)
        ]
        of_air, of_dust, of_ozone = _in_colour(*columns)
        # Blocked rays grow opaque smoothly with their depth below the ground, over 1 km.
        sunk = np.where(blocked[..., 0], (EARTH_M - lowest_m[..., 0]) / 1e3, 0.0)
        self.depth = np.minimum(of_air + of_dust + of_ozone + 8.0 * sunk[..., None], _OPAQUE)

    def __call__(self, height_m: Array, cosine: Array) -> Array:
        """Shape (..., 3) for heights and cosines of a common shape."""
        row = np.interp(height_m, self.height_m, np.arange(len(self.height_m)))
        column = np.interp(cosine, self.cosine, np.arange(len(self.cosine)))
        return interpolate(self.depth, row, column)


_sun_depth = lru_cache(maxsize=2)(_SunDepth)


def _in_colour(
    air_density: Array, dust_density: Array, ozone_density: Array
) -> tuple[Array, Array, Array]:
    """Extinction per m (..., 3) of air, dust and ozone in three colours, see `_densities`."""
    return (
        air_density[..., None] * RAYLEIGH_PER_M,
        dust_density[..., None],
        ozone_density[..., None] * OZONE_VERTICAL,
    )


def _densities(air: Atmosphere, height_m: Array) -> tuple[Array, Array, Array]:
    """Air relative to sea level; dust's extinction per m; ozone per m and vertical depth."""
    air_density = air.air_density * np.exp(-height_m / air.air_scale_m)
    near_ground = air.dust_optical_depth / air.dust_scale_m * np.exp(-height_m / air.dust_scale_m)
    haze = np.exp(-0.5 * ((height_m - 18e3) / 5e3) ** 2) / (5e3 * np.sqrt(2.0 * np.pi))
    ozone = np.exp(-0.5 * ((height_m - 22e3) / 5e3) ** 2) / (5e3 * np.sqrt(2.0 * np.pi))
    return air_density, near_ground + air.haze_optical_depth * haze, air.ozone * ozone


def _paths_m(tangent_m: Array, points: int = 72) -> tuple[Array, Array]:
    """Midpoints and lengths of steps along each ray, from the craft's side, (m, points)."""
    up_m = EARTH_M + tangent_m
    end_m = np.sqrt((EARTH_M + TOP_M) ** 2 - up_m**2)
    ground_m = -np.sqrt(np.maximum(EARTH_M**2 - up_m**2, 0.0))
    w = np.linspace(-1.0, 1.0, points + 1)
    passing_m = end_m[:, None] * np.sign(w) * np.abs(w) ** 1.5
    v = np.linspace(0.0, 1.0, points + 1)
    landing_m = ground_m[:, None] - (end_m + ground_m)[:, None] * (1.0 - v) ** 2
    edges_m = np.where(tangent_m[:, None] < 0.0, landing_m, passing_m)
    return 0.5 * (edges_m[:, 1:] + edges_m[:, :-1]), np.diff(edges_m, axis=1)


def _henyey_greenstein(cosine: Array, asymmetry_factor: float) -> Array:
    g = asymmetry_factor
    return np.asarray((1.0 - g**2) / (1.0 + g**2 - 2.0 * g * cosine) ** 1.5)
