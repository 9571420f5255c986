"""The tracks of two axes along a session's target, and the spans they can be held over."""

import math

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.errors import NotVisible, OutsideCoverage, Refusal, TrackBreaksLimit, Unreachable
from planner.motion.keyhole.track import nearest_track
from planner.motion.pointing.keep_out import KeepOutView, deepest_entry, keep_out_view
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.motion.pointing.track import AxisTrack, track_candidates
from planner.planning.sessions.platforms.mover import RowSpan, TrackBranch
from planner.planning.sessions.track_branches import (
    OPTIONS,
    early_row,
    los_on_rows,
    require_visible,
    seen_from_s,
    session_rows,
)
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.rules.two_axis import axes_of, limits_of
from planner.world.scenario import Scenario, Session
from planner.world.targets import BenchMotionTarget, VisibleTarget


def track_branches(
    scenario: Scenario,
    ephemeris: Ephemeris,
    number: int,
    session: Session,
    from_row: int,
    start_angle_rad: Array,
) -> tuple[TrackBranch, ...]:
    """Every branch that holds the target over the session, the shortest slew first.

    Where none is exact, by request the one that errs least.
    number: the session's index, for refusals.  session: that session, or the same with other
    times.  from_row: the target is of no use before.  start_angle_rad: shape (m,), where
    the axes come from.  Raises NotVisible, Unreachable, TrackBreaksLimit.
    """
    rows = session_rows(session, scenario.initial_state.epoch)
    looked_at = rows.stop - early_row(scenario, rows.start, from_row)
    effort.charge(OPTIONS.hold + OPTIONS.hold_row * looked_at)
    if isinstance(session.target, BenchMotionTarget):
        tracks: tuple[AxisTrack, ...] = (_prescribed_track(scenario, session.target, number, rows),)
        seen_s = tracks[0].t_s[0]
    else:
        los = _line_of_sight(scenario, ephemeris, session.target, rows, from_row)
        require_visible(scenario, los, rows, session.target, number)
        platform = axes_of(scenario).with_limits(limits_of(scenario))
        start_s, stop_s = rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S
        try:
            tracks = track_candidates(platform, los, start_s, stop_s, start_angle_rad)
        except (TrackBreaksLimit, Unreachable) as exact:
            if session.keyhole == "refuse":
                raise
            tracks = (nearest_track(platform, los, start_s, stop_s, exact),)
        seen_s = seen_from_s(los, start_s)
    begins_s = min(float(track.t_s[0]) for track in tracks)
    view = keep_out_view(scenario, ephemeris, begins_s, rows.stop / ROWS_PER_S)
    if view is not None:
        effort.charge(OPTIONS.cone_row * looked_at * len(view.regions) * len(tracks))
    return tuple(
        TrackBranch(
            session=session,
            track=track,
            rows=rows,
            seen_from_s=max(seen_s, _outside_from_s(view, begins_s, scenario, number, track, rows)),
            ephemeris=ephemeris,
        )
        for track in tracks
    )


def _prescribed_track(
    scenario: Scenario, target: BenchMotionTarget, number: int, rows: RowSpan
) -> AxisTrack:
    """The motion a test target asks for, once it has shown that it can be flown."""
    epoch_utc = scenario.initial_state.epoch
    t_s = np.arange(rows.start, rows.stop + 1) / ROWS_PER_S
    start_utc = shifted_utc(epoch_utc, t_s[0])
    names = axes_of(scenario).axis_names
    try:
        bounds = scenario.platform.motion_bounds(scenario.slew.jerk_max_deg_s3)
        target.require_flyable(names, bounds, start_utc, float(t_s[-1] - t_s[0]))
        motion = target.axis_motion(names, t_s - elapsed_s(target.start or start_utc, epoch_utc))
    except Refusal as refusal:
        refusal.field = f"sessions.{number}.target.{refusal.field}"
        raise
    return AxisTrack(axis_names=names, t_s=t_s, axis_states=np.stack(motion))


def _line_of_sight(
    scenario: Scenario, ephemeris: Ephemeris, target: VisibleTarget, rows: RowSpan, from_row: int
) -> LineOfSight:
    """Over the session and, where the orbit is known, over the time for joining it early."""
    first_row = early_row(scenario, rows.start, from_row)
    try:
        return los_on_rows(scenario, ephemeris, target, RowSpan(start=first_row, stop=rows.stop))
    except OutsideCoverage:
        if first_row == rows.start:
            raise
    return los_on_rows(scenario, ephemeris, target, rows)


def _outside_from_s(
    view: KeepOutView | None,
    begins_s: float,
    scenario: Scenario,
    number: int,
    track: AxisTrack,
    rows: RowSpan,
) -> float:
    """Since when the track stays outside of all regions, up to the session; refused if not in it.

    begins_s: where the view's time begins.
    """
    if view is None:
        return float(track.t_s[0])

    def motion_at(t_s: Array) -> tuple[Array, Array]:
        angle_rad, rate_rad_s, _ = track.motion(begins_s + t_s)
        return angle_rad, rate_rad_s

    start_s, stop_s = rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S
    entry = deepest_entry(view, motion_at, start_s - begins_s, stop_s - begins_s)
    if entry.depth_rad > 0.0:
        at_utc = shifted_utc(scenario.initial_state.epoch, begins_s + entry.t_s)
        raise NotVisible(
            f"session {number + 1}: at {utc_text(at_utc)} the target stands "
            f"{math.degrees(entry.depth_rad):.2f} deg inside {entry.title}, which the boresight "
            "must keep out of",
            field=f"sessions.{number}.target",
            limit="keep_out",
            at_utc=at_utc,
        )
    before_s = track.t_s[track.t_s < start_s] - begins_s
    inside = np.flatnonzero(view.depths_rad(before_s, motion_at(before_s)[0]).max(0) > 0)
    return float(track.t_s[inside[-1] + 1] if inside.size else track.t_s[0])
