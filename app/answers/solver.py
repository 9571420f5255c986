"""The solution of a plan's slews, as answered."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.answers.members import fill
from app.answers.ranges import Count, NotNegative, Share

if TYPE_CHECKING:
    from planner.planning.sessions.plan import Plan, SlewRun


@dataclass(frozen=True, kw_only=True)
class SolverRunOut:
    """The solver whose motion is flown.

    name: of the solver.
    version: of the solver.
    status: in its own words how it ended, each once where there were several motions.
    iterations: that led to these motions, all together.
    """

    name: str
    version: str
    status: str
    iterations: Count


@dataclass(frozen=True, kw_only=True)
class SlewRunOut:
    """The solution of one slew.

    session: number of the session it leads to, from 0; null for the slew to the final state.
    backend: the method, as `slew.method` names it.
    status: quality of the slew: `optimal` (proven: the gap is at most 0.001), `smooth` and its gap,
    `modes suppressed`, `detour` around cones or masks, `feasible, not the smoothest` where the
    solver found none and the motion that proves the slew possible is flown, or `cubic`.
    iterations: of Ipopt, also of motions that aren't flown.
    wall_s: time it took to solve.
    duration_s: of the slew.
    minimum_s: the least time the limits allow.
    cost: the integral of squared jerk of all axes; null for the spline. [deg2/s5]
    lower_bound: no motion between the same states within the limits costs less, in the cost's
    unit; null for the spline.
    gap: share of the cost above the bound: what is called optimal has at most 0.001; null for the
    spline.
    solver: whose motions are flown; null where they are no solver's.
    """

    session: Count | None
    backend: str
    status: str
    iterations: Count
    wall_s: NotNegative
    duration_s: NotNegative
    minimum_s: NotNegative
    cost: NotNegative | None
    lower_bound: NotNegative | None
    gap: Share | None
    solver: SolverRunOut | None


@dataclass(frozen=True, kw_only=True)
class SolverOut:
    """The solution of the slews, all together and one by one.

    backend: the methods, as `slew.method` names them.
    status: quality of the slews, as `slews` states it.
    iterations: of Ipopt.
    wall_s: time it took to solve all slews.
    slews: the solution of each slew.
    stages_wall_s: time of each stage of the whole plan.
    """

    backend: str
    status: str
    iterations: Count
    wall_s: NotNegative
    slews: list[SlewRunOut]
    stages_wall_s: dict[str, NotNegative]


def _slew_run(run: "SlewRun") -> SlewRunOut:
    squared = math.degrees(1.0) ** 2
    cost, bound = run.cost_rad2_s5, run.lower_bound_rad2_s5
    return fill(
        SlewRunOut,
        run,
        cost=None if cost is None else cost * squared,
        lower_bound=None if bound is None else bound * squared,
        solver=None if run.solver is None else SolverRunOut(**run.solver._asdict()),
    )


def solver_out(plan: "Plan") -> SolverOut:
    runs = plan.slews
    return SolverOut(
        backend=" ".join(dict.fromkeys(run.backend for run in runs)),
        status=" ".join(dict.fromkeys(run.status for run in runs)),
        iterations=sum(run.iterations for run in runs),
        wall_s=sum(run.wall_s for run in runs),
        slews=[_slew_run(run) for run in runs],
        stages_wall_s=dict(plan.stage_wall_s),
    )
