"""The paper's cubic spline, and what the optimal slew gains over it."""

from planner.motion.baseline.compare import compare_with_spline
from planner.motion.baseline.paper_cubic import in_paper_time, paper_profiles, paper_slew

__all__ = [
    "compare_with_spline",
    "in_paper_time",
    "paper_profiles",
    "paper_slew",
]
