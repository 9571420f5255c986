"""Random imaging sessions: whether each is planned or refused for a reason, and at what work."""

import dataclasses
import math
import time

import numpy as np
from imaging_cases import EPOCH, area, line, session_request
from scipy.spatial.transform import Rotation

from planner.base.errors import Refusal
from planner.spacecraft.plan import ImagingPlan, plan_imaging
from planner.spacecraft.requests import (
    CorridorRequest,
    GeoLineString,
    ImagingPlanRequest,
    Request,
    SpacecraftSettings,
    StereoRequest,
    StripRequest,
)
from planner.world.orbits import StateVectorOrbit

SEED, SESSIONS = 4200, 40


def random_orbit(random: np.random.Generator) -> StateVectorOrbit:
    """Circular, 300 to 800 km high, inclined by 28 to 98 deg."""
    r_km = 6378.137 + random.uniform(300.0, 800.0)
    turns_deg = [random.uniform(0.0, 360.0), random.uniform(28.0, 98.0), random.uniform(0.0, 360.0)]
    turned = Rotation.from_euler("ZXZ", turns_deg, degrees=True)
    return StateVectorOrbit(
        frame="GCRF",
        epoch=EPOCH,
        position_km=tuple(turned.apply([r_km, 0.0, 0.0]).tolist()),
        velocity_km_s=tuple(turned.apply([0.0, math.sqrt(398600.4418 / r_km), 0.0]).tolist()),
    )


def random_session(seed: int) -> ImagingPlanRequest:
    """4 to 8 requests of all modes in 10 to 20 minutes, up to 24 N m s in the gyros."""
    random = np.random.default_rng(seed)
    orbit, seconds = random_orbit(random), float(random.integers(600, 1200))
    momentum_n_m_s = random.uniform(-1.0, 1.0, 3) * random.uniform(0.0, 24.0) / math.sqrt(3.0)

    def one(number: int) -> Request:
        t_s, across_km = random.uniform(60.0, seconds - 60.0), random.uniform(-150.0, 150.0)
        mode = random.choice(["strip", "stereo", "area", "corridor"])
        if mode == "area":
            made: Request = area(orbit, t_s, f"area {number}", across_km)
        else:
            half_km = random.uniform(15.0, 40.0)
            azimuth_deg = random.uniform(-60.0, 60.0) if mode == "corridor" else 0.0
            geometry = GeoLineString(coordinates=line(orbit, t_s, half_km, across_km, azimuth_deg))
            kind = {"strip": StripRequest, "stereo": StereoRequest, "corridor": CorridorRequest}
            made = kind[mode](name=f"{mode} {number}", geometry=geometry)
        return dataclasses.replace(made, priority=float(random.uniform(1.0, 5.0)))

    return session_request(
        orbit,
        seconds,
        tuple(one(number) for number in range(int(random.integers(4, 9)))),
        objective=str(random.choice(["smooth", "minimum_time"])),
        settings=SpacecraftSettings(
            reversible_scan=bool(random.integers(2)),
            momentum_n_m_s=tuple(momentum_n_m_s.tolist()),
        ),
        simulation_runs=2,
    )


def planned(request: ImagingPlanRequest) -> ImagingPlan | Refusal:
    try:
        return plan_imaging(request)
    except Refusal as why:
        return why


def bench_random(first: int = SEED, count: int = SESSIONS) -> None:
    print(f"{count} random sessions of all modes, 300 to 800 km:")
    plan_imaging(random_session(first + 6))  # what is made once a process
    worst_s, ours, lost, images, asked = 0.0, 0, 0, 0, 0
    for seed in range(first, first + count):
        request = random_session(seed)
        begun_s = time.process_time()
        found = planned(request)
        took_s = time.process_time() - begun_s
        worst_s = max(worst_s, took_s)
        asked += len(request.requests)
        height_km = np.linalg.norm(request.orbit.position_km) - 6378.137
        told = f"  {seed} {height_km:.0f} km {request.objective}, {took_s:.1f} s: "
        if isinstance(found, ImagingPlan):
            images += len({window.request for window in found.table.windows})
            left_out = "".join(f"\n      {one.name}: {one.reason}" for one in found.left_out)
            print(f"{told}{len(set(found.choice.requests))} of {len(request.requests)}{left_out}")
            continue
        ours += found.blame == "ours"
        alone = [
            one.name
            for one in request.requests
            if isinstance(planned(dataclasses.replace(request, requests=(one,))), ImagingPlan)
        ]
        lost += bool(alone)
        print(f"{told}{type(found).__name__}: {found}; alone: {', '.join(alone) or 'none'}")
    print(
        f"  {images} of {asked} requests imaged; {ours} failures of ours, {lost} sessions refused "
        f"of which a request alone is planned; worst {worst_s:.1f} s"
    )


if __name__ == "__main__":
    import sys

    bench_random(*map(int, sys.argv[1:]))
