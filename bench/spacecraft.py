"""Figures of the CMG spacecraft against what is promised; run it with python.

python bench/spacecraft.py            everything
python bench/spacecraft.py timeline   some parts: timeline, settle, areas, slews, choice, random,
                                      ground

Times are CPU times: others at work on the machine don't count.
"""

import dataclasses
import json
import math
import sys
import time
from datetime import datetime, timedelta

import numpy as np
from imaging_cases import DATA, EPOCH, area, line, session_request, sun_synchronous
from scipy.spatial.transform import Rotation
from spacecraft_flight import bench_areas, bench_settle, bench_timeline

from planner.base.errors import Refusal
from planner.spacecraft.imaging.candidates import candidates
from planner.spacecraft.imaging.choose import choose
from planner.spacecraft.imaging.session import make_session
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
from planner.spacecraft.slews.eigenaxis import eigenaxis_slew
from planner.spacecraft.slews.slew_choice import quickest_slew, smooth_slew
from planner.spacecraft.slews.slew_ocp import solve_slew
from planner.spacecraft.slews.slew_problem import AttitudeSlewProblem, EndState
from planner.spacecraft.vehicle.definition import AGILE_CMG, SlewLimits
from planner.world.orbits import StateVectorOrbit, TleOrbit

SEED, SESSIONS = 4200, 40


def bench_ground() -> None:
    print("Strip, stereo, corridors (the judge's own ground points; Skyfield's: in the tests):")
    orbit = sun_synchronous(640.0)

    def along(t_s: float, across_km: float, azimuth_deg: float = 0.0) -> GeoLineString:
        return GeoLineString(coordinates=line(orbit, t_s, 30.0, across_km, azimuth_deg))

    requests = (
        StripRequest(name="strip", geometry=along(90.0, 100.0)),
        StereoRequest(name="stereo", geometry=along(230.0, -40.0)),
        CorridorRequest(name="corridor 45 deg", geometry=along(360.0, 0.0, 45.0)),
        CorridorRequest(name="corridor 90 deg", geometry=along(470.0, 50.0, 90.0)),
    )
    begun = time.process_time()
    plan = plan_imaging(session_request(orbit, 600.0, requests))
    print(f"  planned, judged and flown 4 times in {time.process_time() - begun:.1f} s")
    rates = np.rad2deg(np.linalg.norm(plan.table.omega_body_rad_s, axis=1))
    for seen, flown in zip(plan.verification.windows, plan.stabilisation.windows, strict=True):
        print(
            f"  {seen.request} look {seen.look}: miss {seen.miss_m:.2e} m, speed off "
            f"{100 * seen.speed_spread:.4f} %, drift {math.degrees(seen.drift_rad):.1e} deg, along "
            f"{seen.along_deg:.1f} deg, body rate {rates[seen.first_row]:.2f} deg/s; flown: "
            f"{np.rad2deg(flown.rate_error_rad_s).max():.5f} deg/s, pointing "
            f"{math.degrees(flown.pointing_error_rad) * 3600:.1f} arcsec, smear "
            f"{flown.smear_px:.3f} px, settled {flown.spare_s:.1f} s before, gimbal margin "
            f"{flown.gimbal_margin:.2f}"
        )


def random_problem(
    random: np.random.Generator, moving: bool, per_axis: bool
) -> AttitudeSlewProblem:
    def rates(size_deg: float) -> np.ndarray:
        return np.deg2rad(random.uniform(-size_deg, size_deg, 3)) * moving

    axis = random.standard_normal(3)
    axis *= math.radians(random.uniform(2.0, 60.0)) / np.linalg.norm(axis)
    begin = Rotation.random(rng=random)
    limits = SlewLimits()
    if not per_axis:
        limits = SlewLimits(
            rate_axis_rad_s=math.radians(3.5), rate_rad_s=math.radians(random.uniform(1.5, 3.5))
        )
    return AttitudeSlewProblem(
        start=EndState(
            q_body_from_eci=begin.inv(),
            omega_body_rad_s=rates(0.5),
            alpha_body_rad_s2=rates(0.01),
        ),
        end=EndState(
            q_body_from_eci=(begin * Rotation.from_rotvec(axis)).inv(),
            omega_body_rad_s=rates(0.5),
            alpha_body_rad_s2=rates(0.01),
        ),
        momentum_eci_n_m_s=random.uniform(-5.0, 5.0, 3),
        inertia_kg_m2=np.array(AGILE_CMG.inertia_kg_m2),
        limits=limits,
    )


def bench_slews() -> None:
    print("Turn OCP, 50 random cases in each of four families, both objectives:")
    warm = random_problem(np.random.default_rng(9), False, True)
    quickest_slew(warm)
    smooth_slew(warm, 40.0)
    all_ms = []
    for moving in (False, True):
        for per_axis in (False, True):
            random = np.random.default_rng(2024)
            ratios, quick_ms, smooth_ms = [], [], []
            solved, fallback, smoothed = 0, 0, 0
            for _ in range(50):
                problem = random_problem(random, moving, per_axis)
                baseline = eigenaxis_slew(problem)
                begun = time.process_time()
                quick = quickest_slew(problem)
                quick_ms.append(1e3 * (time.process_time() - begun))
                ratios.append(quick.duration_s / baseline.duration_s)
                solved += quick.method == "ocp"
                fallback += quick.method == "eigenaxis"
                seconds = 1.2 * quick.duration_s
                begun = time.process_time()
                found = solve_slew(problem, eigenaxis_slew(problem, seconds), "smooth", seconds)
                smooth_ms.append(1e3 * (time.process_time() - begun))
                smoothed += found is not None
            all_ms += smooth_ms + quick_ms
            print(
                f"  {'moving' if moving else 'rest'} ends, "
                f"{'per-axis' if per_axis else '|omega|'} limits: quickest {solved} by OCP, "
                f"{fallback} by eigenaxis fallback, of eigenaxis's time min {min(ratios):.3f} "
                f"median {np.median(ratios):.3f} max {max(ratios):.3f}, median "
                f"{np.median(quick_ms):.0f} ms; smooth {smoothed}/50, median "
                f"{np.median(smooth_ms):.0f} ms"
            )
    print(f"  median over all {len(all_ms)} solves {np.median(all_ms):.0f} ms")


def eos_requests(case: dict, every: int) -> list[StripRequest | StereoRequest]:
    """A strip of 40 km along the meridian through each task; some (0: none) in stereo."""
    requests = []
    for number, task in enumerate(case["tasks"]):
        latitude, longitude = task["latitude_deg"], task["longitude_deg"]
        reach = 20.0 / 111.2
        geometry = GeoLineString(
            coordinates=((longitude, latitude - reach), (longitude, latitude + reach))
        )
        mode = StereoRequest if every and number % every == 5 else StripRequest
        requests.append(mode(name=task["name"], priority=task["weight"], geometry=geometry))
    return requests


def bench_choice() -> None:
    print("Choosing among 100 requests in 20 minutes (tasks of the AEOSSP standard set):")
    cases = json.loads((DATA / "eos_tasks.json").read_text(encoding="utf-8"))["cases"]
    for case, every in [*((case, 0) for case in cases), (cases[2], 20), (cases[3], 20)]:
        orbit = TleOrbit(line1=case["line1"], line2=case["line2"])
        start = datetime.fromisoformat(case["start"].replace("Z", "+00:00"))
        request = ImagingPlanRequest(
            orbit=orbit,
            start=start,
            stop=start + timedelta(seconds=case["duration_s"]),
            requests=tuple(eos_requests(case, every)),
        )
        session = make_session(request)
        options, refused = [], 0
        begun = time.process_time()
        for number, one in enumerate(request.requests):
            try:
                options += candidates(one, number, session)
            except Refusal:
                refused += 1
        geometry_s = time.process_time() - begun
        priorities = [one.priority for one in request.requests]
        choose(options[:5], priorities, session.slew_time, {})
        begun = time.process_time()
        choice = choose(options, priorities, session.slew_time, {})
        chosen_s = time.process_time() - begun
        print(
            f"  {case['case']} {case['satellite']}{' with stereo' if every else ''}: "
            f"{100 - refused} requests in reach, "
            f"{len(options)} candidates in {geometry_s:.1f} s; worth {choice.value:.1f}, "
            f"{100 * (choice.value / choice.greedy_value - 1):.0f} % above greedy, "
            f"{choice.rounds} rounds, {chosen_s:.2f} s"
        )


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


def bench_random() -> None:
    print(f"{SESSIONS} random sessions of all modes, 300 to 800 km:")
    plan_imaging(random_session(SEED + 6))  # what is made once a process
    worst_s, ours, lost, images, asked = 0.0, 0, 0, 0, 0
    for seed in range(SEED, SEED + SESSIONS):
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


PARTS = {
    "ground": bench_ground,
    "timeline": bench_timeline,
    "settle": bench_settle,
    "areas": bench_areas,
    "slews": bench_slews,
    "choice": bench_choice,
    "random": bench_random,
}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
