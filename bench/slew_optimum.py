"""Distance of slews from the least squared jerk there is, as solved and as flown.

Random axes of the HRC platform, each end at rest, moving, within 5 deg of a stop or at 0.9 to 1.0
of the rate limit, in 1.01 to 50 times the least time, 1 to 3,600 s.  Each is held against
`slew_reference`, whose jerk is constant on 400 cells; as flown, against one whose jerk changes
on rows only.  Limits are looked at every millisecond, by other code than the planner's.

    python bench/slew_optimum.py [--axes 200] [--pairs 300] [--seed 13]
"""

import argparse
import math
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
from slew_reference import Array, ReferenceError, least_costs

sys.path.append(str(Path(__file__).parents[1] / "tests" / "properties"))
from slew_cases import LIMITS, NAMES, Case, can_brake, deg_state, sampled

from planner.base.errors import InfeasibleSlew
from planner.motion.slew import AxisState, SlewProblem, SlewSolution, next_duration_s
from planner.motion.slew.optimal import OPTIMAL_GAP, optimal_slew

KINDS = ("rest", "moving", "near a stop", "fast")
STEP_S = 0.2
LEAST_SHARES, DURATIONS_S = (1.01, 50.0), (1.0, 3600.0)
NEAR, LOOSE = 1.001, 1.005
BROKEN = 1e-8  # of a limit's range
ROUNDING = 1e-6  # of the reference's cost
WARM_UP = 5
EVERY = 100  # axes: what was seen so far is told


def draw_state(rng: np.random.Generator, kind: str) -> AxisState:
    """One that can be braked, and reached."""
    while True:
        angle_deg, rate_deg_s = rng.uniform(-170.0, 170.0), rng.uniform(-2.9, 2.9)
        if kind == "near a stop":
            angle_deg = rng.choice([-1.0, 1.0]) * rng.uniform(170.0, 174.9)
        if kind == "fast":
            rate_deg_s = rng.choice([-1.0, 1.0]) * rng.uniform(2.7, 3.0)
        acceleration_deg_s2 = rng.uniform(-0.9, 0.9)
        if kind == "rest":
            return deg_state(angle_deg)
        state = deg_state(angle_deg, rate_deg_s, acceleration_deg_s2)
        if can_brake(state) and can_brake(state.backwards()):
            return state


def draw_duration_s(rng: np.random.Generator, least_s: float) -> float:
    """In whole rows."""
    shortest = max(LEAST_SHARES[0] * least_s, DURATIONS_S[0])
    longest = min(LEAST_SHARES[1] * least_s, DURATIONS_S[1])
    duration_s = math.exp(rng.uniform(math.log(shortest), math.log(longest)))
    return math.ceil(duration_s / STEP_S) * STEP_S


def draw_axis(seed: int, number: int) -> SlewProblem:
    rng = np.random.default_rng([seed, number])
    while True:
        start, end = (draw_state(rng, KINDS[kind % 4]) for kind in (number, number // 4))
        least_s = next_duration_s(start, end, LIMITS, 0.0)
        if least_s is not None:
            return Case((start,), (end,)).problem(draw_duration_s(rng, least_s))


def draw_pair(seed: int, number: int) -> SlewProblem:
    """Both axes, in one time."""
    rng = np.random.default_rng([seed, number, len(NAMES)])
    while True:
        start, end = (
            tuple(draw_state(rng, str(rng.choice(KINDS))) for _ in NAMES) for _ in range(2)
        )
        least = [next_duration_s(a, b, LIMITS, 0.0) for a, b in zip(start, end, strict=True)]
        if None not in least:
            return Case(start, end).problem(draw_duration_s(rng, max(least)))


def told(problem: SlewProblem) -> str:
    ends = " -> ".join(
        f"({math.degrees(at.angle_rad):.4f}, {math.degrees(at.rate_rad_s):.4f}, "
        f"{math.degrees(at.acceleration_rad_s2):.4f})"
        for at in (problem.start[0], problem.end[0])
    )
    return f"{ends} in {problem.duration_s:.1f} s"


def broken_share(motion: list[Array]) -> float:
    """By how much of their ranges limits are passed at most; negative: none is."""
    return max(
        max(values.max() - high, low - values.min()) / (high - low)
        for values, (low, high) in zip(motion, LIMITS.bounds, strict=True)
    )


def hermite_motion(t_s: Array, angle: Array, rate: Array) -> list[Array]:
    """Angle, rate, acceleration, jerk between rows, every millisecond; each cell by itself."""
    h = float(t_s[1] - t_s[0])
    mean = np.diff(angle) / h
    bend = (3.0 * mean - 2.0 * rate[:-1] - rate[1:]) / h
    turn = (rate[:-1] + rate[1:] - 2.0 * mean) / h**2
    x = np.linspace(0.0, h, round(h * 1e3) + 1)[:, None]
    return [
        angle[:-1] + x * (rate[:-1] + x * (bend + x * turn)),
        rate[:-1] + x * (2.0 * bend + 3.0 * x * turn),
        2.0 * bend + 6.0 * x * turn,
        6.0 * turn,
    ]


class Tally:
    """What was seen so far."""

    def __init__(self) -> None:
        self.solved: list[float] = []
        self.flown: list[float] = []
        self.on_rows: list[float] = []
        self.gaps: list[float] = []
        self.bounds: list[float] = []
        self.broken: list[float] = []
        self.counted: Counter[str] = Counter()

    def add(self, number: int, problem: SlewProblem) -> None:
        start, end = problem.start[0], problem.end[0]
        try:
            free, on_rows = least_costs(start, end, LIMITS, problem.duration_s, STEP_S)
        except ReferenceError as failure:
            self._note(number, problem, f"no reference, {failure}")
            return
        try:
            solution = optimal_slew(problem)
        except InfeasibleSlew as refusal:
            if free is not None:
                self._note(number, problem, f"REFUSED, but there is a motion: {refusal}")
            self.counted["refused, rightly" if free is None else "refused, wrongly"] += 1
            return
        cost, (bound,), (status,) = (
            solution.jerk_squared_integral,
            solution.lower_bounds_rad2_s5,
            solution.status,
        )
        self._count_run("as solved", solution)
        self.gaps.append(1.0 - bound / cost if cost else 0.0)
        self.broken.append(broken_share(sampled(solution.profiles[0])))
        if free is None:
            self._note(number, problem, f"solved ({status}), but the reference finds no motion")
        else:
            self._compare(self.solved, cost, free, f"{number} as solved: {told(problem)}, {status}")
            self.bounds.append(bound / free if free else 1.0)
            if free and on_rows:
                self.on_rows.append(on_rows / free)
            if self.bounds[-1] > 1.0 + ROUNDING:
                self._note(number, problem, f"BOUND {self.bounds[-1]:.7f} of the reference")
        try:
            table = optimal_slew(problem, on_rows=True)
        except InfeasibleSlew as refusal:
            if on_rows is not None:
                self._note(number, problem, f"REFUSED on rows, but there is a motion: {refusal}")
            self.counted[f"refused on rows, {'rightly' if on_rows is None else 'wrongly'}"] += 1
            return
        self._count_run("as flown", table)
        t_s = np.linspace(0.0, problem.duration_s, round(problem.duration_s / STEP_S) + 1)
        angle, rate, _, _ = table.profiles[0].evaluate(t_s)
        self.broken.append(broken_share(hermite_motion(t_s, angle, rate)))
        if on_rows is not None:
            what = f"{number} as flown: {told(problem)}, {table.status[0]}"
            self._compare(self.flown, table.jerk_squared_integral, on_rows, what)
        else:
            self.counted["flown, although no jerk on rows keeps the limits"] += 1

    def _count_run(self, what: str, solution: SlewSolution) -> None:
        [run] = solution.runs
        self.counted[f"{what} by {run.name}, {run.status}" if run else f"{what} by no solver"] += 1

    def _compare(self, ratios: list[float], cost: float, reference: float, what: str) -> None:
        ratios.append(cost / reference if reference else 1.0)
        if ratios[-1] > NEAR:
            print(f"  {ratios[-1]:.5f} axis {what}", flush=True)

    def _note(self, number: int, problem: SlewProblem, what: str) -> None:
        print(f"  axis {number}: {told(problem)}: {what}", flush=True)

    def report(self) -> None:
        print(", ".join(f"{count} {what}" for what, count in sorted(self.counted.items())))
        for name, ratios in (("solved", self.solved), ("flown", self.flown)):
            r = np.array(ratios)
            print(
                f"as {name}, cost of the reference's: median {np.median(r):.5f}, "
                f"99 % {np.quantile(r, 0.99):.5f}, worst {r.max():.4f}; "
                f"<= {NEAR}: {np.mean(r <= NEAR):.2%}, <= {LOOSE}: {np.mean(r <= LOOSE):.2%} of "
                f"{len(r)}"
            )
        gaps, broken, bounds = np.array(self.gaps), np.array(self.broken), np.array(self.bounds)
        print(
            f"what rows cost the reference: median {np.median(self.on_rows) - 1.0:.1e}, 95 % "
            f"{np.quantile(self.on_rows, 0.95) - 1.0:.1e}, worst {max(self.on_rows) - 1.0:.1e}"
        )
        print(
            f"limits broken on 1 ms: {np.sum(broken > BROKEN)} of {len(broken)}, as solved and as "
            f"flown; the worst by {broken.max():.1e} of its range\n"
            f"lower bound <= reference: {np.sum(bounds <= 1.0 + ROUNDING)} of {len(bounds)}, at "
            f"most {bounds.max():.7f} of it\n"
            f"gap: median {np.median(gaps):.1e}, 95 % {np.quantile(gaps, 0.95):.1e}, worst "
            f"{gaps.max():.3f}; optimal (<= {OPTIMAL_GAP:g}): {np.mean(gaps <= OPTIMAL_GAP):.1%}",
            flush=True,
        )


def report_time(seed: int, count: int) -> None:
    solved_ms, flown_ms, refused = [], [], 0
    for number in range(-WARM_UP, count):
        problem = draw_pair(seed, number + WARM_UP)
        began_s = time.process_time()
        try:
            optimal_slew(problem)
            solved_s = time.process_time()
            optimal_slew(problem, on_rows=True)
        except InfeasibleSlew:
            refused += number >= 0
            continue
        if number >= 0:
            solved_ms.append(1e3 * (solved_s - began_s))
            flown_ms.append(1e3 * (time.process_time() - solved_s))
    print(f"{count} slews of both axes, {refused} of them refused; process time:")
    for what, ms in (("anywhere", solved_ms), ("on rows", flown_ms)):
        print(f"  {what}: median {np.median(ms):.1f} ms, 95 % {np.quantile(ms, 0.95):.1f} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--axes", type=int, default=200)
    parser.add_argument("--pairs", type=int, default=300, help="of axes, timed")
    parser.add_argument("--seed", type=int, default=13)
    asked = parser.parse_args()
    report_time(asked.seed, asked.pairs)
    tally = Tally()
    for number in range(asked.axes):
        tally.add(number, draw_axis(asked.seed, number))
        if (number + 1) % EVERY == 0 or number + 1 == asked.axes:
            print(f"of {number + 1} axes:")
            tally.report()


if __name__ == "__main__":
    main()
