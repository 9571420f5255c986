"""When can the slew first reach the track?"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.commands import COMMAND_STEP_S
from planner.errors import InfeasibleSlew
from planner.gimbal.keep_out import KeepOutView
from planner.gimbal.track import AxisTrack
from planner.platforms import AxisLimits
from planner.scenario import SlewOptions
from planner.slew.backends import BACKENDS
from planner.slew.detour import cleared
from planner.slew.feasibility import next_duration_s
from planner.slew.grid import flown
from planner.slew.problem import AxisState, SlewProblem, within
from planner.slew.solution import SlewSolution

NEAR_S = 4.0  # closer than this to feasibility every row is tried
DETOUR_ROWS = 10  # a detour takes a second longer or ten: rows tried between, then halved
CAUTION = 4.0  # a receding or approaching track changes the time needed by a second per second


@dataclass(frozen=True, kw_only=True)
class Join:
    """The slew that meets the track at t_s, on the track's clock and on a command row."""

    t_s: float
    solution: SlewSolution


def track_states(track: AxisTrack, t_s: float) -> tuple[AxisState, ...]:
    """What a slew must arrive with to follow the track from t_s on."""
    angle, rate, acceleration = track.motion(np.array([t_s]))
    return tuple(
        AxisState(angle_rad=float(q), rate_rad_s=float(v), acceleration_rad_s2=float(a))
        for q, v, a in zip(angle[0], rate[0], acceleration[0], strict=True)
    )


def earliest_join(
    track: AxisTrack,
    limits: tuple[AxisLimits, ...],
    start: tuple[AxisState, ...],
    start_s: float,
    options: SlewOptions,
    *,
    after_s: float = -math.inf,
    keep_out: KeepOutView | None = None,
) -> Join | None:
    """The first command row at which the slew can join the track; None: on no row of it.

    start: state at start_s.  All times count on the track's clock, whose whole multiples of
    0.2 s are command rows.  after_s: earlier joins are of no use.  keep_out: its time counted
    from start_s.  Each time is tested itself, by solving and flying the slew: feasible
    durations may have gaps.  With cones, rows are tried every two seconds, and the first
    success is taken forward by halving.
    """

    def joined_at(row: int) -> SlewSolution | None:
        end = track_states(track, row / 5.0)
        if _lacking_s(start, end, limits, row / 5.0 - start_s) > 0.0:
            return None
        problem = SlewProblem(
            axis_names=track.axis_names,
            limits=limits,
            start=start,
            end=end,
            duration_s=row / 5.0 - start_s,
            avoid_modes=options.avoid_modes,
            keep_out=keep_out,
        )
        try:
            return cleared(flown(BACKENDS["ocp"].solve(problem, options)), thorough=False)
        except InfeasibleSlew:
            return None

    row = math.ceil(max(start_s + COMMAND_STEP_S, track.t_s[0], after_s) / COMMAND_STEP_S - 1e-6)
    last = math.floor(track.t_s[-1] / COMMAND_STEP_S + 1e-6)
    tried = row - 1
    while row <= last:
        t_s = row / 5.0
        end = track_states(track, t_s)
        lacking_s = _lacking_s(start, end, limits, t_s - start_s)
        solution = joined_at(row) if lacking_s <= 0.0 else None
        if solution is not None:
            return _earlier(joined_at, tried, row, solution)
        tried = row
        skipped_s = lacking_s / CAUTION if NEAR_S < lacking_s < math.inf else 0.0
        least_rows = DETOUR_ROWS if keep_out is not None and lacking_s <= 0.0 else 1
        row += max(least_rows, math.floor(skipped_s / COMMAND_STEP_S))
    return None


def _earlier(
    joined_at: Callable[[int], SlewSolution | None], bad: int, good: int, solution: SlewSolution
) -> Join:
    """Between a row too early and a good one: the first good one."""
    while good - bad > 1:
        middle = (good + bad) // 2
        found = joined_at(middle)
        if found is None:
            bad = middle
        else:
            good, solution = middle, found
    return Join(t_s=good / 5.0, solution=solution)


def _lacking_s(
    start: tuple[AxisState, ...],
    end: tuple[AxisState, ...],
    limits: tuple[AxisLimits, ...],
    available_s: float,
) -> float:
    """How much longer than available_s the slowest axis needs; infinite: it can't at all."""
    needed_s = 0.0
    for here, there, limit in zip(start, end, limits, strict=True):
        least_s = next_duration_s(here, there, limit, 0.0) if within(there, limit) else None
        needed_s = max(needed_s, math.inf if least_s is None else least_s)
    return needed_s - available_s * (1.0 + 1e-9)
