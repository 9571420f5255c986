"""What do airs make of the limb's light?  Prints the numbers of estimator/search/air_light.py.

First sixty airs drawn by chance, in the environment that bench/limb_tables.py names (20 minutes);
then their fits (half a minute), together with those of the chosen airs and of our own renderer:
    python bench/limb_tables.py FOLDER drawn_{101..160} --suns 6
    OMP_NUM_THREADS=1 python bench/air_light.py FOLDER
Seen from 500 km above a sphere, all around the horizon where the Sun is 6 deg high and more.  With
six Suns, those lower than 15 deg are extrapolated in the drawn airs: on the chosen ones that takes
0.02 off sunlight's loss and 0.015 off the contrast, and adds 0.03 to dust.  Eight leave none out.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from horizon_air import TUNED
from horizon_cases import other_air, random_air
from limb_frames import SPHERE_M, Floats, limb_table
from scipy.linalg import block_diag
from scipy.ndimage import gaussian_filter1d

from estimator.rendering.atmosphere import Atmosphere, limb_radiance
from estimator.search.air_light import brightness_basis, colour_basis

DRAWN = tuple(f"drawn_{seed}" for seed in range(101, 161))
OTHER_AIRS, RANDOM_AIRS, SEED = 25, 15, 7
RANGE_M = SPHERE_M + 500e3
SUN_ELEVATION_DEG = np.arange(25.0, 86.0, 10.0)  # at the craft
LOWEST_SUN_DEG = 6.0  # at the limb
AZIMUTH_RAD = np.deg2rad(np.arange(0.0, 360.0, 5.0))  # from the Sun's
HEIGHT_M = np.arange(250.0, 75e3, 250.0)
LIMB_M = 20e3
LOWEST_EDGE_M = 6e3
SMOOTHED_M = 5e3  # as small frames do it
WITHIN_M = (6e3, 10e3, 14e3)  # of the edge, where estimator/search/sunlight.py takes colour
# 1-sigma of what airs that neither model has may add.
BEYOND = np.array([0.03, 0.03, 0.005, 0.02, 0.01, 0.03, 0.03, 0.005])

Limb = Callable[[float], Floats]
"""Radiance (azimuths, heights, 3) under a Sun so high, in deg."""


def suns(elevation_deg: float) -> tuple[Floats, Floats]:
    """Along the horizon: the sine of the Sun's elevation there, its cosine from the ray."""
    dip_rad = np.arccos((SPHERE_M + LIMB_M) / RANGE_M)
    up = np.sin(np.deg2rad(elevation_deg))
    level = np.cos(np.deg2rad(elevation_deg)) * np.cos(AZIMUTH_RAD)
    return (
        up * np.cos(dip_rad) + level * np.sin(dip_rad),
        level * np.cos(dip_rad) - up * np.sin(dip_rad),
    )


def tabled(air: str, *folder: Path) -> Limb:
    """SASKTRAN2's."""
    light = limb_table(air, *folder).light

    def limb(elevation_deg: float) -> Floats:
        sine, cosine = suns(elevation_deg)
        azimuth = np.clip(cosine / np.maximum(np.sqrt(1.0 - sine**2), 1e-9), -1.0, 1.0)
        sun_deg, ray_deg = np.rad2deg(np.arccos(sine)), np.rad2deg(np.arccos(azimuth))
        at = np.empty((len(AZIMUTH_RAD), len(HEIGHT_M), 3))
        at[..., 0], at[..., 1] = sun_deg[:, None], ray_deg[:, None]
        at[..., 2] = HEIGHT_M
        return np.exp(light(at))

    return limb


def rendered(air: Atmosphere) -> Limb:
    """Our own renderer's."""

    def limb(elevation_deg: float) -> Floats:
        sun_up = float(np.sin(np.deg2rad(elevation_deg)))
        found = limb_radiance(air, RANGE_M, AZIMUTH_RAD, sun_up, 0.0)
        light = np.empty((len(AZIMUTH_RAD), len(HEIGHT_M), 3))
        for row, radiance in enumerate(found.radiance_ratio):
            for band in range(3):
                light[row, :, band] = np.interp(HEIGHT_M, found.tangent_m, radiance[:, band])
        return light

    return limb


def edges(light: Floats) -> tuple[Floats, Floats]:
    """Of light (n, heights): the height where it rises fastest inwards, and that rise."""
    rise = -np.gradient(light, HEIGHT_M, axis=1)
    rise[:, HEIGHT_M <= LOWEST_EDGE_M] = 0.0
    return HEIGHT_M[np.argmax(rise, axis=1)], rise.max(axis=1)


def reddened(light: Floats, edge_m: Floats) -> Floats:
    """Logarithm of red over blue within the edges, of light (n, heights, 3)."""
    blue, red = (
        [
            np.mean([np.interp(top_m - depth_m, HEIGHT_M, one) for depth_m in WITHIN_M])
            for top_m, one in zip(edge_m, light[..., band], strict=True)
        ]
        for band in (0, 2)
    )
    return np.log(np.array(red) / np.array(blue))


def coefficients(limb: Limb) -> tuple[Floats, Floats]:
    """The eight of `AirLight`, and the rms of what each of the three fits leaves.

    Each Sun has a level of its own, as each exposure has.
    """
    bases: list[tuple[Floats, Floats]] = []
    measures: list[tuple[Floats, Floats, Floats]] = []
    for elevation_deg in SUN_ELEVATION_DEG:
        sine, cosine = suns(elevation_deg)
        lit = sine > np.sin(np.deg2rad(LOWEST_SUN_DEG))
        light = limb(elevation_deg)[lit]
        seen = gaussian_filter1d(light, SMOOTHED_M / (HEIGHT_M[1] - HEIGHT_M[0]), axis=1)
        edge_m, slope = edges(seen[..., 0])
        _, grey_slope = edges(seen.mean(axis=2))
        bases.append((brightness_basis(cosine[lit], sine[lit]), colour_basis(cosine[lit])))
        measures.append((np.log(slope), reddened(seen, edge_m), np.log(grey_slope)))
    exposures = block_diag(*[np.ones((len(one[0]), 1)) for one in bases])
    fitted, left = [], []
    for measure, basis in enumerate((0, 1, 0)):
        shapes = np.vstack([one[basis] for one in bases])
        design = np.hstack([shapes, exposures])
        value = np.concatenate([one[measure] for one in measures])
        found = np.linalg.lstsq(design, value)[0]
        fitted.append(found[: shapes.shape[1]])
        left.append(np.std(value - design @ found))
    return np.concatenate(fitted), np.array(left)


def own_airs() -> Iterator[Atmosphere]:
    rng = np.random.default_rng(SEED)
    for _ in range(OTHER_AIRS):
        yield other_air(rng).atmosphere
    for _ in range(RANDOM_AIRS):
        yield random_air(rng).atmosphere


def show(name: str, limbs: list[Limb]) -> None:
    rows = [coefficients(limb) for limb in limbs]
    found, left = (np.array(part) for part in zip(*rows, strict=True))
    covariance = np.cov(found.T) + np.diag(BEYOND**2)
    worst = " ".join(f"{value:.3f}" for value in left.max(axis=0))
    print(f"# {len(rows)} airs; rms left of the worst air's three fits: {worst}")
    print(f"{name} = (")
    print(f'    "{" ".join(f"{value:.3g}" for value in found.mean(axis=0).round(3))}",')
    print('    """')
    for k, row in enumerate(1e5 * covariance):
        print("    " + " ".join(f"{value:.0f}" for value in row[: k + 1]))
    print('    """,\n)')


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="with the tables of the drawn airs")
    folder = parser.parse_args().folder
    chosen = [tabled(air) for air in TUNED]
    show("_SCATTERED_OFTEN", chosen + [tabled(air, folder) for air in DRAWN])
    show("_SCATTERED_ONCE", [rendered(air) for air in own_airs()])


if __name__ == "__main__":
    main()
