"""Detours around forbidden cones: how many are found, at what cost and in what time.

200 random slews (1.2 to 3 times the least time) whose straight path enters a cone of 10 to
45 deg turning with the carrier.  Each is solved or proven impossible; what is flown is held
against cone and limits on a 10 ms grid by other code than the planner's; its cost is held
against the best of many restarts from random guesses.

    python bench/keep_out.py [--cases 200] [--restarts 12] [--seed 7]
"""

import argparse
import contextlib
import sys
import time
from pathlib import Path

import numpy as np

sys.path.extend(str(Path(__file__).parents[1] / "tests" / folder) for folder in (".", "properties"))
from keep_out_cases import LIMITS, Case, away_rad, draw_cases, hermite, row_accelerations

from planner.base.errors import InfeasibleSlew
from planner.motion.detour.detour import OPTIONS as DETOUR_OPTIONS
from planner.motion.detour.detour import avoid_cones
from planner.motion.detour.search import DetourSearch
from planner.motion.detour.spline_ocp import graded_ocp
from planner.motion.slew import SlewSolution

WITHIN = 1.01
REPORT_EVERY = 10


def best_of_restarts(case: Case, count: int, number: int) -> float:
    """The least cost from guesses that wander through the angles at random; infinite: none.

    number: of the case, by which guesses are drawn.
    """
    rng = np.random.default_rng([1, number])
    spline = graded_ocp(DETOUR_OPTIONS.spans)
    tau = spline.greville_tau
    costs = []
    for _ in range(count):
        waves = sum(
            np.outer(rng.normal(size=2) * 1.5 / k, np.sin(np.pi * k * tau)) for k in (1, 2, 3)
        )
        search = DetourSearch(case.straight, case.problem.keep_out, spline)
        costs += [found.cost for found in search.solve_near((waves,))]
    return min(costs, default=np.inf)


def flown_within(case: Case, solution: SlewSolution) -> tuple[float, float]:
    """Least distance outside the cone, and the greatest share of a limit, on a 10 ms grid."""
    t_s, angle, rows, rates = hermite(solution)
    outside = away_rad(case, t_s, angle).min() - case.half_angle_rad
    shares = [
        np.abs(angle).max() / LIMITS.angle_max_rad,
        np.abs(np.diff(angle, axis=0)).max() / 0.01 / LIMITS.rate_max_rad_s,
        np.abs(row_accelerations(rows, rates)).max() / LIMITS.acceleration_max_rad_s2,
    ]
    return outside, max(shares)


class Tally:
    """What was seen so far."""

    def __init__(self) -> None:
        self.solved_ms: list[float] = []
        self.refused_ms: list[float] = []
        self.outside_rad: list[float] = []
        self.shares: list[float] = []
        self.ratios: list[float] = []
        self.proven = self.undecided = self.found_by_restart = 0

    def add(self, number: int, case: Case, restarts: int) -> None:
        began_s = time.process_time()
        try:
            solution = avoid_cones(case.straight)
        except InfeasibleSlew as refusal:
            self.refused_ms.append(1e3 * (time.process_time() - began_s))
            is_proven = refusal.detail.startswith("no motion")
            self.proven += is_proven
            self.undecided += not is_proven
            self.found_by_restart += np.isfinite(best_of_restarts(case, restarts, number))
            return
        self.solved_ms.append(1e3 * (time.process_time() - began_s))
        outside, share = flown_within(case, solution)
        self.outside_rad.append(outside)
        self.shares.append(share)
        best = best_of_restarts(case, restarts, number)
        self.ratios.append(solution.jerk_squared_integral / best)
        if self.ratios[-1] > WITHIN:
            print(f"  slew {number}: cost {self.ratios[-1]:.4f} of the best restart's", flush=True)

    def report(self) -> None:
        ratios = np.array(self.ratios)
        print(
            f"{len(self.solved_ms) + len(self.refused_ms)} slews: {len(self.solved_ms)} led "
            f"around, {self.proven} proven impossible, {self.undecided} undecided (restarts solve "
            f"{self.found_by_restart} of the last two)\n"
            f"CPU per solved slew: median {np.median(self.solved_ms):.0f} ms (target 60), "
            f"95 % {np.quantile(self.solved_ms, 0.95):.0f} ms; per refusal "
            f"{np.median(self.refused_ms) if self.refused_ms else 0:.0f} ms\n"
            f"flown, 10 ms grid: inside the cone {np.sum(np.array(self.outside_rad) < 0.0)}, least "
            f"distance outside {np.degrees(min(self.outside_rad)):.4f} deg; "
            f"greatest share of a limit {max(self.shares):.6f}\n"
            f"cost against the best restart: median {np.median(ratios):.4f}, "
            f"within 1 % {np.mean(ratios <= WITHIN):.1%}, worst {ratios.max():.3f}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--restarts", type=int, default=12)
    parser.add_argument("--seed", type=int, default=7, help="of the cases drawn")
    asked = parser.parse_args()
    for case in draw_cases(8, 3):  # CasADi loads and the solver is set up once per process
        with contextlib.suppress(InfeasibleSlew):
            avoid_cones(case.straight)
    tally = Tally()
    for number, case in enumerate(draw_cases(asked.seed, asked.cases)):
        tally.add(number, case, asked.restarts)
        if (number + 1) % REPORT_EVERY == 0 or number + 1 == asked.cases:
            tally.report()


if __name__ == "__main__":
    main()
