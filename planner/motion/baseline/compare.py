"""The gain of the optimal slew over the paper's cubic."""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.motion.baseline.paper_cubic import paper_duration_s, paper_slew
from planner.motion.slew.feasibility import next_duration_s
from planner.motion.slew.problem import LIMIT_TOLERANCE
from planner.motion.slew.solution import LimitViolation, SlewSolution
from planner.world.platforms import StructuralMode
from planner.world.scenario import SlewOptions

# Residual vibration of a flexible structure after a slew.


def residual_vibration_rad(
    angle_rad: Array,
    rate_rad_s: Array,
    mode: StructuralMode,
    *,
    acceleration_before_rad_s2: float = 0.0,
    acceleration_after_rad_s2: float = 0.0,
) -> float:
    """Amplitude of x'' + 2 z w x' + w^2 x = -a after the last row, rad.

    angle_rad, rate_rad_s: (n,), rows of one axis in a command table; a is the acceleration of the
    cubic Hermite through them, straight lines with steps at rows, and the response to them
    is exact.  Before the first row the mode hangs still under acceleration_before; after the
    last one it swings by the amplitude returned about its deflection under acceleration_after.
    The mode's share in the axis's motion is one; deflections scale with it.
    """
    start, stop = _cell_accelerations(angle_rad, rate_rad_s)
    eigenvalue = mode.eigenvalue_rad_s
    phase = eigenvalue * COMMAND_STEP_S
    # With y' = lambda y + a the deflection is -Im y / w_d; over one row a = start + (stop-start) s.
    whole = np.expm1(phase) / eigenvalue
    ramp = (whole / COMMAND_STEP_S - 1.0) / eigenvalue
    gain = start * whole + (stop - start) * ramp
    rows_left = np.arange(len(gain) - 1, -1, -1)
    still = -1.0 / eigenvalue  # y under a unit of steady acceleration
    swing = (
        acceleration_before_rad_s2 * still * np.exp(phase * len(gain))
        + np.sum(gain * np.exp(phase * rows_left))
        - acceleration_after_rad_s2 * still
    )
    return float(abs(swing) / eigenvalue.imag)


def _cell_accelerations(angle_rad: Array, rate_rad_s: Array) -> tuple[Array, Array]:
    """Where each cell of the Hermite begins and ends, (n - 1,) each."""
    mean = np.diff(angle_rad) / COMMAND_STEP_S
    before, after = rate_rad_s[:-1], rate_rad_s[1:]
    return (
        (6.0 * mean - 4.0 * before - 2.0 * after) / COMMAND_STEP_S,
        (2.0 * before + 4.0 * after - 6.0 * mean) / COMMAND_STEP_S,
    )


@dataclass(frozen=True, kw_only=True)
class SlewFigures:
    """One slew in figures; tuples hold one value per axis.

    jerk_squared_integral: rad^2/s^5.  It and peak_jerk_rad_s3 are infinite where the
    acceleration jumps, at the ends too.  violations: every limit broken.
    """

    duration_s: float
    peak_rate_rad_s: tuple[float, ...]
    peak_acceleration_rad_s2: tuple[float, ...]
    peak_jerk_rad_s3: tuple[float, ...]
    jerk_squared_integral: tuple[float, ...]
    violations: tuple[LimitViolation, ...]
    end_error_rad: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class ModeResidual:
    """What is left of one structural mode after the slew, as flown; tuples: one per axis.

    The mode's share in the axis's motion is taken as one.
    """

    mode: StructuralMode
    ocp_rad: tuple[float, ...]
    spline_rad: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class SlewComparison:
    """The optimal slew beside the paper's spline over the same time between the same states.

    least_duration_s: what the limits allow, stops aside; paper_duration_s: what the paper's
    estimate asks for (Sumarokov 2016, eq. 12-13).  residuals: of the modes to suppress.
    """

    axis_names: tuple[str, ...]
    ocp: SlewFigures
    spline: SlewFigures
    least_duration_s: float
    paper_duration_s: float
    residuals: tuple[ModeResidual, ...]


def compare_with_spline(ocp: SlewSolution, options: SlewOptions) -> SlewComparison:
    """The optimal slew beside the paper's spline, solved for the purpose."""
    problem = ocp.problem
    spline = paper_slew(problem, options)
    least_s = (
        next_duration_s(start, end, limits, 0.0) or math.inf
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    )
    residuals = tuple(
        ModeResidual(mode=mode, ocp_rad=_left_rad(ocp, mode), spline_rad=_left_rad(spline, mode))
        for mode in problem.avoid_modes
    )
    return SlewComparison(
        axis_names=problem.axis_names,
        ocp=_slew_figures(ocp),
        spline=_slew_figures(spline),
        least_duration_s=max(least_s),
        paper_duration_s=paper_duration_s(problem),
        residuals=residuals,
    )


def _left_rad(slew: SlewSolution, mode: StructuralMode) -> tuple[float, ...]:
    rows = round(slew.duration_s * ROWS_PER_S)
    angle_rad, rate_rad_s, _, _ = slew.motion(np.arange(rows + 1) / ROWS_PER_S)
    return tuple(
        residual_vibration_rad(
            angle_rad[:, axis],
            rate_rad_s[:, axis],
            mode,
            acceleration_before_rad_s2=start.acceleration_rad_s2,
            acceleration_after_rad_s2=end.acceleration_rad_s2,
        )
        for axis, (start, end) in enumerate(zip(slew.problem.start, slew.problem.end, strict=True))
    )


def _slew_figures(solution: SlewSolution) -> SlewFigures:
    extremes = [profile.extremes for profile in solution.profiles]
    peaks = [
        tuple(max(-axis[order].least, axis[order].greatest) for axis in extremes)
        for order in (1, 2, 3)
    ]
    jumps = [_acceleration_jumps(solution, axis) for axis in range(len(solution.profiles))]
    return SlewFigures(
        duration_s=solution.duration_s,
        peak_rate_rad_s=peaks[0],
        peak_acceleration_rad_s2=peaks[1],
        peak_jerk_rad_s3=tuple(
            math.inf if jump else peak for jump, peak in zip(jumps, peaks[2], strict=True)
        ),
        jerk_squared_integral=tuple(
            math.inf if jump else profile.jerk_squared_integral
            for jump, profile in zip(jumps, solution.profiles, strict=True)
        ),
        violations=solution.violations,
        end_error_rad=solution.end_error_rad,
    )


def _acceleration_jumps(solution: SlewSolution, axis: int) -> bool:
    problem, profile = solution.problem, solution.profiles[axis]
    _, high = problem.limits[axis].bounds[2]
    first, last = profile.end_values[:, 2].tolist()
    steps = (
        first - problem.start[axis].acceleration_rad_s2,
        last - problem.end[axis].acceleration_rad_s2,
    )
    return profile.acceleration_jumps or any(
        abs(step) > 2.0 * LIMIT_TOLERANCE * high for step in steps
    )
