"""The height of the daylight limb where the Sun is low.

A textbook limb: air falling off exponentially, lit through itself.  With t the slant optical
depth of a grazing ray, the brightness is (1 - exp(-t)) exp(-e t): the second factor is what
reaches the air from the Sun, e the Sun's path through the air against the grazing ray's.
The limb is where the brightness changes fastest with height, t = exp(-(h - h0)/H).
It gives +1.3 km at 10 deg, +6 at 0 and +22 at -4 deg; measured limbs rise by 1, 5 and 20.
Source: Chapman 1931 for the path; Smith and Smith 1972, eq. 3, for its closed form.
"""

from functools import cache

import numpy as np

from planner.base.arrays import Array

AIR_SCALE_M = 7.6e3
_EARTH_RADII = 6371.0e3 / AIR_SCALE_M
_GRAZING_PATH = float(np.sqrt(2.0 * np.pi * _EARTH_RADII))
_USUAL_SUN_DEG = 50.0


def sun_rise_m(sun_elevation_rad: Array) -> Array:
    """How much higher than under a Sun 50 deg high the limb stands, same shape."""
    elevation, rise = _rises()
    return np.interp(np.rad2deg(sun_elevation_rad), elevation, rise)


@cache
def _rises() -> tuple[Array, Array]:
    elevation = np.concatenate([np.linspace(-8.0, 20.0, 113), np.linspace(22.0, 90.0, 35)])
    t = np.geomspace(1e-4, 8.0, 20001)
    above = np.array(
        [
            -np.log(t[np.argmax(t * np.exp(-e * t) * ((1.0 + e) * np.exp(-t) - e))])
            for e in chapman_path(np.deg2rad(elevation)) / _GRAZING_PATH
        ]
    )
    usual = np.interp(_USUAL_SUN_DEG, elevation, above)
    return elevation, AIR_SCALE_M * (above - usual)


def chapman_path(elevation_rad: Array) -> Array:
    """Air along a ray at an elevation against that straight up (Chapman's function)."""
    from scipy.special import erfcx

    x = _EARTH_RADII
    sine = np.sin(np.abs(elevation_rad))
    upward = np.sqrt(0.5 * np.pi * x) * erfcx(np.sqrt(0.5 * x) * sine)
    # Below the horizontal: all of the path through the lowest point, less the part behind.
    sunk = x * (1.0 - np.cos(elevation_rad))
    through = 2.0 * np.sqrt(0.5 * np.pi * x) * np.exp(np.minimum(sunk, 50.0))
    return np.asarray(np.where(elevation_rad >= 0.0, upward, through - upward))
