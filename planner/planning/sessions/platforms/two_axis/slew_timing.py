"""Slew timing: the share of a lead that a slew takes; for the rest of it the axes stand still."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.errors import InfeasibleSlew
from planner.motion.pointing.keep_out import KeepOutView, deepest_entry
from planner.motion.slew import (
    AxisState,
    SlewProblem,
    SlewSolution,
    next_duration_s,
    optimal_slew,
    verdict,
)
from planner.motion.slew.stops import stop_margin_rad
from planner.world.platforms import AxisLimits, StructuralMode
from planner.world.scenario import BoundedLead, SlewOptions


@dataclass(frozen=True, kw_only=True)
class SlewTimingOptions:
    """How much time a slew is given."""

    # Times the least time.  From rest to rest a slew's peaks are then at most 0.19 of the rate
    # limit, 0.014 of the acceleration limit and 0.002 of the jerk limit: as gentle as following a
    # target (0.012 deg/s2 at most on real passes), so that more time makes the flight no
    # smoother.
    recommended_times: float = 10.0
    fewest_rows: int = 4  # jerk from row to row meets an angle, a rate and an acceleration in three
    mode_periods: float = 4.0  # of a mode to suppress: twice what that takes
    cone_row: float = 0.3  # of `effort`: to look whether a cone meets a row of a wait


OPTIONS = SlewTimingOptions()

States = tuple[AxisState, ...]
Solver = Callable[[SlewProblem], SlewSolution]


@dataclass(frozen=True, kw_only=True)
class TimedSlew:
    """The slew that ends when its time does, and what brought the axes to rest at its beginning.

    brake: None where the axes were at rest, or slew at once.
    """

    brake: SlewSolution | None = None
    slew: SlewSolution


@dataclass(frozen=True, kw_only=True)
class _Bounded:
    """Braking, if the axes move, for so many rows; a wait; a slew from rest in so many rows."""

    brake_rows: int
    rest: States
    slew_rows: int


def slew_within_lead(problem: SlewProblem, options: SlewOptions, solve: Solver) -> TimedSlew:
    """The slew of all the time there is, or braking, a wait and a shorter slew.

    problem: over all the time there is, in whole rows.  Where nothing is said of the lead and the
    wait or the shorter slew is impossible, as when a cone passes over the axes at rest, the slew
    takes all the time after all.  Raises InfeasibleSlew.
    """
    rows = round(problem.duration_s * ROWS_PER_S)
    bounded = _bounded_rows(problem.start, problem.end, problem.limits, options, rows)
    if bounded is None:
        return TimedSlew(slew=solve(problem))
    try:
        return _after_wait(problem, bounded, options, solve)
    except InfeasibleSlew as refusal:
        most_s = _most_asked_s(options)
        if most_s is None:
            return TimedSlew(slew=solve(problem))
        raise _too_bounded(refusal, most_s) from None


def may_slew_within_lead(
    start: States, end: States, limits: tuple[AxisLimits, ...], options: SlewOptions, rows: int
) -> bool:
    """Whether closed forms leave it open that so many rows suffice."""
    if _most_asked_s(options) is not None:
        bounded = _bounded_rows(start, end, limits, options, rows)
        if bounded is not None:
            start, rows = bounded.rest, bounded.slew_rows
    return all(
        verdict(*ends, rows / ROWS_PER_S).limit is None
        for ends in zip(start, end, limits, strict=True)
    )


def recommended_duration_s(
    start: States,
    end: States,
    limits: tuple[AxisLimits, ...],
    avoid_modes: tuple[StructuralMode, ...],
) -> float:
    """The time after which more makes a slew no smoother than the track it leads to."""
    return max(
        OPTIONS.recommended_times * least_slew_s(start, end, limits), _suppressed_s(avoid_modes)
    )


def least_slew_s(start: States, end: States, limits: tuple[AxisLimits, ...]) -> float:
    """The least time that the limits allow, stops aside; 0 where an axis can't at all."""
    axes = zip(start, end, limits, strict=True)
    return max(next_duration_s(*axis, 0.0) or 0.0 for axis in axes)


def brake_enough_s(state: States, limits: tuple[AxisLimits, ...], options: SlewOptions) -> float:
    """The time in which the axes come to rest smoothly, wherever; 0 where they are at rest."""
    least_s = max(_stopping_s(*axis) for axis in zip(state, limits, strict=True))
    return (
        max(OPTIONS.recommended_times * least_s, _suppressed_s(options.avoid_modes))
        if least_s
        else 0.0
    )


def at_rest_after(state: States, limits: tuple[AxisLimits, ...], brake_s: float) -> States:
    """Where the axes come to rest in that time at least jerk.

    The smoothest motion to rest anywhere has a rate cubic in time, which sets how far it goes;
    near a stop at most half the distance is taken that the hardest braking would leave.
    Source: Euler-Lagrange equation of the integral of squared jerk with a free end angle.
    """
    return tuple(
        _rest_of_axis(axis, limit, brake_s) for axis, limit in zip(state, limits, strict=True)
    )


def _bounded_rows(
    start: States, end: States, limits: tuple[AxisLimits, ...], options: SlewOptions, rows: int
) -> _Bounded | None:
    """None where the slew takes all the rows there are."""
    if not isinstance(options.lead, BoundedLead) or rows <= _most_rows(start, end, limits, options):
        return None
    brake_s = brake_enough_s(start, limits, options)
    brake_rows = min(math.ceil(brake_s * ROWS_PER_S), rows // 2)
    if brake_rows:
        brake_rows = max(brake_rows, OPTIONS.fewest_rows)
    rest = at_rest_after(start, limits, brake_rows / ROWS_PER_S)
    most_rows = _most_rows(rest, end, limits, options)
    return _Bounded(brake_rows=brake_rows, rest=rest, slew_rows=min(most_rows, rows - brake_rows))


def _most_asked_s(options: SlewOptions) -> float | None:
    return options.lead.max_duration_s if isinstance(options.lead, BoundedLead) else None


def _most_rows(
    start: States, end: States, limits: tuple[AxisLimits, ...], options: SlewOptions
) -> int:
    most_s = _most_asked_s(options)
    if most_s is not None:
        return math.floor(most_s * ROWS_PER_S + 1e-6)
    recommended_rows = math.ceil(
        recommended_duration_s(start, end, limits, options.avoid_modes) * ROWS_PER_S
    )
    return max(recommended_rows, 2 * OPTIONS.fewest_rows)


def _after_wait(
    problem: SlewProblem, bounded: _Bounded, options: SlewOptions, solve: Solver
) -> TimedSlew:
    brake = None
    if bounded.brake_rows:
        brake_s = bounded.brake_rows / ROWS_PER_S
        to_rest = replace(problem, end=bounded.rest, duration_s=brake_s, keep_out=None)
        brake = optimal_slew(to_rest, on_rows=True)
    duration_s = bounded.slew_rows / ROWS_PER_S
    begins_s = problem.duration_s - duration_s
    view = problem.keep_out if options.keeps_limits else None
    if view is not None:
        _require_outside(view, brake, bounded.rest, begins_s)
    slew = replace(
        problem,
        start=bounded.rest,
        duration_s=duration_s,
        keep_out=None if view is None else view.from_time(begins_s),
    )
    return TimedSlew(brake=brake, slew=solve(slew))


def _require_outside(
    view: KeepOutView, brake: SlewSolution | None, rest: States, until_s: float
) -> None:
    """Raises InfeasibleSlew where a region is met while the axes brake or wait."""
    if until_s < COMMAND_STEP_S / 2.0:
        return
    effort.charge(OPTIONS.cone_row * until_s * ROWS_PER_S * len(view.regions))
    rest_rad = np.array([axis.angle_rad for axis in rest])

    def motion_at(t_s: Array) -> tuple[Array, Array]:
        angle_rad, rate_rad_s = np.tile(rest_rad, (len(t_s), 1)), np.zeros((len(t_s), len(rest)))
        if brake is not None:
            moving = t_s < brake.duration_s
            angle_rad[moving], rate_rad_s[moving], _, _ = brake.motion(t_s[moving])
        return angle_rad, rate_rad_s

    entry = deepest_entry(view, motion_at, 0.0, until_s)
    if entry.depth_rad > 0.0:
        raise InfeasibleSlew(
            f"the axes would wait {math.degrees(entry.depth_rad):.2f} deg inside {entry.title}",
            limit="keep_out",
        )


def _too_bounded(refusal: InfeasibleSlew, most_s: float) -> InfeasibleSlew:
    reason = refusal.detail.partition(";")[0]
    return InfeasibleSlew(
        f"{reason}; allow more than the {most_s:g} s of slew.lead.max_duration_s, or all the time "
        'there is ("lead": "all")',
        axis=refusal.axis,
        limit=refusal.limit,
    )


def _suppressed_s(avoid_modes: tuple[StructuralMode, ...]) -> float:
    return max((OPTIONS.mode_periods / mode.frequency_hz for mode in avoid_modes), default=0.0)


def _stopping_s(state: AxisState, limits: AxisLimits) -> float:
    """Enough to bring an axis to rest somewhere: its acceleration is taken away, then its rate."""
    ramp_s = abs(state.acceleration_rad_s2) / limits.jerk_max_rad_s3
    rate_rad_s = abs(state.rate_rad_s + state.acceleration_rad_s2 * ramp_s / 2.0)
    least = limits.acceleration_max_rad_s2**2 / limits.jerk_max_rad_s3
    if rate_rad_s < least:
        return ramp_s + 2.0 * math.sqrt(rate_rad_s / limits.jerk_max_rad_s3)
    ramps_s = limits.acceleration_max_rad_s2 / limits.jerk_max_rad_s3
    return ramp_s + rate_rad_s / limits.acceleration_max_rad_s2 + ramps_s


def _rest_of_axis(state: AxisState, limits: AxisLimits, brake_s: float) -> AxisState:
    if state == state.at_rest():
        return state
    way_rad = brake_s * (state.rate_rad_s / 2.0 + brake_s * state.acceleration_rad_s2 / 12.0)
    spare_rad = max(stop_margin_rad(state, limits) / 2.0, 0.0)
    low, high = limits.angle_min_rad + spare_rad, limits.angle_max_rad - spare_rad
    return AxisState(angle_rad=min(max(state.angle_rad + way_rad, low), high))
