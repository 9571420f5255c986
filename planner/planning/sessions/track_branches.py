"""The rows of sessions, and when their targets are seen from them."""

import math
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from planner.base.commands import ROWS_PER_S
from planner.base.errors import NotVisible, OutsideCoverage
from planner.motion.pointing.line_of_sight import STENCIL, LineOfSight, line_of_sight
from planner.planning.sessions.platforms.mover import RowSpan
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
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
    """The target from row to row, or at `count` instants, at least as many as derivatives need."""
    count = count or rows.stop - rows.start + 1
    t_s = np.linspace(rows.start, rows.stop, max(count, STENCIL)) / ROWS_PER_S
    return line_of_sight(
        Instants(scenario.initial_state.epoch, t_s),
        ephemeris,
        scenario.attitude,
        scenario.platform.q_base_from_carrier,
        target,
    )


def require_visible(los: LineOfSight, rows: RowSpan, target: VisibleTarget, number: int) -> None:
    in_session = los.instants.t_s > (rows.start - 0.5) / ROWS_PER_S
    hidden = np.flatnonzero(in_session & (los.clearance_rad < 0.0))
    if not hidden.size:
        return
    worst = hidden[np.argmin(los.clearance_rad[hidden])]
    first_utc, worst_utc = los.instants.utc(hidden[0]), los.instants.utc(worst)
    why = target.hidden_because(float(los.clearance_rad[worst]))
    raise NotVisible(
        f"session {number + 1}: from {utc_text(first_utc)} the target can't be seen; at "
        f"{utc_text(worst_utc)} {why}",
        field=f"sessions.{number}.start" if hidden[0] == 0 else f"sessions.{number}.stop",
        limit="visibility",
        at_utc=first_utc,
    )


def seen_from_s(los: LineOfSight, start_s: float) -> float:
    """Since when, without a break until start_s, the target can be seen."""
    t_s = los.instants.t_s
    hidden_before = np.flatnonzero((los.clearance_rad < 0.0) & (t_s < start_s))
    return float(t_s[hidden_before[-1] + 1]) if hidden_before.size else float(t_s[0])
