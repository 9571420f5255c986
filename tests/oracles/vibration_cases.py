"""Slews past a mode for test and benchmark, and what a flown one leaves of it."""

import numpy as np

from planner.motion.baseline.compare import residual_vibration_rad
from planner.motion.slew import AxisState, SlewProblem, SlewSolution
from planner.world.platforms import ISS_HRC, StructuralMode

LIMITS = ISS_HRC.outer_limits


def problem(
    start: AxisState, end: AxisState, duration_s: float, *modes: StructuralMode
) -> SlewProblem:
    return SlewProblem(
        axis_names=("alpha",),
        limits=(LIMITS,),
        start=(start,),
        end=(end,),
        duration_s=duration_s,
        avoid_modes=modes,
    )


def left_rad(slew: SlewSolution, mode: StructuralMode) -> float:
    """Of the flown table."""
    angle, rate, _, _ = slew.motion(np.arange(round(slew.duration_s * 5) + 1) / 5.0)
    return residual_vibration_rad(
        angle[:, 0],
        rate[:, 0],
        mode,
        acceleration_before_rad_s2=slew.problem.start[0].acceleration_rad_s2,
        acceleration_after_rad_s2=slew.problem.end[0].acceleration_rad_s2,
    )
