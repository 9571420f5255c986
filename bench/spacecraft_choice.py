"""Quality of slews and choices: random slews, and 100 requests in 20 minutes."""

import json
import math
import time
from datetime import datetime, timedelta

import numpy as np
from imaging_cases import DATA
from scipy.spatial.transform import Rotation

from planner.base.errors import Refusal
from planner.spacecraft.imaging.candidates import candidates
from planner.spacecraft.imaging.choose import choose
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.requests import (
    GeoLineString,
    ImagingPlanRequest,
    StereoRequest,
    StripRequest,
)
from planner.spacecraft.slews.eigenaxis import eigenaxis_slew
from planner.spacecraft.slews.slew_choice import quickest_slew, smooth_slew
from planner.spacecraft.slews.slew_ocp import solve_slew
from planner.spacecraft.slews.slew_problem import AttitudeSlewProblem, EndState
from planner.spacecraft.vehicle.definition import AGILE_CMG, SlewLimits
from planner.world.orbits import TleOrbit


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
