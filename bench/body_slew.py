"""Slews of a whole body: solved, beside another transcription's least time, and in plans.

Random envelopes of 0.5 to 4 deg/s, turns of 5 to 120 deg between rests and between ground points
that are tracked, limits of magnitudes and by axis: the tests' families.  Then plans of one or two
of the tutorial's cities by random platforms: none may fail by our fault.

    python bench/body_slew.py [--slews 6] [--beside 2] [--plans 20] [--seed 2024]

--slews, --beside: of each family, and how many of these are held against the reference.
"""

import argparse
import json
import random
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "properties"))
sys.path.append(str(Path(__file__).parents[1] / "tests" / "oracles"))
from body_slew_cases import FAMILIES, draw
from body_slew_reference import reference_least_s

from app.requests.plan import read_plan_request
from planner.base.commands import ROWS_PER_S
from planner.base.errors import InfeasibleSlew, Refusal
from planner.motion.attitude.bounds import least_s
from planner.motion.attitude.problem import BodySlewProblem
from planner.motion.attitude.slew import BodySlew, solve_attitude_slew
from planner.planning.sessions.pipeline import make_plan

LONGER = 1.02  # of the reference's time, the aim
SMOOTH_LONGER = 1.2  # times as long as the quickest a smooth slew is asked for
THREE_CITIES = Path(__file__).parents[1] / "examples" / "three_sessions.json"
LIMIT_S = 10.0  # of a processor: what a plan or refusal may take


def solved(problem: BodySlewProblem) -> tuple[BodySlew | None, float]:
    """The slew or None, and the processor time it took, s."""
    begun_s = time.process_time()
    try:
        slew = solve_attitude_slew(problem)
    except InfeasibleSlew:
        slew = None
    return slew, time.process_time() - begun_s


def print_family(
    family: str, rng: np.random.Generator, slews: int, beside: int
) -> tuple[int, float]:
    """How many weren't solved, and the most of the reference's time."""
    quick_s, smooth_s, late, bounds, ratios, failed = [], [], [], [], [], 0
    for number in range(slews):
        problem = replace(draw(rng, family), objective="minimum_time")
        quick, cpu_s = solved(problem)
        if quick is None:
            failed += 1
            continue
        quick_s.append(cpu_s)
        late.append(quick.duration_s / quick.quickest_s)
        bounds.append(least_s(problem) / quick.duration_s)
        row = min(round(SMOOTH_LONGER * quick.duration_s * ROWS_PER_S), problem.last_arrival_row)
        smooth, cpu_s = solved(replace(problem, objective="smooth").arriving_at(row))
        failed += smooth is None
        smooth_s.append(cpu_s)
        if number < beside:
            found_s = reference_least_s(problem, quick)
            if found_s is not None:
                ratios.append(quick.quickest_s / found_s)
    print(
        f"{family:19} {slews:3} slews of both objectives, {failed} unsolved; quickest "
        f"{np.median(quick_s):.2f} s (most {max(quick_s):.2f}), "
        f"smooth {np.median(smooth_s):.3f} s; "
        f"on rows {np.median(late):.4f} of the least time (most {max(late):.4f}); bound "
        f"{np.median(bounds):.2f}"
        + (f"; beside the reference {max(ratios):.4f} at most of {len(ratios)}" if ratios else "")
    )
    return failed, max(ratios, default=1.0)


def random_request(rng: random.Random) -> dict[str, Any]:
    """One or two of the cities, by a random body."""
    asked = json.loads(THREE_CITIES.read_text())
    del asked["attitude"]
    kind = rng.choice(["magnitude", "axis"])

    def limit(most: float) -> float | list[float]:
        return most if kind == "magnitude" else [most * rng.uniform(0.5, 1.0) for _ in range(3)]

    rate = rng.uniform(0.5, 4.0)
    acceleration = rate * rng.uniform(0.05, 0.5)
    exclusion = {
        "name": "keep away",
        "direction_body": [rng.uniform(-1.0, 1.0) for _ in range(3)],
        "away_from": rng.choice(["sun", "moon", "limb", "glint"]),
        "min_deg": rng.uniform(2.0, 25.0),
        "when": rng.choice(["always", "imaging"]),
    }
    platform = {
        "kind": "body",
        "name": "drawn",
        "agility": {
            "limits": kind,
            "rate_max_deg_s": limit(rate),
            "acceleration_max_deg_s2": limit(acceleration),
            "jerk_max_deg_s3": limit(acceleration * rng.uniform(0.3, 2.0)),
            "settle_s": rng.choice([0.0, 2.0, 5.0]),
        },
        "off_nadir_max_deg": rng.uniform(40.0, 70.0),
        "camera": {"type": "frame", "field_of_view_deg": [2.0, 1.5]},
        "idle": rng.choice(
            [{"law": "nadir"}, {"law": "nadir"}, {"law": "sun", "direction_body": [0.0, 0.0, -1.0]}]
        ),
        "exclusions": rng.choice([[], [exclusion]]),
        "roll": {
            "rule": rng.choice(["nearest", "nearest", "lines_across_motion", "lines_across_track"])
        },
    }
    sessions = rng.sample(asked["sessions"], rng.choice([1, 2]))
    return asked | {
        "platform": platform,
        "initial_state": {"epoch": asked["initial_state"]["epoch"]},
        "sessions": sorted(sessions, key=lambda session: str(session["start"])),
        "slew": {"objective": rng.choice(["smooth", "minimum_time"])},
        "final_state": rng.choice([None, "idle"]),
        "on_conflict": rng.choice(["refuse", "shorten_later", "least_loss"]),
    }


def print_plans(seed: int, count: int) -> int:
    """How many failed by our fault."""
    kinds: Counter[str] = Counter()
    cpu_s = []
    for number in range(seed, seed + count):
        asked = json.dumps(random_request(random.Random(number))).encode()
        begun_s = time.process_time()
        try:
            make_plan(read_plan_request(asked))
            kind = "planned"
        except Refusal as refusal:
            kind = type(refusal).__name__
            if refusal.blame == "ours":
                print(f"seed {number}: {refusal}")
                kind = "failed"
        kinds[kind] += 1
        cpu_s.append(time.process_time() - begun_s)
        if cpu_s[-1] > LIMIT_S:
            print(f"seed {number}: {kind} after {cpu_s[-1]:.1f} s of a processor")
    told = ", ".join(f"{many} {kind}" for kind, many in kinds.most_common())
    if count:
        print(f"{count} plans: {told}; median {np.median(cpu_s):.2f} s, most {max(cpu_s):.2f}")
    return kinds["failed"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slews", type=int, default=6)
    parser.add_argument("--beside", type=int, default=2)
    parser.add_argument("--plans", type=int, default=20)
    parser.add_argument("--seed", type=int, default=2024)
    asked = parser.parse_args()
    results = [
        print_family(family, np.random.default_rng(asked.seed), asked.slews, asked.beside)
        for family in FAMILIES
        if asked.slews
    ]
    unsolved = sum(failed for failed, _ in results)
    longest = max((ratio for _, ratio in results), default=1.0)
    failed_plans = print_plans(asked.seed, asked.plans)
    if unsolved or longest > LONGER or failed_plans:
        sys.exit(
            f"{unsolved} slews unsolved, {longest:.4f} of the reference's time at most, "
            f"{failed_plans} plans failed"
        )
