"""How the axes get from one state to another."""

from planner.slew.backends import BACKENDS
from planner.slew.compare import ModeResidual, SlewComparison, compare_with_spline
from planner.slew.feasibility import next_duration_s, require_brakable, verdict
from planner.slew.grid import flown
from planner.slew.problem import AxisState, SlewProblem, broken_limit
from planner.slew.solution import SlewSolution

__all__ = [
    "BACKENDS",
    "AxisState",
    "ModeResidual",
    "SlewComparison",
    "SlewProblem",
    "SlewSolution",
    "broken_limit",
    "compare_with_spline",
    "flown",
    "next_duration_s",
    "require_brakable",
    "verdict",
]
