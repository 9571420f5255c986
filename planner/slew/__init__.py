"""How the axes get from one state to another."""

from planner.slew.backends import BACKENDS
from planner.slew.compare import ModeResidual, SlewComparison, compare_with_spline
from planner.slew.detour import cleared
from planner.slew.feasibility import next_duration_s, require_brakable, verdict
from planner.slew.grid import flown
from planner.slew.join import earliest_join, may_be_joined, track_states
from planner.slew.problem import AxisState, SlewProblem
from planner.slew.solution import SlewSolution

__all__ = [
    "BACKENDS",
    "AxisState",
    "ModeResidual",
    "SlewComparison",
    "SlewProblem",
    "SlewSolution",
    "cleared",
    "compare_with_spline",
    "earliest_join",
    "flown",
    "may_be_joined",
    "next_duration_s",
    "require_brakable",
    "track_states",
    "verdict",
]
