"""Time of the slew's optimal control problem beside the same problem in its peers.

One run, one process, one slew of both axes with limits that bind, per duration:
  ours     `optimal_slew`: Ipopt on spans placed where they matter, limits at every instant, proven
  rockit   multiple shooting on the 0.2 s grid, limits at nodes, Ipopt
  Opti     multiple shooting on the 0.2 s grid by CasADi's Opti stack, limits at nodes, Ipopt
"re-solve" changes the states and solves again; "first plan" includes setting the solvers up, which
ours does once per process and number of spans.  "cost" is the peer's over ours.

    python bench/slew.py [--quick]      # --quick: 30 and 100 s only
"""

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import casadi
import numpy as np
import rockit

from planner.motion.slew.closed_forms import least_jerk_profile
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.motion.slew.solution import obeys
from planner.world.platforms import ISS_HRC

LIMITS = ISS_HRC.outer_limits
BOUNDS = (
    LIMITS.angle_max_rad,
    LIMITS.rate_max_rad_s,
    LIMITS.acceleration_max_rad_s2,
    LIMITS.jerk_max_rad_s3,
)
STEP_S = 0.2
RATE_BINDS_S = 100.0
DURATIONS_S = (30.0, 100.0, 300.0, 900.0)
TARGET_RATIO = {30.0: 4.0, 100.0: 25.0, 300.0: 70.0}
IPOPT = {"print_level": 0, "sb": "yes", "tol": 1e-8}
OWN_REPEATS = 20
SLOW_S = 5.0  # a peer that takes longer than this per solve is timed once


@dataclass(frozen=True)
class Timing:
    first_s: float
    again_s: float
    cost: float


def states(
    duration_s: float, shift_deg: float
) -> tuple[tuple[AxisState, ...], tuple[AxisState, ...]]:
    """A slew whose limits bind: the rate's to 100 s, beyond that the stops; shift_deg varies it."""

    def state(angle: float, rate: float, acceleration: float) -> AxisState:
        return AxisState(
            angle_rad=math.radians(angle + shift_deg),
            rate_rad_s=math.radians(rate),
            acceleration_rad_s2=math.radians(acceleration),
        )

    if duration_s <= RATE_BINDS_S:
        reach = 2.2 * duration_s
        start = (state(-0.6 * reach, 0.8, 0.1), state(0.6 * reach, -0.5, 0.0))
        return start, (state(0.4 * reach, 0.7, 0.01), state(-0.45 * reach, -0.4, 0.0))
    start = (state(-160.0, -2.0, 0.1), state(166.0, 1.5, 0.0))
    return start, (state(-125.0, 0.7, 0.01), state(140.0, -0.4, 0.0))


def ours(duration_s: float) -> Timing:
    def solve(shift_deg: float) -> float:
        start, end = states(duration_s, shift_deg)
        problem = SlewProblem(
            axis_names=ISS_HRC.axis_names,
            limits=ISS_HRC.axis_limits,
            start=start,
            end=end,
            duration_s=duration_s,
        )
        solution = optimal_slew(problem)
        free = [
            obeys(least_jerk_profile(*ends, duration_s), *ends, LIMITS)
            for ends in zip(start, end, strict=True)
        ]
        if solution.violations or any(free):
            raise SystemExit(f"{duration_s} s is no fair case: {solution.status}")
        return solution.jerk_squared_integral

    return _timed(solve, OWN_REPEATS)


@cache
def by_rockit(duration_s: float) -> Callable[[float], float]:
    ocp = rockit.Ocp(T=duration_s)
    x, u = ocp.state(6), ocp.control(2)
    ends = ocp.parameter(6), ocp.parameter(6)
    ocp.set_der(x, casadi.vertcat(x[2:6], u))
    ocp.add_objective(ocp.integral(casadi.sumsqr(u / BOUNDS[3])))
    ocp.subject_to(ocp.at_t0(x) == ends[0])
    ocp.subject_to(ocp.at_tf(x) == ends[1])
    for row, bound in zip(
        casadi.vertsplit(casadi.vertcat(x, u)), np.repeat(BOUNDS, 2), strict=True
    ):
        ocp.subject_to((-bound <= row) <= bound)
    ocp.solver("ipopt", {"ipopt": IPOPT, "print_time": False, "expand": True})
    ocp.method(rockit.MultipleShooting(N=round(duration_s / STEP_S), intg="rk"))

    def solve(shift_deg: float) -> float:
        for end, at in zip(ends, states(duration_s, shift_deg), strict=True):
            ocp.set_value(end, _stacked(at))
        jerk = ocp.solve().sample(u, grid="control")[1][:-1]
        return float(np.sum(jerk**2) * STEP_S)

    return solve


@cache
def by_opti(duration_s: float) -> Callable[[float], float]:
    opti, nodes, h = casadi.Opti(), round(duration_s / STEP_S), STEP_S
    x, u = opti.variable(6, nodes + 1), opti.variable(2, nodes)
    ends = opti.parameter(6), opti.parameter(6)
    for k in range(nodes):
        q, v, a, j = x[:2, k], x[2:4, k], x[4:, k], u[:, k]
        opti.subject_to(x[:2, k + 1] == q + h * v + h**2 / 2 * a + h**3 / 6 * j)
        opti.subject_to(x[2:4, k + 1] == v + h * a + h**2 / 2 * j)
        opti.subject_to(x[4:, k + 1] == a + h * j)
    opti.subject_to(x[:, 0] == ends[0])
    opti.subject_to(x[:, -1] == ends[1])
    for row in range(8):
        of_one = x[row, 1:-1] if row < 6 else u[row - 6, :]
        opti.subject_to(opti.bounded(-BOUNDS[row // 2], of_one, BOUNDS[row // 2]))
    opti.minimize(casadi.sumsqr(u / BOUNDS[3]) * h)
    opti.solver("ipopt", {"print_time": False, "expand": True}, IPOPT)

    def solve(shift_deg: float) -> float:
        for end, at in zip(ends, states(duration_s, shift_deg), strict=True):
            opti.set_value(end, _stacked(at))
        return float(np.sum(opti.solve().value(u) ** 2) * STEP_S)

    return solve


def _stacked(at: tuple[AxisState, ...]) -> list[float]:
    return [
        *(state.angle_rad for state in at),
        *(state.rate_rad_s for state in at),
        *(state.acceleration_rad_s2 for state in at),
    ]


def _timed(solve: Callable[[float], float], repeats: int) -> Timing:
    began_s = time.process_time()
    cost = solve(0.0)
    first_s = time.process_time() - began_s
    again_s: list[float] = []
    while len(again_s) < repeats and sum(again_s) < SLOW_S:
        began_s = time.process_time()
        solve(0.05 * (1 + len(again_s)))
        again_s.append(time.process_time() - began_s)
    return Timing(first_s, float(np.median(again_s)), cost)


def _timed_peer(peer: Callable[[float], Callable[[float], float]], duration_s: float) -> Timing:
    """Setting it up is part of its first solve."""
    return _timed(lambda shift_deg: peer(duration_s)(shift_deg), 3)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="30 and 100 s only")
    durations_s = DURATIONS_S[:2] if parser.parse_args().quick else DURATIONS_S
    ours(DURATIONS_S[0])  # code is loaded once per process, for everybody
    x = casadi.SX.sym("x")
    casadi.nlpsol("loaded", "ipopt", {"x": x, "f": x**2}, {"ipopt": IPOPT})
    print("both axes, CPU ms: re-solve / first plan with set-up; ratios to ours")
    for duration_s in durations_s:
        own = ours(duration_s)
        print(f"{duration_s:5.0f} s  ours    {_ms(own)}", flush=True)
        for name, peer in (("rockit", by_rockit), ("Opti", by_opti)):
            other = _timed_peer(peer, duration_s)
            again, first = other.again_s / own.again_s, other.first_s / own.first_s
            target = TARGET_RATIO.get(duration_s) if name == "rockit" else None
            wanted = f"  (target {target:.0f}x, first 20x)" if target else ""
            print(
                f"         {name:7s} {_ms(other)}   {again:7.1f}x {first:7.1f}x"
                f"   cost {other.cost / own.cost:.5f}{wanted}",
                flush=True,
            )


def _ms(timing: Timing) -> str:
    return f"{1e3 * timing.again_s:9.1f} / {1e3 * timing.first_s:9.1f}"


if __name__ == "__main__":
    main()
