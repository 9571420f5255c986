"""Are slews that would look into a forbidden cone led around it, well, and quickly?

200 random slews (1.2 to 3 times the least time) whose straight path enters a cone of 10 to
45 deg turning with the carrier.  Each is solved or proven impossible; what is flown is held
against cone and limits on a 10 ms grid by other code than the planner's; its cost is held
against the best of many restarts from random guesses.

    python bench/keep_out.py [--count 200] [--restarts 12]
"""

import argparse
import contextlib
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "properties"))
from keep_out_cases import LIMITS, Case, away_rad, draw_cases, hermite

from planner.errors import InfeasibleSlew
from planner.slew import SlewSolution
from planner.slew.backends.ipopt import graded_ocp
from planner.slew.detour import SPANS, cleared
from planner.slew.detour_search import DetourSearch


def best_of_restarts(case: Case, count: int, rng: np.random.Generator) -> float:
    """The least cost from guesses that wander through the angles at random; infinite: none."""
    spline = graded_ocp(SPANS)
    tau = spline.greville
    costs = []
    for _ in range(count):
        waves = sum(
            np.outer(rng.normal(size=2) * 1.5 / k, np.sin(np.pi * k * tau)) for k in (1, 2, 3)
        )
        search = DetourSearch(case.straight, case.problem.keep_out, spline)
        costs += [found.cost for found in search.near((waves,))]
    return min(costs)


def flown_within(case: Case, solution: SlewSolution) -> tuple[float, float]:
    """Least distance outside the cone, and the greatest share of a limit, on a 10 ms grid."""
    t_s, angle, rows, rates = hermite(solution)
    outside = away_rad(case, t_s, angle).min() - case.half_angle_rad
    mean = np.diff(rows, axis=0) / 0.2
    accelerations = [
        (6.0 * mean - 4.0 * rates[:-1] - 2.0 * rates[1:]) / 0.2,
        (2.0 * rates[:-1] + 4.0 * rates[1:] - 6.0 * mean) / 0.2,
    ]
    shares = [
        np.abs(angle).max() / LIMITS.angle_max_rad,
        np.abs(np.diff(angle, axis=0)).max() / 0.01 / LIMITS.rate_max_rad_s,
        np.abs(accelerations).max() / LIMITS.acceleration_max_rad_s2,
    ]
    return outside, max(shares)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--restarts", type=int, default=12)
    asked = parser.parse_args()
    rng = np.random.default_rng(1)
    solved_ms, refused_ms, outside_rad, shares, ratios = [], [], [], [], []
    proven = undecided = found_by_restart = 0
    cases = draw_cases(7, asked.count)
    for case in draw_cases(8, 3):  # CasADi loads and the solver is set up once per process
        with contextlib.suppress(InfeasibleSlew):
            cleared(case.straight)
    for case in cases:
        began_s = time.process_time()
        try:
            solution = cleared(case.straight)
        except InfeasibleSlew as refusal:
            refused_ms.append(1e3 * (time.process_time() - began_s))
            is_proven = refusal.detail.startswith("no motion")
            proven += is_proven
            undecided += not is_proven
            found_by_restart += np.isfinite(best_of_restarts(case, asked.restarts, rng))
            continue
        solved_ms.append(1e3 * (time.process_time() - began_s))
        outside, share = flown_within(case, solution)
        outside_rad.append(outside)
        shares.append(share)
        ratios.append(solution.jerk_squared_integral / best_of_restarts(case, asked.restarts, rng))
    ratios = np.array(ratios)
    print(
        f"{asked.count} slews: {len(solved_ms)} led around, {proven} proven impossible, "
        f"{undecided} undecided (restarts solve {found_by_restart} of the last two)"
    )
    print(
        f"CPU per solved slew: median {np.median(solved_ms):.0f} ms (target 60), "
        f"95 % {np.quantile(solved_ms, 0.95):.0f} ms; per refusal "
        f"{np.median(refused_ms) if refused_ms else 0:.0f} ms"
    )
    print(
        f"flown, 10 ms grid: inside the cone {np.sum(np.array(outside_rad) < 0.0)}, least "
        f"distance outside {np.degrees(min(outside_rad)):.4f} deg; "
        f"greatest share of a limit {max(shares):.6f}"
    )
    print(
        f"cost against the best of {asked.restarts} restarts: median {np.median(ratios):.4f}, "
        f"within 1 % {np.mean(ratios <= 1.01):.1%}, worst {ratios.max():.3f}"
    )


if __name__ == "__main__":
    main()
