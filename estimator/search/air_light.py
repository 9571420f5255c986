"""Profiles of the limb's light along the horizon by kind of air, for estimator/search/sunlight.py.

Linear fits to the limbs of SASKTRAN2 (the twelve chosen airs of bench/limb_tables.py and sixty
drawn as its `drawn` draws, seeds 101 to 160; drawn_1 to drawn_6 are not among them) and of 40 airs
of our own renderer, with the Sun 25 to 85 deg high.  Each limb is fitted to 0.02.
bench/air_light.py made the numbers; both scripts as of commit 54f03d3.
"""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array

_FORWARD = 0.65  # mean cosine of dust's scattering


@dataclass(frozen=True)
class AirLight:
    """How often a kind of air is met, and the mean (8,) and covariance (8, 8) of its light.

    Of blue brightness, by the columns of `brightness_basis`: contrast left of single scattering,
    dust's light against the air's if it scattered evenly, and sunlight's loss by its path's length
    against that straight down.  Of the logarithm of red over blue, by those of `colour_basis`: its
    slope and bend by the cosine of the angle to the Sun.  Of grey brightness: the first three.
    """

    share: float
    mean_parameters: Array
    covariance_parameters: Array


def brightness_basis(cosine: Array, sun_elevation_sine: Array) -> Array:
    """What the logarithm of the limb's brightness is made of, (n, 3).

    cosine (n,): of the ray and the Sun's direction.  sun_elevation_sine (n,): at the limb.
    """
    path = 1.0 / np.maximum(sun_elevation_sine, 0.02)
    return np.column_stack([np.log(1.0 + cosine**2), _dust_over_air(cosine), -path])


def colour_basis(cosine: Array) -> Array:
    """What the logarithm of red over blue is made of, (n, 2)."""
    return np.column_stack([cosine, cosine**2])


def _dust_over_air(cosine: Array) -> Array:
    """What dust scatters at an angle to the Sun, against air (Henyey and Greenstein 1941)."""
    dust = (1.0 - _FORWARD**2) / (1.0 + _FORWARD**2 - 2.0 * _FORWARD * cosine) ** 1.5
    return np.asarray(dust / (0.75 * (1.0 + cosine**2)))


def _kind(share: float, mean: str, covariance: str, scale: float = 1.0) -> AirLight:
    """covariance: its lower triangle by rows, in 1e-5."""
    lower = np.zeros((8, 8))
    lower[np.tril_indices(8)] = 1e-5 * np.array(covariance.split(), dtype=float)
    full = lower + np.tril(lower, -1).T
    return AirLight(share, np.array(mean.split(), dtype=float), scale**2 * full)


_SCATTERED_OFTEN = (
    "0.491 0.299 0.014 0.106 0.059 0.494 0.362 0.017",
    """
    1451
    -1703 3256
    -35 104 14
    -146 519 11 725
    239 -177 -4 109 98
    1546 -1875 -36 -275 271 1910
    -1730 3271 94 1037 -84 -2021 3994
    -46 121 13 27 -4 -53 115 20
    """,
)
_SCATTERED_ONCE = (
    "0.867 0.1 0.018 0.082 0.009 0.843 0.143 0.026",
    """
    676
    -521 629
    8 -5 3
    -400 404 -3 522
    24 -17 0 57 47
    724 -647 9 -504 32 994
    -684 657 -9 676 47 -864 1152
    -50 58 0 44 -5 -66 63 12
    """,
)
AIRS = (
    _kind(0.5, *_SCATTERED_OFTEN),
    # As our renderer has it, where little is scattered more than once.
    _kind(0.35, *_SCATTERED_ONCE),
    # Laden with dust, or with the haze of an eruption.
    _kind(0.15, *_SCATTERED_OFTEN, scale=2.5),
)
