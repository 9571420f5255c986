"""Slews of a whole body: solved, beside another transcription's least time, and around cones.

Random envelopes of 0.5 to 4 deg/s, turns of 5 to 120 deg between rests and between ground points
that are tracked, limits of magnitudes and by axis: the tests' families.

    python bench/body_slew.py [--slews 6] [--beside 2] [--cones 6] [--seed 2024]

--slews, --beside: of each family, and how many of these are held against the reference.
"""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "properties"))
sys.path.append(str(Path(__file__).parents[1] / "tests" / "oracles"))
from body_slew_cases import FAMILIES, draw, draw_cone
from body_slew_reference import reference_least_s

from planner.base.commands import ROWS_PER_S
from planner.base.errors import InfeasibleSlew
from planner.motion.attitude.bounds import least_s
from planner.motion.attitude.problem import BodySlewProblem
from planner.motion.attitude.slew import BodySlew, solve_attitude_slew

LONGER = 1.02  # of the reference's time, the aim
SMOOTH_LONGER = 1.2  # times as long as the quickest a smooth slew is asked for
CONE_FACTORS = (1.3, 1.8, 2.5)  # times as long as without the cone, until one is found


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


def print_cones(rng: np.random.Generator, count: int) -> None:
    found, cpu, tried = 0, [], 0
    while tried < count:
        problem = draw(rng, FAMILIES[tried % len(FAMILIES)])
        free, _ = solved(replace(problem, objective="minimum_time"))
        if free is None or problem.last_arrival_row < CONE_FACTORS[0] * len(free.motion.position):
            continue
        rows = problem.last_arrival_row + 1
        cone = draw_cone(rng, free.motion.position, rows)
        if cone is None:
            continue
        tried += 1
        for factor in CONE_FACTORS:
            row = min(round(factor * free.duration_s * ROWS_PER_S), problem.last_arrival_row)
            around, cpu_s = solved(replace(problem, cones=(cone,)).arriving_at(row))
            if around is not None:
                found += 1
                cpu.append(cpu_s)
                break
    print(f"around cones: {found} of {tried} smooth slews found, {np.median(cpu):.2f} s each")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slews", type=int, default=6)
    parser.add_argument("--beside", type=int, default=2)
    parser.add_argument("--cones", type=int, default=6)
    parser.add_argument("--seed", type=int, default=2024)
    asked = parser.parse_args()
    results = [
        print_family(family, np.random.default_rng(asked.seed), asked.slews, asked.beside)
        for family in FAMILIES
    ]
    print_cones(np.random.default_rng(asked.seed), asked.cones)
    unsolved, longest = sum(failed for failed, _ in results), max(ratio for _, ratio in results)
    if unsolved or longest > LONGER:
        sys.exit(f"{unsolved} slews unsolved, {longest:.4f} of the reference's time at most")
