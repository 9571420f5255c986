"""The slew of a whole body: the OCP's within all limits, or a refusal that names the limit.

Signatures first; the body follows.
"""

from dataclasses import dataclass
from typing import Literal

from planner.base.commands import Motion
from planner.base.solvers import SolverRun
from planner.motion.attitude.problem import BodySlewProblem


@dataclass(frozen=True, eq=False, kw_only=True)
class BodySlew:
    """A slew on the table's rows, with what no slew can beat beside it.

    motion: rows 0 .. n, the start and the goal's row among them; between them the body flies
    quintics in Rodrigues parameters, within all limits.
    cost_rad2_s5, bound_rad2_s5: integral of squared jerk, and what no slew of as many rows can
    do with less.  least_s: no slew takes less; eigenaxis_s: the quickest about the Euler axis
    found, None where none was.
    is_best: what of this slew no other can beat: "time" (to a row), "jerk" or nothing, which is
    then the best found.
    shares: the most used of rate, acceleration and jerk.  run: of the solver.
    """

    motion: Motion
    cost_rad2_s5: float
    bound_rad2_s5: float
    least_s: float
    eigenaxis_s: float | None
    is_best: Literal["time", "jerk"] | None
    shares: tuple[float, float, float]
    run: SolverRun

    @property
    def duration_s(self) -> float: ...


def solve_attitude_slew(problem: BodySlewProblem) -> BodySlew:
    """The slew asked for.

    Raises InfeasibleSlew, whose limit is "rate", "acceleration" or "jerk" where an end breaks it
    or can't be left or reached within it; "exclusion" where a cone is in the way; "duration"
    where the time is too short, with the time it takes.  Raises WorkLimitReached.
    """
    raise NotImplementedError


def least_s(problem: BodySlewProblem) -> float:
    """No slew arrives at any row of the goal in less; infinite where at none of them."""
    raise NotImplementedError


def may(problem: BodySlewProblem) -> bool:
    """False is a proof that no slew arrives at any row of the goal; some ms at most."""
    raise NotImplementedError


def enough_s(problem: BodySlewProblem) -> float | None:
    """A time, on a row of the goal, in which an eigenaxis slew keeps all limits; None: unknown."""
    raise NotImplementedError
