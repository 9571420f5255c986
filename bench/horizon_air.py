"""Errors of the horizon under airs of another model; prints the table of docs/horizon.md.

    OMP_NUM_THREADS=1 python bench/horizon_air.py [--pairs N] [--seed N] [--airs NAME ... [--each]]
        [--conditions NAME ...]
Frames by bench/limb_frames.py.  On the airs of TUNED the estimator was tuned; those of SHOWN were
drawn by chance and looked at afterwards.  What they hold:
tests/data/horizon/README.md.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import cv2
import numpy as np
from horizon import Row
from horizon_cases import Case, camera
from limb_frames import A_M, E2, Electronics, Floats, View, Weather, expose, geodetic_up, sun_itrf
from limb_frames import limb_table as table_of
from scipy.spatial.transform import Rotation

from estimator.camera import HorizonCamera
from estimator.request import Body, HorizonRequest, Position, PredictedAttitude
from estimator.surroundings import Surroundings

cv2.setNumThreads(1)
TUNED = (
    *("standard", "thin_7km", "dense_8km", "dusty", "clean_sea", "exponential", "dense_7km"),
    *("thin_8km", "tropical", "arctic_winter", "desert", "after_eruption"),
)
SHOWN = tuple(f"drawn_{k}" for k in range(1, 7))
SEED = 1


@dataclass(frozen=True)
class Condition:
    """sun_deg: its elevation at the craft.  width_px: of two cameras' frames, 60 deg wide.

    ideal: no clouds, no noise, nothing overexposed, and a limb as smooth as the air itself.
    """

    sun_deg: tuple[float, float] = (35.0, 90.0)
    altitude_m: tuple[float, float] = (350e3, 700e3)
    width_px: int = 640
    noisy: bool = False
    ideal: bool = False


CONDITIONS = {
    "day": Condition(),
    "day, ideal": Condition(ideal=True),
    "day, 1200 km, 1280 px": Condition(altitude_m=(1000e3, 1400e3), width_px=1280),
    "day, noisy, 320 px": Condition(width_px=320, noisy=True),
    "Sun 20-35 deg": Condition(sun_deg=(20.0, 35.0)),
    "Sun 3-20 deg": Condition(sun_deg=(3.0, 20.0)),
    "Sun down to -10 deg": Condition(sun_deg=(-10.0, 3.0)),
}


def cases(air: str, condition: Condition, count: int, seed: int) -> Iterator[tuple[Case, Case]]:
    """The same pairs of frames in colour and in grey."""
    for k in range(count):
        rng = np.random.default_rng([seed, k, *air.encode()])
        yield _case(air, condition, rng)


def _case(air: str, condition: Condition, rng: np.random.Generator) -> tuple[Case, Case]:
    size = condition.width_px, condition.width_px * 3 // 4
    altitude_m = rng.uniform(*condition.altitude_m)
    # Both see the limb some way above the middle.
    down_deg = np.rad2deg(np.arccos(A_M / (A_M + altitude_m))) + rng.uniform(-4.0, 8.0)
    cameras = tuple(
        camera(name, azimuth_deg, *size, down_deg=down_deg)
        for name, azimuth_deg in (("ahead", 0.0), ("right", 90.0))
    )
    while True:
        epoch = datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=rng.uniform(0.0, 3.15e7))
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        r_m = up * (A_M * (1.0 - 0.5 * E2 * up[2] ** 2) + altitude_m)
        sun = sun_itrf(epoch)
        if condition.sun_deg[0] <= np.rad2deg(np.arcsin(sun @ up)) <= condition.sun_deg[1]:
            break
    heading = Rotation.from_rotvec(rng.uniform(0.0, 2.0 * np.pi) * np.array([0.0, 0.0, 1.0]))
    tilt = Rotation.from_rotvec(np.deg2rad(rng.uniform(-5.0, 5.0, 3)))
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east)
    level = Rotation.from_matrix(np.stack([east, np.cross(-up, east), -up]))
    body_from_itrf = tilt * heading * level
    albedo = table_of(air).albedo
    weather = Weather(
        cloud=float(np.clip((albedo - 0.05) / 0.5 + rng.uniform(-0.15, 0.15), 0.0, 1.0)),
        land=rng.uniform(0.0, 0.6),
        limb_m=rng.uniform(0.0, 800.0),
        limb_deg=rng.uniform(1.0, 6.0),
        seed=int(rng.integers(1 << 30)),
    )
    if condition.ideal:
        weather = replace(weather, cloud=-1.0, limb_m=0.0)
    view = View(r_m, body_from_itrf.as_matrix(), sun, air, weather)
    lights = [view.radiance(c) for c in cameras]
    electronics = Electronics(
        exposure=rng.uniform(0.5, 0.85),
        full_well_e=3e3 if condition.noisy else rng.uniform(8e3, 40e3),
        read_noise_e=20.0 if condition.noisy else 10.0,
        blur_px=rng.uniform(0.4, 0.9),
        bits=8 if rng.uniform() < 0.7 else 16,
    )
    if condition.ideal:
        # Over a dark sea the limb is the brightest there is: nothing of it is to be full.
        electronics = replace(electronics, full_well_e=1e9, read_noise_e=0.0, percentile=100.0)
    request = _request(epoch, r_m, cameras, body_from_itrf, rng)
    truth = body_from_itrf.apply(-up), body_from_itrf.apply(-geodetic_up(r_m[None])[0][0])
    colour = tuple(expose(light, electronics, rng) for light in lights)
    grey = tuple(expose(light.mean(axis=2), electronics, rng) for light in lights)
    return Case(colour, request, *truth), Case(grey, request, *truth)


def _request(
    epoch: datetime,
    r_m: Floats,
    cameras: tuple[HorizonCamera, ...],
    body_from_itrf: Rotation,
    rng: np.random.Generator,
) -> HorizonRequest:
    position = Position(frame="ITRF", position_km=tuple((r_m / 1e3).tolist()))
    off = Rotation.from_rotvec(np.deg2rad(0.5) * rng.normal(size=3))
    around = Surroundings(epoch, position, Body())
    predicted = off * body_from_itrf * Rotation.from_matrix(around.c_itrf_from_eci)
    return HorizonRequest(
        epoch=epoch,
        position=position,
        cameras=cameras,
        predicted=PredictedAttitude(
            q_body_from_eci_xyzw=tuple(predicted.as_quat().tolist()), sigma_deg=0.5
        ),
    )


def rows(airs: tuple[str, ...], condition: Condition, pairs: int, seed: int) -> list[Row]:
    """One per colour or grey, pair or one frame, prediction or none, over all airs."""
    found: dict[str, Row] = {}
    for air in airs:
        for both in cases(air, condition, pairs, seed):
            for colour, one in zip(("colour", "grey"), both, strict=True):
                first = replace(one.request, cameras=one.request.cameras[:1])
                for how, request in (
                    ("pair", one.request),
                    ("pair, no prediction", replace(one.request, predicted=None)),
                    ("one frame", first),
                ):
                    name = f"{colour}, {how}"
                    found.setdefault(name, Row(name, "")).add(one, request)
    return list(found.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=6, help="of each air and condition")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--airs", nargs="*", default=SHOWN)
    parser.add_argument("--each", action="store_true", help="each air by itself")
    parser.add_argument("--conditions", nargs="*", default=list(CONDITIONS))
    asked = parser.parse_args()
    print(f"{'':44s} rms deg        max deg             usable  NEES  mean >5 s  CPU")
    groups = [(air,) for air in asked.airs] if asked.each else [tuple(asked.airs)]
    for name in asked.conditions:
        for airs in groups:
            print(f"{name}; {', '.join(airs)}")
            for row in rows(airs, CONDITIONS[name], asked.pairs, asked.seed):
                row.show()


if __name__ == "__main__":
    main()
