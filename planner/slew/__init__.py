"""How the axes get from one state to another."""

from planner.slew.compare import ModeResidual, SlewComparison, compare_with_spline
from planner.slew.feasibility import next_duration_s, require_brakable, verdict
from planner.slew.optimal import optimal_slew
from planner.slew.paper_cubic import in_paper_time, paper_profiles, paper_slew
from planner.slew.problem import AxisState, SlewProblem, broken_limit
from planner.slew.solution import SlewSolution

__all__ = [
    "AxisState",
    "ModeResidual",
    "SlewComparison",
    "SlewProblem",
    "SlewSolution",
    "broken_limit",
    "compare_with_spline",
    "in_paper_time",
    "next_duration_s",
    "optimal_slew",
    "paper_profiles",
    "paper_slew",
    "require_brakable",
    "verdict",
]
