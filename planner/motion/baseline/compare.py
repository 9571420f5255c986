"""The gain of the optimal slew over the paper's cubic."""

import math

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.motion.baseline.paper_cubic import paper_duration_s, paper_slew
from planner.motion.comparison import AxisFigures, ModeResidual, SlewComparison
from planner.motion.slew.feasibility import next_duration_s
from planner.motion.slew.problem import LIMIT_TOLERANCE
from planner.motion.slew.solution import SlewSolution
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


def compare_with_spline(
    ocp: SlewSolution, options: SlewOptions, session: int | None
) -> SlewComparison:
    """The optimal slew to a session beside the paper's spline, solved for the purpose."""
    problem = ocp.problem
    spline = paper_slew(problem, options)
    least_s = [
        next_duration_s(start, end, limits, 0.0) or math.inf
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    ]
    return SlewComparison(
        session=session,
        duration_s=ocp.duration_s,
        least_s=None if math.inf in least_s else max(least_s),
        paper_s=paper_duration_s(problem),
        ocp=_figures_by_axis(ocp),
        spline=_figures_by_axis(spline),
        residual_vibration=tuple(
            ModeResidual(
                frequency_hz=mode.frequency_hz,
                damping=mode.damping,
                ocp_rad=_left_rad(ocp, mode),
                spline_rad=_left_rad(spline, mode),
            )
            for mode in problem.avoid_modes
        ),
    )


def _left_rad(slew: SlewSolution, mode: StructuralMode) -> dict[str, float]:
    rows = round(slew.duration_s * ROWS_PER_S)
    angle_rad, rate_rad_s, _, _ = slew.motion(np.arange(rows + 1) / ROWS_PER_S)
    problem = slew.problem
    return {
        name: residual_vibration_rad(
            angle_rad[:, axis],
            rate_rad_s[:, axis],
            mode,
            acceleration_before_rad_s2=problem.start[axis].acceleration_rad_s2,
            acceleration_after_rad_s2=problem.end[axis].acceleration_rad_s2,
        )
        for axis, name in enumerate(problem.axis_names)
    }


def _figures_by_axis(solution: SlewSolution) -> dict[str, AxisFigures]:
    return {
        name: _axis_figures(solution, axis) for axis, name in enumerate(solution.problem.axis_names)
    }


def _axis_figures(solution: SlewSolution, axis: int) -> AxisFigures:
    profile = solution.profiles[axis]
    jumps = _acceleration_jumps(solution, axis)
    rate, acceleration, jerk = (
        max(-profile.extremes[order].least, profile.extremes[order].greatest) for order in (1, 2, 3)
    )
    name = solution.problem.axis_names[axis]
    return AxisFigures(
        peak_rate_rad_s=rate,
        peak_acceleration_rad_s2=acceleration,
        peak_jerk_rad_s3=None if jumps else jerk,
        jerk_squared_integral_rad2_s5=None if jumps else profile.jerk_squared_integral,
        limits_broken=tuple(one.limit for one in solution.violations if one.axis == name),
        end_error_rad=solution.end_error_rad[axis],
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
