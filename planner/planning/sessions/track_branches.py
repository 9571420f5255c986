"""The rows of sessions, and when their targets are seen from them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Mask
from planner.base.commands import ROWS_PER_S
from planner.base.errors import NotVisible, OutsideCoverage
from planner.motion.pointing.line_of_sight import STENCIL, LineOfSight, line_of_sight
from planner.planning.sessions.platforms.mover import RowSpan
from planner.world.conditions import OPTIONS as CONDITION_OPTIONS
from planner.world.conditions import ConditionSeen, conditions_seen
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.scenario import Scenario, Session
from planner.world.targets import VisibleTarget


@dataclass(frozen=True, kw_only=True)
class TrackBranchOptions:
    """What it takes to examine a track, and how closely times count."""

    hold: int = 300  # of `effort`: any stretch of a target
    hold_row: int = 1  # of `effort`: a row of it
    cone_row: float = 0.3  # of `effort`: a row of a track beside a cone
    grid_tolerance_s: float = 1e-6  # a microsecond, the resolution of a time in a request


OPTIONS = TrackBranchOptions()

EARLY_ROWS = 600 * ROWS_PER_S  # how long before its session a target may be tracked already


def session_rows(session: Session, epoch_utc: datetime) -> RowSpan:
    """The session snapped outwards onto the command grid."""
    start_s = elapsed_s(session.start, epoch_utc) + OPTIONS.grid_tolerance_s
    stop_s = elapsed_s(session.stop, epoch_utc) - OPTIONS.grid_tolerance_s
    return RowSpan(start=math.floor(start_s * ROWS_PER_S), stop=math.ceil(stop_s * ROWS_PER_S))


def ephemeris_over(scenario: Scenario, sessions: list[RowSpan]) -> Ephemeris:
    """The orbit over all sessions and, if it is known, over the time for joining one early."""
    epoch_utc = scenario.initial_state.epoch
    narrow_row = 0 if scenario.needs_orbit_throughout else sessions[0].start
    wide_row = early_row(scenario, narrow_row, 0)
    stop_utc = shifted_utc(epoch_utc, sessions[-1].stop / ROWS_PER_S)
    try:
        return scenario.orbit.ephemeris(shifted_utc(epoch_utc, wide_row / ROWS_PER_S), stop_utc)
    except OutsideCoverage:
        if wide_row == narrow_row:
            raise
    return scenario.orbit.ephemeris(shifted_utc(epoch_utc, narrow_row / ROWS_PER_S), stop_utc)


def early_row(scenario: Scenario, start_row: int, from_row: int) -> int:
    """The first row from which the target may be followed."""
    if scenario.slew.objective != "minimum_time":
        return start_row
    return min(max(from_row, start_row - EARLY_ROWS), start_row)


def los_on_rows(
    scenario: Scenario,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    rows: RowSpan,
    count: int | None = None,
) -> LineOfSight:
    """The target from row to row, or at `count` instants, at least as many as derivatives need.

    Where a condition of the request isn't met it counts as not seen, too.
    """
    count = count or rows.stop - rows.start + 1
    t_s = np.linspace(rows.start, rows.stop, max(count, STENCIL)) / ROWS_PER_S
    los = line_of_sight(
        Instants(scenario.initial_state.epoch, t_s),
        ephemeris,
        scenario.attitude,
        scenario.platform.q_base_from_carrier,
        target,
    )
    asked = [one.margin + CONDITION_OPTIONS.tolerance for one in _conditions(scenario, target, los)]
    return replace(los, clearance_rad=np.min([los.clearance_rad, *asked], axis=0))


def may_look(
    scenario: Scenario, target: VisibleTarget, instants: Instants, states: OrbitStates
) -> Mask:
    """Whether the target is seen, and within the request's conditions, at n instants, (n,)."""
    seen = target.apparent(instants, states).clearance_rad >= 0.0
    for one in _conditions(scenario, target, _At(instants, states)):
        seen &= one.margin + CONDITION_OPTIONS.tolerance >= 0.0
    return seen


class _At(NamedTuple):
    instants: Instants
    states: OrbitStates


def _conditions(
    scenario: Scenario, target: VisibleTarget, at: LineOfSight | _At
) -> Iterator[ConditionSeen]:
    pixel_rad = scenario.platform.camera.pixel_rad
    attitude, q_carrier_from_eci = scenario.attitude, None
    if attitude is not None and scenario.conditions.directions:
        q_carrier_from_eci = attitude.q_body_from_eci(at.instants, at.states)
    return conditions_seen(
        scenario.conditions, target, at.instants, at.states, pixel_rad, q_carrier_from_eci
    )


def require_visible(
    scenario: Scenario, los: LineOfSight, rows: RowSpan, target: VisibleTarget, number: int
) -> None:
    """Raises NotVisible, with the condition, where it isn't seen throughout the session."""
    in_session = los.instants.t_s > (rows.start - 0.5) / ROWS_PER_S
    hidden = np.flatnonzero(in_session & (los.clearance_rad < 0.0))
    if not hidden.size:
        return
    first = hidden[0]
    first_utc = los.instants.utc(first)
    own_rad = target.apparent(los.instants, los.states).clearance_rad
    if own_rad[first] < 0.0:
        limit, what = "visibility", "the target can't be seen"
        worst = hidden[np.argmin(own_rad[hidden])]
        why = target.hidden_because(float(own_rad[worst]))
    else:
        bound, value, margin = next(
            one
            for one in _conditions(scenario, target, los)
            if one.margin[first] + CONDITION_OPTIONS.tolerance < 0.0
        )
        limit, what = bound.name, "a condition isn't met"
        worst = hidden[np.argmin(margin[hidden])]
        why = bound.unmet_because(float(value[worst]))
    raise NotVisible(
        f"session {number + 1}: from {utc_text(first_utc)} {what}; at "
        f"{utc_text(los.instants.utc(worst))} {why}",
        field=f"sessions.{number}.start" if first == 0 else f"sessions.{number}.stop",
        limit=limit,
        at_utc=first_utc,
    )


def seen_from_s(los: LineOfSight, start_s: float) -> float:
    """Since when, without a break until start_s, the target can be seen."""
    t_s = los.instants.t_s
    hidden_before = np.flatnonzero((los.clearance_rad < 0.0) & (t_s < start_s))
    return float(t_s[hidden_before[-1] + 1]) if hidden_before.size else float(t_s[0])
