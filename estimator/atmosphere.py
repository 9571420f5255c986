"""The brightness of the air along a ray past the Earth: the renderer's physics.

Single scattering of sunlight in a spherical atmosphere, integrated along every ray:
Rayleigh scattering, dust near the ground and in a stratospheric layer, ozone absorption,
the Earth's own shadow, a grey allowance for multiple scattering, and the airglow layer.
Nothing here knows where the estimator thinks the limb is: its height comes out of the
integral.  Neglects refraction (0.2 km at 17 km) and polarisation.
Source: Chandrasekhar 1960, ch. I; Bucholtz 1995 for Rayleigh cross-sections.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from planner.arrays import Array
from planner.spec import Within, spec

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
    """What the air holds; the defaults are a clear day.

    air_scale_m: scale height of the air.  dust_optical_depth: vertical, of the dust near the
    ground, whose scale height is dust_scale_m.  haze_optical_depth: vertical, of a layer in
    the stratosphere at 18 km.  airglow: brightness along the limb as a fraction of white.
    """

    air_scale_m: Annotated[float, Within(1e3, 20e3)] = 7.6e3
    air_density: Annotated[float, Within(1e-3, 10.0)] = 1.0
    dust_optical_depth: Annotated[float, Within(0.0, 10.0)] = 0.10
    dust_scale_m: Annotated[float, Within(100.0, 20e3)] = 1.6e3
    haze_optical_depth: Annotated[float, Within(0.0, 1.0)] = 0.0015
    ozone: Annotated[float, Within(0.0, 10.0)] = 1.0
    airglow: Annotated[float, Within(0.0, 100.0)] = 0.0
    airglow_height_m: Annotated[float, Within(20e3, 110e3)] = 90.0e3


@dataclass(frozen=True)
class LimbRadiance:
    """Radiance and transmittance on a grid of sun-relative azimuth and tangent height.

    azimuth_rad (k,), tangent_m (m,) rising, radiance and transmittance (k, m, 3): radiance in
    units of a white Lambertian surface under the overhead Sun.
    """

    azimuth_rad: Array
    tangent_m: Array
    radiance: Array
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
    tangent = tangent_grid_m()
    extinction_sun = _SunDepth(air)
    grazing = np.clip((EARTH_M + tangent) / range_m, -1.0, 1.0)
    zenith_part = np.sqrt(1.0 - grazing**2)  # of the ray's direction, downwards
    flat = np.sqrt(max(1.0 - sun_up**2, 0.0))
    along_sun = flat * np.cos(azimuth_rad - sun_azimuth_rad)
    # Sun in the ray's own plane: `ahead` along it, `above` along the vertical at its lowest point.
    ahead = along_sun[:, None] * grazing - sun_up * zenith_part
    above = along_sun[:, None] * zenith_part + sun_up * grazing
    path, step = _paths_m(tangent)
    up = EARTH_M + tangent[:, None]
    height = np.maximum(np.hypot(up, path) - EARTH_M, 0.0)
    sun_cosine = (above[..., None] * up + ahead[..., None] * path) / (height + EARTH_M)

    air_e, dust_e, ozone_e = _extinction_per_m(air, height)
    total = (
        air_e[..., None] * RAYLEIGH_PER_M + dust_e[..., None] + ozone_e[..., None] * OZONE_VERTICAL
    )
    depth = np.cumsum(total * step[..., None], axis=1) - 0.5 * total * step[..., None]
    seen = np.exp(-depth)
    scattering = ahead[..., None]
    rayleigh = 0.75 * (1.0 + scattering**2)
    dust = _henyey_greenstein(scattering, 0.65)
    lit = np.exp(-extinction_sun(height[None], sun_cosine))
    # Light scattered more than once: grey, from a bright ground under the same Sun.
    diffuse = (
        0.35
        * np.clip(sun_cosine + 0.1, 0.0, 1.0)[..., None]
        * np.exp(-height / 30e3)[None, ..., None]
    )
    weight = seen * step[..., None]
    radiance = 0.25 * np.einsum(
        "mpc,kmpc->kmc",
        weight * (air_e[..., None] * RAYLEIGH_PER_M),
        SUN_COLOUR * (rayleigh[..., None] * lit + diffuse),
    )
    radiance += 0.25 * np.einsum(
        "mpc,kmpc->kmc", weight * dust_e[..., None], SUN_COLOUR * (dust[..., None] * lit + diffuse)
    )
    glow = np.exp(-0.5 * ((height - air.airglow_height_m) / 3.5e3) ** 2)
    # 5.6e5 m of glow lie along a ray through the layer's middle.
    radiance += air.airglow / 5.6e5 * np.sum(glow * step, axis=1)[:, None] * AIRGLOW_COLOUR
    transmittance = np.exp(-np.sum(total * step[..., None], axis=1))
    return LimbRadiance(
        azimuth_rad=azimuth_rad,
        tangent_m=tangent,
        radiance=radiance,
        transmittance=np.broadcast_to(transmittance, radiance.shape),
    )


def sunlight_at_ground(air: Atmosphere, sun_cosine: Array) -> Array:
    """Direct and diffuse sunlight on level ground, shape (..., 3), 1 for the bare overhead Sun."""
    direct = np.exp(-_SunDepth(air)(np.zeros_like(sun_cosine), sun_cosine))
    level = np.clip(sun_cosine, 0.0, 1.0)[..., None]
    twilight = 0.12 * np.exp(np.minimum(sun_cosine, 0.0) / 0.05)[..., None]
    return np.asarray(direct * level + twilight * np.clip(level + 0.25, 0.0, 1.0))


class _SunDepth:
    """Optical depth from a height towards the Sun, by a table over height and sun cosine."""

    def __init__(self, air: Atmosphere) -> None:
        self.height = np.concatenate(
            [np.linspace(0.0, 60e3, 61), np.linspace(64e3, 0.99 * TOP_M, 12)]
        )
        self.cosine = np.concatenate(
            [np.linspace(-0.5, -0.2, 13)[:-1], np.linspace(-0.2, 0.2, 81), np.linspace(0.25, 1, 16)]
        )
        radius = EARTH_M + self.height[:, None, None]
        mu = self.cosine[None, :, None]
        lowest = radius * np.sqrt(1.0 - mu**2)
        blocked = (mu < 0.0) & (lowest < EARTH_M)
        end = np.sqrt((EARTH_M + TOP_M) ** 2 - lowest**2)
        start = radius * mu
        # Quadratic spacing about the lowest point of the path, where the air is dense.
        w0 = np.sign(start) * np.sqrt(np.abs(start) / end)
        w = np.linspace(0.0, 1.0, 97)[None, None, :] * (1.0 - w0) + w0
        x = end * w * np.abs(w)
        middle = 0.5 * (x[..., 1:] + x[..., :-1])
        height = np.maximum(np.sqrt(lowest**2 + middle**2) - EARTH_M, 0.0)
        columns = [np.sum(e * np.diff(x, axis=-1), axis=-1) for e in _extinction_per_m(air, height)]
        depth = (
            columns[0][..., None] * RAYLEIGH_PER_M
            + columns[1][..., None]
            + columns[2][..., None] * OZONE_VERTICAL
        )
        # Blocked rays grow opaque smoothly with their depth below the ground, over 1 km.
        sunk = np.where(blocked[..., 0], (EARTH_M - lowest[..., 0]) / 1e3, 0.0)
        self.depth = np.minimum(depth + 8.0 * sunk[..., None], _OPAQUE)

    def __call__(self, height: Array, cosine: Array) -> Array:
        """Shape (..., 3) for heights and cosines of a common shape."""
        row = np.interp(height, self.height, np.arange(len(self.height)))
        column = np.interp(cosine, self.cosine, np.arange(len(self.cosine)))
        i = np.minimum(row.astype(int), len(self.height) - 2)
        j = np.minimum(column.astype(int), len(self.cosine) - 2)
        i, j = np.broadcast_arrays(i, j)
        u, v = (row - i)[..., None], (column - j)[..., None]
        d = self.depth
        return np.asarray(
            (1 - u) * ((1 - v) * d[i, j] + v * d[i, j + 1])
            + u * ((1 - v) * d[i + 1, j] + v * d[i + 1, j + 1])
        )


def _extinction_per_m(air: Atmosphere, height: Array) -> tuple[Array, Array, Array]:
    """Air relative to sea level; dust; ozone per unit vertical depth."""
    air_e = air.air_density * np.exp(-height / air.air_scale_m)
    near_ground = air.dust_optical_depth / air.dust_scale_m * np.exp(-height / air.dust_scale_m)
    haze = np.exp(-0.5 * ((height - 18e3) / 5e3) ** 2) / (5e3 * np.sqrt(2.0 * np.pi))
    ozone = np.exp(-0.5 * ((height - 22e3) / 5e3) ** 2) / (5e3 * np.sqrt(2.0 * np.pi))
    return air_e, near_ground + air.haze_optical_depth * haze, air.ozone * ozone


def _paths_m(tangent: Array, points: int = 72) -> tuple[Array, Array]:
    """Midpoints and lengths of steps along each ray, from the craft's side, (m, points)."""
    up = EARTH_M + tangent
    end = np.sqrt((EARTH_M + TOP_M) ** 2 - up**2)
    ground = -np.sqrt(np.maximum(EARTH_M**2 - up**2, 0.0))
    hits = tangent < 0.0
    w = np.linspace(-1.0, 1.0, points + 1)
    passing = end[:, None] * np.sign(w) * np.abs(w) ** 1.5
    v = np.linspace(0.0, 1.0, points + 1)
    landing = ground[:, None] - (end + ground)[:, None] * (1.0 - v) ** 2
    edges = np.where(hits[:, None], landing, passing)
    return 0.5 * (edges[:, 1:] + edges[:, :-1]), np.diff(edges, axis=1)


def _henyey_greenstein(cosine: Array, asymmetry: float) -> Array:
    return np.asarray((1.0 - asymmetry**2) / (1.0 + asymmetry**2 - 2.0 * asymmetry * cosine) ** 1.5)
