"""The slew to where the axes rest when the last session is over."""

import math
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.errors import InfeasibleSlew
from planner.motion.baseline.paper_cubic import paper_duration_s
from planner.motion.pointing.track import AxisTrack
from planner.motion.slew import AxisState, SlewProblem
from planner.planning.sessions.platforms.mover import Join, RowSpan, TrackBranch
from planner.planning.sessions.platforms.two_axis.earliest_join import track_states
from planner.planning.sessions.platforms.two_axis.joining import slew_onto
from planner.planning.sessions.platforms.two_axis.slew_timing import (
    OPTIONS as SLEW_TIMING_OPTIONS,
)
from planner.planning.sessions.platforms.two_axis.slew_timing import (
    States,
    at_rest_after,
    brake_enough_s,
    least_slew_s,
    recommended_duration_s,
)
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.rules.two_axis import axes_of, final_angle_rad, limits_of
from planner.world.scenario import BoundedLead, Scenario


@dataclass(frozen=True, kw_only=True)
class FinalSlewOptions:
    """How the axes are brought to rest after the last session."""

    longest_s: float = 3600.0  # what has no end of its own must have one
    rounding: float = 1e-12  # rad, rad/s, rad/s2: below what a table's rows can tell
    quickly: float = 0.2  # of the time in which braking is smooth: within 3/4 of the limits
    # the branch around a cone may be several times as long
    cones_times: tuple[float, ...] = (1.0, 4.0)


OPTIONS = FinalSlewOptions()


def with_final_slew(scenario: Scenario, ephemeris: Ephemeris, joins: list[Join]) -> list[Join]:
    """The joins, and a slew to the final state where one is asked for and not reached already.

    It begins where the last track ends, at once, and takes the time that makes it smooth, at
    most `slew.lead.max_duration_s`; with the objective "minimum_time" the least.
    ephemeris: over the sessions; cones ask for more.  Raises InfeasibleSlew, OutsideCoverage.
    """
    if scenario.final_state is None:
        return joins
    last = joins[-1]
    state = track_states(last.track, last.stop_row / ROWS_PER_S)
    asked = final_angle_rad(scenario)
    by_s = scenario.final_rows(last.stop_row) / ROWS_PER_S
    longest_s = min(_longest_s(scenario), by_s)
    if asked is None:
        rest, least_s = None, 0.0
        wanted_s = brake_enough_s(state, limits_of(scenario), scenario.slew)
        wanted_s *= OPTIONS.quickly if scenario.slew.objective == "minimum_time" else 1.0
    else:
        rest = tuple(AxisState(angle_rad=angle_rad) for angle_rad in asked)
        least_s = least_slew_s(state, rest, limits_of(scenario))
        wanted_s = _wanted_s(scenario, state, rest)
    if _is_at_rest(state, rest or state):
        return joins
    least_s = max(least_s, SLEW_TIMING_OPTIONS.fewest_rows / ROWS_PER_S)
    if least_s > longest_s:
        raise _too_far(scenario, least_s, longest_s, by_s)
    for times in OPTIONS.cones_times:
        rows = math.ceil(min(times * wanted_s, longest_s) * ROWS_PER_S - 1e-6)
        rows = max(rows, SLEW_TIMING_OPTIONS.fewest_rows)
        there = rest or at_rest_after(state, limits_of(scenario), rows / ROWS_PER_S)
        branch = _rest_branch(scenario, ephemeris, there, last.stop_row, rows)
        try:
            final = slew_onto(scenario, branch, last.stop_row, state)
            return [*joins, replace(final, stop_row=final.join_row)]
        except InfeasibleSlew as refusal:
            failed = refusal
            if refusal.limit != "keep_out":
                break
    raise InfeasibleSlew(
        f"after the last session {failed.detail.partition(';')[0]}; name another final_state, "
        "or leave it out",
        field="final_state",
        axis=failed.axis,
        limit=failed.limit,
        at_utc=shifted_utc(scenario.initial_state.epoch, last.stop_row / ROWS_PER_S),
    )


def _is_at_rest(state: States, there: States) -> bool:
    """To rounding."""
    return all(
        abs(here.angle_rad - wanted.angle_rad) < OPTIONS.rounding
        and abs(here.rate_rad_s) < OPTIONS.rounding
        and abs(here.acceleration_rad_s2) < OPTIONS.rounding
        for here, wanted in zip(state, there, strict=True)
    )


def _wanted_s(scenario: Scenario, state: States, rest: States) -> float:
    """The paper's spline knows a time of its own for the objective "minimum_time"."""
    limits, slew = limits_of(scenario), scenario.slew
    if slew.keeps_limits or slew.objective == "smooth":
        return recommended_duration_s(state, rest, limits, slew.avoid_modes)
    return paper_duration_s(
        SlewProblem(
            axis_names=axes_of(scenario).axis_names,
            limits=limits,
            start=state,
            end=rest,
            duration_s=OPTIONS.longest_s,
        )
    )


def _longest_s(scenario: Scenario) -> float:
    lead = scenario.slew.lead
    asked_s = lead.max_duration_s if isinstance(lead, BoundedLead) else None
    return OPTIONS.longest_s if asked_s is None else min(asked_s, OPTIONS.longest_s)


def _too_far(scenario: Scenario, least_s: float, longest_s: float, by_s: float) -> InfeasibleSlew:
    if by_s == longest_s:
        return InfeasibleSlew(
            f"the axes need {least_s:.1f} s to come to rest where final_state asks, and final_by "
            f"leaves {max(by_s, 0.0):g} s; let it be later, or name a nearer state",
            field="final_by",
            limit="duration",
        )
    bounded = longest_s < OPTIONS.longest_s
    return InfeasibleSlew(
        f"the axes need {least_s:.1f} s to come to rest where final_state asks, and a slew may "
        f"last {longest_s:g} s; {'allow a longer one, or ' if bounded else ''}name a nearer state",
        field="slew.lead.max_duration_s" if bounded else "final_state",
        limit="duration",
    )


def _rest_branch(
    scenario: Scenario, ephemeris: Ephemeris, rest: States, from_row: int, rows: int
) -> TrackBranch:
    """Standing still from `from_row` on; it is to be joined so many rows later, or before."""
    t_s = np.array([from_row, from_row + rows]) / ROWS_PER_S
    angle_rad: Array = np.tile([axis.angle_rad for axis in rest], (2, 1))
    if scenario.slew.keep_out:
        epoch_utc = scenario.initial_state.epoch
        begin_utc, end_utc = (shifted_utc(epoch_utc, float(end_s)) for end_s in t_s)
        ephemeris = scenario.orbit.ephemeris(begin_utc, end_utc)
    return TrackBranch(
        session=scenario.sessions[-1],
        track=AxisTrack(
            axis_names=axes_of(scenario).axis_names,
            t_s=t_s,
            axis_states=np.stack([angle_rad, np.zeros((2, 2)), np.zeros((2, 2))]),
        ),
        rows=RowSpan(start=from_row + rows, stop=from_row + rows),
        seen_from_s=(from_row + SLEW_TIMING_OPTIONS.fewest_rows) / ROWS_PER_S,
        ephemeris=ephemeris,
    )
