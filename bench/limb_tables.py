"""Radiance of the Earth's limb by SASKTRAN2, under airs named below, for bench/horizon_air.py.

Run, in an environment of its own (pip install sasktran2==2026.10.1; MIT licence), no network:
    python bench/limb_tables.py tests/data/horizon/air [NAME ...] [--suns N]
Any drawn_N may be named.  --suns: only the N highest of SUN_ZENITH_DEG.
Spherical shells, all orders of scattering (scalar), Lambertian ground; none of the project's code.
Neglects polarisation (some per cent of radiance) and refraction (0.2 km at 17 km).
Sources: Zawada et al. 2015 for the method; U.S. Standard Atmosphere 1976 and Anderson et al. 1986
(AFGL-TR-86-0110) for temperatures; Bodhaine et al. 1999, eq. 29, for Rayleigh scattering;
Leckner 1978 for ozone.
"""

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import sasktran2 as sk


def _numbers(text: str) -> np.ndarray:
    return np.array(text.split(), dtype=float)


EARTH_M, TOP_M, CRAFT_M = 6371.0e3, 100.0e3, 500.0e3
ALTITUDE_M = np.concatenate(
    [np.arange(0, 12e3, 500.0), np.arange(12e3, 50e3, 1e3), np.arange(50e3, 100.1e3, 2.5e3)]
)
TANGENT_M = np.concatenate(
    [
        -np.array([6370e3, 5000e3, 2500e3, 1200e3, 600e3, 320e3, 180e3, 100e3, 60e3, 35e3]),
        -np.array([20e3, 12e3, 7e3, 4e3, 2e3, 1e3, 0.5e3]),
        np.arange(0.25e3, 32e3, 1e3),
        np.arange(32.25e3, 60e3, 2e3),
        np.arange(62e3, 98e3, 5e3),
    ]
)
SUN_ZENITH_DEG = np.array([0.0, 30, 45, 57, 67, 75, 80, 84, 87, 89, 91, 93, 95, 97])
AZIMUTH_DEG = np.arange(0.0, 181.0, 30.0)  # of the ray from the Sun's; 0 looks towards the Sun
# Two wavelengths a band: blue, green, red.
WAVELENGTH_NM = np.array([435.0, 480.0, 525.0, 565.0, 600.0, 640.0])
OZONE_PER_ATM_CM = np.interp(
    WAVELENGTH_NM,
    np.arange(440.0, 661.0, 10.0),
    _numbers("""
        0 .003 .006 .009 .014 .021 .030 .040 .048 .063 .075 .085 .103
        .120 .120 .115 .125 .120 .105 .090 .079 .067 .057
    """),
)
MOMENTS = 32
STEP = 5e-4  # of the logarithm of radiance, in which tables are stored


@dataclass(frozen=True)
class Air:
    """scale_km: of an exponential air; or else temperature_k (2, n) (km, K) and 1013 hPa.

    depth: of the air against the standard 1.225 kg/m3 at 8.4 km (exponential: 1.225 * depth at
    the ground).  ozone_du in a Gaussian layer.  Dust: vertical optical depth at 550 nm near the
    ground, its scale height, single scattering albedo in blue, green, red; stratosphere: depth
    of a layer 5 km wide.  albedo: of the ground.
    """

    scale_km: float | None = None
    temperature_k: np.ndarray | None = None
    depth: float = 1.0
    ozone_du: float = 0.0
    ozone_km: float = 22.0
    dust: float = 0.0
    dust_km: float = 1.5
    dust_ssa: tuple[float, float, float] = (0.95, 0.95, 0.95)
    stratosphere: float = 0.0
    stratosphere_km: float = 19.0
    albedo: float = 0.3


# Heights in km, temperatures in K.
STANDARD = (
    _numbers("""
    0 288.15  11 216.65  20 216.65  32 228.65  47 270.65  51 270.65  71 214.65  85 187  100 195
""")
    .reshape(-1, 2)
    .T
)
TROPICAL = (
    _numbers("""
    0 299.7  2 287.7  3 283.7  16 197.0  17 194.8  18 198.8  22 214.6  30 232.3  35 243.1
    40 254.0  47 269.0  50 270.2  60 253.1  70 218.9  80 198.0  100 190.0
""")
    .reshape(-1, 2)
    .T
)
SUBARCTIC_WINTER = (
    _numbers("""
    0 257.2  1 259.1  3.5 250.2  8.5 218.9  9 217.2  15 217.2  25 211.8  30 216.0  35 222.2
    40 234.7  50 259.3  60 250.9  70 245.0  80 220.0  100 205.0
""")
    .reshape(-1, 2)
    .T
)
_CLEAR = Air(temperature_k=STANDARD, ozone_du=300, dust=0.1, stratosphere=0.003)
NAMED = {
    "standard": _CLEAR,
    "thin_7km": Air(scale_km=7.0, depth=0.6, albedo=0.1),
    "dense_8km": Air(scale_km=8.0, depth=1.5),
    "dusty": replace(_CLEAR, dust=0.4, dust_km=2.5, stratosphere=0.02),
    "clean_sea": Air(temperature_k=STANDARD, albedo=0.05),
    "exponential": Air(scale_km=7.5),
    "dense_7km": Air(scale_km=7.0, depth=1.5, albedo=0.1),
    "thin_8km": Air(scale_km=8.0, depth=0.6),
    "tropical": Air(
        temperature_k=TROPICAL,
        ozone_du=260,
        ozone_km=25,
        dust=0.15,
        stratosphere=0.004,
        stratosphere_km=21,
        albedo=0.15,
    ),
    "arctic_winter": Air(
        temperature_k=SUBARCTIC_WINTER,
        ozone_du=400,
        ozone_km=19,
        dust=0.05,
        stratosphere=0.005,
        stratosphere_km=15,
        albedo=0.7,
    ),
    "desert": Air(
        temperature_k=STANDARD,
        ozone_du=280,
        dust=0.5,
        dust_km=3.0,
        dust_ssa=(0.85, 0.93, 0.96),
        albedo=0.25,
    ),
    "after_eruption": replace(_CLEAR, stratosphere=0.08, stratosphere_km=21),
}


def drawn(seed: int) -> Air:
    """An air that nobody chose."""
    rng = np.random.default_rng([1976, seed])
    exponential = rng.uniform() < 0.4
    profiles = (STANDARD, TROPICAL, SUBARCTIC_WINTER)
    return Air(
        scale_km=rng.uniform(7.0, 8.0) if exponential else None,
        temperature_k=None if exponential else profiles[rng.integers(3)],
        depth=rng.uniform(0.6, 1.5) if exponential else 1.0,
        ozone_du=0.0 if rng.uniform() < 0.3 else rng.uniform(200.0, 450.0),
        ozone_km=rng.uniform(18.0, 26.0),
        dust=0.0 if rng.uniform() < 0.3 else np.exp(rng.uniform(np.log(0.03), np.log(0.5))),
        dust_km=rng.uniform(1.0, 3.0),
        dust_ssa=(rng.uniform(0.85, 0.95), 0.94, 0.96),
        stratosphere=0.0 if exponential else np.exp(rng.uniform(np.log(0.001), np.log(0.02))),
        stratosphere_km=rng.uniform(16.0, 22.0),
        albedo=rng.uniform(0.05, 0.6),
    )


NAMES = (*NAMED, *(f"drawn_{seed}" for seed in range(1, 7)))


def density_per_m3(air: Air) -> np.ndarray:
    """Molecules per m3 at ALTITUDE_M."""
    ground = 2.547e25 * air.depth  # U.S. Standard Atmosphere 1976, sea level
    if air.temperature_k is None:
        return ground * np.exp(-ALTITUDE_M / (1e3 * air.scale_km))
    fine_m = np.arange(0.0, 100.1e3, 100.0)
    kelvin = np.interp(fine_m / 1e3, *air.temperature_k)
    gravity = 9.80665 * (EARTH_M / (EARTH_M + fine_m)) ** 2
    slope = 0.0289644 * gravity / (8.31446 * kelvin)
    pressure_pa = 101325.0 * np.exp(-np.cumsum(slope) * 100.0 + 0.5 * 100.0 * (slope + slope[0]))
    return np.interp(ALTITUDE_M, fine_m, air.depth * pressure_pa / (1.380649e-23 * kelvin))


def rayleigh_m2(wavelength_nm: np.ndarray) -> np.ndarray:
    """Cross-section of a molecule of dry air (Bodhaine 1999, eq. 29; there in 1e-28 cm2)."""
    um2 = (1e-3 * wavelength_nm) ** 2
    above = 1.0455996 - 341.29061 / um2 - 0.90230850 * um2
    return 1e-32 * above / (1.0 + 0.0027059889 / um2 - 85.968563 * um2)


def layer_per_m(middle_km: float, width_km: float) -> np.ndarray:
    shape = np.exp(-0.5 * ((ALTITUDE_M / 1e3 - middle_km) / width_km) ** 2)
    return shape / (1e3 * width_km * np.sqrt(2.0 * np.pi))


def constituent(air: Air) -> sk.constituent.Manual:
    gas = density_per_m3(air)[:, None] * rayleigh_m2(WAVELENGTH_NM)
    ozone = layer_per_m(air.ozone_km, 5.0)[:, None] * (OZONE_PER_ATM_CM * air.ozone_du / 1e3)
    low = air.dust / (1e3 * air.dust_km) * np.exp(-ALTITUDE_M / (1e3 * air.dust_km))
    high = air.stratosphere * layer_per_m(air.stratosphere_km, 2.5)
    dust = low[:, None] * (550.0 / WAVELENGTH_NM) ** 1.0
    haze = high[:, None] * (550.0 / WAVELENGTH_NM) ** 1.5
    dust_scattered = dust * np.repeat(air.dust_ssa, 2)
    scattered = gas + dust_scattered + haze
    extinction = gas + ozone + dust + haze
    moment = np.arange(MOMENTS)[:, None, None]
    grains = (2 * moment + 1) * (0.70**moment * dust_scattered + 0.65**moment * haze)
    molecules = np.zeros((MOMENTS, 1, 1))
    molecules[[0, 2], 0, 0] = 1.0, 0.479  # depolarised by 0.028
    return sk.constituent.Manual(
        extinction, scattered / extinction, (grains + molecules * gas) / scattered
    )


def radiance(air: Air, sun_deg: float, albedo: float, highest_m: float) -> np.ndarray:
    """Of an overhead white Lambertian surface, shape (azimuths, tangent heights, 3)."""
    orders = highest_m > 0.0
    tangents_m = TANGENT_M[highest_m > TANGENT_M]
    cos_sun = float(np.cos(np.deg2rad(sun_deg)))
    geometry = sk.Geometry1D(
        cos_sza=cos_sun,
        solar_azimuth=0.0,
        earth_radius_m=EARTH_M,
        altitude_grid_m=ALTITUDE_M,
        interpolation_method=sk.InterpolationMethod.LinearInterpolation,
        geometry_type=sk.GeometryType.Spherical,
    )
    rays = sk.ViewingGeometry()
    for azimuth_rad in np.deg2rad(AZIMUTH_DEG):
        for tangent_m in tangents_m:
            if tangent_m > 0.0:
                ray = sk.TangentAltitudeSolar(tangent_m, azimuth_rad, CRAFT_M, cos_sun)
            else:
                up = np.sqrt(1.0 - ((EARTH_M + tangent_m) / EARTH_M) ** 2)
                ray = sk.GroundViewingSolar(cos_sun, azimuth_rad, up, CRAFT_M)
            rays.add_ray(ray)
    config = sk.Config()
    config.num_streams = 8
    config.num_singlescatter_moments = MOMENTS
    config.single_scatter_source = sk.SingleScatterSource.Exact
    source = sk.MultipleScatterSource
    config.multiple_scatter_source = source.SuccessiveOrders if orders else source.DiscreteOrdinates
    config.num_successive_orders_iterations = 8
    atmosphere = sk.Atmosphere(
        geometry, config, wavelengths_nm=WAVELENGTH_NM, calculate_derivatives=False
    )
    atmosphere["air"] = constituent(air)
    atmosphere["ground"] = sk.constituent.LambertianSurface(albedo)
    found = sk.Engine(config, geometry, rays).calculate_radiance(atmosphere)["radiance"]
    per_wavelength = found.values.reshape(len(WAVELENGTH_NM), len(AZIMUTH_DEG), len(tangents_m))
    bands = per_wavelength.reshape(3, 2, *per_wavelength.shape[1:]).mean(axis=1)
    return np.pi * np.moveaxis(bands, 0, -1)


def table(air: Air, sun_zenith_deg: np.ndarray) -> dict[str, np.ndarray]:
    light = [radiance(air, sun_deg, air.albedo, TOP_M) for sun_deg in sun_zenith_deg]
    # Of rays to the ground; discrete ordinates are fast, and enough for this.
    brighter, as_is = (
        np.array([radiance(air, sun_deg, air.albedo + more, 0.0) for sun_deg in sun_zenith_deg])
        for more in (0.1, 0.0)
    )
    coded = {
        "log_radiance": np.log(np.maximum(light, 1e-7)),
        "log_per_albedo": np.log(np.maximum((brighter - as_is) / 0.1, 1e-7)),
    }
    return {name: np.rint(value / STEP).astype(np.int16) for name, value in coded.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", default=NAMES)
    parser.add_argument("--suns", type=int, default=len(SUN_ZENITH_DEG))
    asked = parser.parse_args()
    sun_zenith_deg = SUN_ZENITH_DEG[: asked.suns]
    for name in asked.names:
        start = time.monotonic()
        air = NAMED[name] if name in NAMED else drawn(int(name.removeprefix("drawn_")))
        np.savez_compressed(
            asked.folder / f"{name}.npz",
            **table(air, sun_zenith_deg),
            step=STEP,
            tangent_m=TANGENT_M,
            sun_zenith_deg=sun_zenith_deg,
            azimuth_deg=AZIMUTH_DEG,
            albedo=air.albedo,
        )
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
