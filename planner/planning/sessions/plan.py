"""The results of planning: the plan, its slews and their figures."""

from dataclasses import dataclass
from typing import Annotated

from planner.base.answer_members import Count, Internal, Member, NotNegative, Share, answer
from planner.base.solvers import SolverRun
from planner.motion.comparison import SlewComparison
from planner.planning.sessions.budget import PointingBudget
from planner.verification import VerificationReport
from planner.world.plan import FlightPlan


@answer
class SlewRun:
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
    cost_rad2_s5: the integral of squared jerk of all axes; null for the spline. [deg2/s5]
    lower_bound_rad2_s5: no motion between the same states within the limits costs less, in the
    cost's unit; null for the spline.
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
    cost_rad2_s5: Annotated[float, Member("deg2", 0.0, called="cost")] | None
    lower_bound_rad2_s5: Annotated[float, Member("deg2", 0.0, called="lower_bound")] | None
    gap: Share | None
    solver: SolverRun | None
    comparison: Internal[SlewComparison | None]


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
    slews: tuple[SlewRun, ...]
    stages_wall_s: dict[str, NotNegative]


@dataclass(frozen=True, kw_only=True)
class Plan(FlightPlan):
    """A command table with everything needed to trust it.

    verification: the independent judge's report; a plan is only made when it passed, except
    for the baseline spline, whose broken limits the report and the warnings carry.
    budgets: 1-sigma pointing error per session, None for a test motion.
    stage_wall_s: seconds spent per stage of the pipeline, by name.
    """

    verification: VerificationReport
    slews: tuple[SlewRun, ...]
    budgets: tuple[PointingBudget | None, ...]
    warnings: tuple[str, ...]
    stage_wall_s: dict[str, float]

    @property
    def solver(self) -> SolverOut:
        return SolverOut(
            backend=" ".join(dict.fromkeys(run.backend for run in self.slews)),
            status=" ".join(dict.fromkeys(run.status for run in self.slews)),
            iterations=sum(run.iterations for run in self.slews),
            wall_s=sum(run.wall_s for run in self.slews),
            slews=self.slews,
            stages_wall_s=self.stage_wall_s,
        )

    @property
    def probability_in_frame(self) -> float | None:
        """The least of any session's; None without any."""
        known = map(self.probability_of, range(len(self.budgets)))
        return min((one for one in known if one is not None), default=None)

    def probability_of(self, number: int) -> float | None:
        """That the target of a session stays in the frame; None where the camera doesn't image."""
        budget = self.budgets[number]
        images = self.scenario.sessions[number].target.images
        return budget.probability_in_frame if budget is not None and images else None


def unproven_share(cost: float, bound: float) -> float:
    """The share of a slew's cost that is not proven to be needed."""
    return max(1.0 - bound / cost, 0.0) if cost else 0.0
