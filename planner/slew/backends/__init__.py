"""Which ways to compute a slew are known by name?"""

from collections.abc import Callable

from planner.scenario import SlewOptions
from planner.slew.backends import ipopt, spline
from planner.slew.problem import SlewProblem
from planner.slew.solution import SlewSolution

Backend = Callable[[SlewProblem, SlewOptions], SlewSolution]

BACKENDS: dict[str, Backend] = {"ocp": ipopt.solve, "spline": spline.solve}
