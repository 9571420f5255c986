"""Refractivity by height: U.S. Standard Atmosphere 1976, dry air."""

import numpy as np
from numpy.typing import ArrayLike

from planner.base.arrays import Array

TOP_M = 120e3  # a ray refracts less than 1e-4 arcsec above
_G0 = 9.80665
_GAS_CONSTANT = 287.05287  # J/(kg K), from R* = 8.31432 and 28.9644 kg/kmol: USSA76 table 2
_SEA_LEVEL_PA = 101325.0
_GEOPOTENTIAL_RADIUS_M = 6356766.0
_LAYER_BASE_M = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3, 84852.0])  # USSA76 table 4
_LAPSE_K_M = np.array([-6.5e-3, 0.0, 1e-3, 2.8e-3, 0.0, -2.8e-3, -2.0e-3, 0.0])


def _base_states() -> tuple[Array, Array]:
    temperature, pressure = np.array([288.15]), np.array([_SEA_LEVEL_PA])
    for layer, thickness_m in enumerate(np.diff(_LAYER_BASE_M)):
        t, p = _within_layer(temperature[-1:], pressure[-1:], _LAPSE_K_M[layer], thickness_m)
        temperature, pressure = np.append(temperature, t), np.append(pressure, p)
    return temperature, pressure


def _within_layer(
    base_k: Array, base_pa: Array, lapse_k_m: Array, above_m: Array
) -> tuple[Array, Array]:
    """Temperature and pressure some geopotential metres above a layer's base, eq. 33a and 33b."""
    temperature = base_k + lapse_k_m * above_m
    isothermal = lapse_k_m == 0.0
    exponent = -_G0 / _GAS_CONSTANT / np.where(isothermal, 1.0, lapse_k_m)
    pressure = np.where(
        isothermal,
        base_pa * np.exp(-_G0 * above_m / (_GAS_CONSTANT * base_k)),
        base_pa * (temperature / base_k) ** exponent,
    )
    return temperature, pressure


_BASE_K, _BASE_PA = _base_states()


def density_kg_m3(height_m: ArrayLike) -> Array:
    """Shape of `height_m`; isothermal above 86 km, where the standard has its own tables."""
    height = np.asarray(height_m)
    geopotential_m = _GEOPOTENTIAL_RADIUS_M * height / (_GEOPOTENTIAL_RADIUS_M + height)
    layer = np.clip(np.searchsorted(_LAYER_BASE_M, geopotential_m, side="right") - 1, 0, None)
    temperature, pressure = _within_layer(
        _BASE_K[layer], _BASE_PA[layer], _LAPSE_K_M[layer], geopotential_m - _LAYER_BASE_M[layer]
    )
    return np.asarray(pressure / (_GAS_CONSTANT * temperature))


def refractivity(height_m: ArrayLike) -> Array:
    """n - 1 at 550 nm, shape of `height_m`; proportional to density (Gladstone-Dale).

    From 400 to 700 nm it varies by +-1 %; moist air refracts up to 0.5 % less.
    """
    return np.asarray(_PER_DENSITY * density_kg_m3(height_m))


# Edlen 1966, Metrologia 2, 71, eq. 1: dry air at 15 C and 101325 Pa
_WAVENUMBER2_UM2 = 1.0 / 0.55**2
_STANDARD_AIR = 1e-8 * (
    8342.13 + 2406030.0 / (130.0 - _WAVENUMBER2_UM2) + 15997.0 / (38.9 - _WAVENUMBER2_UM2)
)
_PER_DENSITY = _STANDARD_AIR / 1.2250  # kg/m3 at 15 C and 101325 Pa: USSA76 table 1
