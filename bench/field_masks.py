"""Are slews that would look through a mask led around it, always, and as well as around a cone?

Random slews (1.2 to 3 times the least time) whose straight path enters panels of 4 to 9 corners,
booms 0.1 to 4 deg wide, three panels at once, or panels of 10 to 29 corners and up to 80 deg.  What
is flown from rows is held every millisecond against winding numbers.  Then polygons of 40 corners
beside the cone around each.

    python bench/field_masks.py [--cases 80] [--rings 24] [--seed 101]
"""

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.extend(str(Path(__file__).parents[1] / "tests" / folder) for folder in (".", "properties"))
from keep_out_cases import hermite
from mask_cases import MaskCase, cone_around, draw_mask_cases, ring
from mask_shapes import boom, star

from planner.detour.detour import avoid_cones
from planner.errors import InfeasibleSlew

KINDS = {
    "panels": (
        1,
        lambda rng, at: star(rng, at, math.radians(rng.uniform(8, 45)), rng.integers(4, 10)),
    ),
    "booms": (
        1,
        lambda rng, at: boom(
            rng, at, math.radians(rng.uniform(10, 50)), math.radians(rng.uniform(0.05, 2))
        ),
    ),
    "three panels": (
        3,
        lambda rng, at: star(rng, at, math.radians(rng.uniform(8, 45)), rng.integers(4, 10)),
    ),
    "large panels": (
        1,
        lambda rng, at: star(rng, at, math.radians(rng.uniform(30, 80)), rng.integers(10, 30)),
    ),
}


def outcome(case: MaskCase) -> str:
    """What became of it."""
    try:
        solution = avoid_cones(case.straight)
    except InfeasibleSlew as refusal:
        return "proven impossible" if "no motion" in refusal.detail else "given up"
    _, angle_rad, _, _ = hermite(solution, 1e-3)
    return "ENTERED" if case.is_entered(angle_rad) else "led around"


def compare_with_cones(seed: int, count: int) -> Iterator[tuple[float, list[float]]]:
    """Cost beside the cone's, and both times."""
    for case in draw_mask_cases(seed, count, ring):
        costs, walls_s = [], []
        for straight in (case.straight, cone_around(case)):
            begins_s = time.perf_counter()
            try:
                costs.append(avoid_cones(straight).jerk_squared_integral)
            except InfeasibleSlew:
                costs.append(math.nan)
            walls_s.append(time.perf_counter() - begins_s)
        yield costs[0] / costs[1], walls_s


def main() -> None:
    """As the file says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=80)
    parser.add_argument("--rings", type=int, default=24)
    parser.add_argument("--seed", type=int, default=101)
    asked = parser.parse_args()
    for kind, (masks, corners) in KINDS.items():
        begins_s = time.perf_counter()
        counted = Counter(map(outcome, draw_mask_cases(asked.seed, asked.cases, corners, masks)))
        each_s = (time.perf_counter() - begins_s) / asked.cases
        print(f"{kind}: {dict(counted)}, {each_s:.1f} s each", flush=True)
    ratios, walls_s = zip(*compare_with_cones(asked.seed, asked.rings), strict=True)
    known = np.array(ratios)[~np.isnan(ratios)]
    mask_s, cone_s = np.median(walls_s, axis=0)
    print(
        f"beside the cone: {len(known)} slews cost {known.min():.4f} to {known.max():.4f} of it, "
        f"{mask_s:.2f} s and {cone_s:.2f} s in the median"
    )


if __name__ == "__main__":
    main()
