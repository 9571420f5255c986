"""Which ways to compute a slew are known by name?"""

from collections.abc import Callable
from dataclasses import dataclass

from planner.scenario import SlewOptions
from planner.slew.backends import ipopt, spline
from planner.slew.problem import SlewProblem
from planner.slew.solution import SlewSolution


@dataclass(frozen=True, kw_only=True)
class Backend:
    """keeps_limits: whether its solutions keep every limit and both ends, or only say so."""

    solve: Callable[[SlewProblem, SlewOptions], SlewSolution]
    keeps_limits: bool


BACKENDS = {
    "ocp": Backend(solve=ipopt.solve, keeps_limits=True),
    "spline": Backend(solve=spline.solve, keeps_limits=False),
}
