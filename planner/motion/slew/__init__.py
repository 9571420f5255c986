"""Slews of the axes from one state to another."""

from planner.motion.slew.feasibility import next_duration_s, require_brakable, verdict
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem, broken_limit
from planner.motion.slew.solution import SlewSolution

__all__ = [
    "AxisState",
    "SlewProblem",
    "SlewSolution",
    "broken_limit",
    "next_duration_s",
    "optimal_slew",
    "require_brakable",
    "verdict",
]
