"""The results of planning: the plan, its slews and their figures."""

from dataclasses import dataclass

from planner.base.solvers import SolverRun
from planner.motion.baseline import SlewComparison
from planner.planning.sessions.budget import PointingBudget
from planner.verification import VerificationReport
from planner.world.plan import FlightPlan


@dataclass(frozen=True, kw_only=True)
class SlewRun:
    """How one slew was solved.

    session: onto whose track; None: to the final state.
    minimum_s: the least time the limits allow, stops aside.  cost_rad2_s5: the integral of squared
    jerk of all axes; no motion within the limits has less than lower_bound_rad2_s5.  These and
    comparison: None where the baseline itself was asked for.  solver: whose motions are flown, all
    axes and the braking before taken together; None where they are no solver's.
    """

    session: int | None
    backend: str
    status: str
    iterations: int
    wall_s: float
    duration_s: float
    minimum_s: float
    cost_rad2_s5: float | None
    lower_bound_rad2_s5: float | None
    comparison: SlewComparison | None
    solver: SolverRun | None

    @property
    def gap(self) -> float | None:
        """The share of the cost that is not proven to be needed."""
        if self.cost_rad2_s5 is None or self.lower_bound_rad2_s5 is None:
            return None
        if self.cost_rad2_s5 == 0.0:
            return 0.0
        return max(1.0 - self.lower_bound_rad2_s5 / self.cost_rad2_s5, 0.0)


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
