"""The view of a plan: columns over time from its table."""

import math
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.base.errors import OutsideCoverage
from planner.output.view.carrier import body_track, boresight_trace, carrier_track, footprint_trace
from planner.output.view.columns import (
    AxisBounds,
    PlanView,
    PointingTrace,
    ResourceTrace,
    TargetTrack,
)
from planner.output.view.motion import motion_at_rows
from planner.output.view.platforms.registry import parts_of
from planner.output.view.rows import view_rows
from planner.output.view.scene import PlanScene, scene_of
from planner.output.view.sky import sky_track
from planner.output.view.targets import target_tracks
from planner.planning.opportunities import (
    Opportunities,
    OpportunityRequest,
    OpportunityTarget,
    find_opportunities,
)
from planner.planning.resources import resource_curves
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.track_branches import los_on_rows, session_rows
from planner.world.frames.time_scales import elapsed_s, shifted_utc
from planner.world.plan import FlightPlan
from planner.world.platforms import Bounds
from planner.world.scenario import Scenario, Session
from planner.world.targets import VisibleTarget

T = TypeVar("T")
V = TypeVar("V", np.float64, np.bool_)

# Windows of each session's target around the session.

AROUND_S = 1800.0  # before and after: the whole pass of a low orbit, and no other
SAMPLES = 5


def session_windows(plan: FlightPlan, pixel_arcsec: float) -> tuple[Opportunities | None, ...]:
    """Of every session; None for a target without windows, or where too little is known.

    From `AROUND_S` before each session to as long after, within what the orbit is known for,
    else from the table's first row to its last.
    """
    table_span = (plan.table.epoch_utc, shifted_utc(plan.table.epoch_utc, plan.table.t_s[-1]))
    found: list[Opportunities | None] = []
    for number, session in enumerate(plan.scenario.sessions):
        around = shifted_utc(session.start, -AROUND_S), shifted_utc(session.stop, AROUND_S)
        spans = (around, table_span) if session.target.has_windows else ()
        in_spans = (
            _windows(plan.scenario, session, str(number), span, pixel_arcsec) for span in spans
        )
        found.append(next((windows for windows in in_spans if windows is not None), None))
    return tuple(found)


def _windows(
    scenario: Scenario,
    session: Session,
    name: str,
    span: tuple[datetime, datetime],
    pixel_arcsec: float,
) -> Opportunities | None:
    """None where orbit or attitude aren't known over the span, or it is too short to be asked."""
    try:
        request = OpportunityRequest(
            platform=scenario.platform,
            orbit=scenario.orbit,
            attitude=scenario.attitude,
            targets=(OpportunityTarget(id=name, target=session.target, roll=session.roll),),
            start=span[0],
            stop=span[1],
            samples=SAMPLES,
            pixel_arcsec=pixel_arcsec,
        )
    except ValueError:  # what the request says of itself
        return None
    try:
        return find_opportunities(request)
    except OutsideCoverage:
        return None


# Pointing errors over time: planned and budgeted distance of the boresight from its targets.

INSTANTS = 31  # of a session: errors vary over a pass, not from row to row


_ELLIPSE = ("sigma_major_rad", "sigma_minor_rad", "major_turn_rad")
_COLUMNS = ("error_rad", *_ELLIPSE)


def pointing_trace(scene: PlanScene, targets: Sequence[TargetTrack]) -> PointingTrace:
    """Of each session's own target."""
    columns = {name: np.full(len(scene.rows.instants), np.nan) for name in _COLUMNS}
    for track in targets:
        target = scene.plan.scenario.sessions[track.session].target
        inside = np.flatnonzero(track.in_session)
        columns["error_rad"][inside] = track.error_rad[inside]
        if len(inside) and isinstance(target, VisibleTarget):
            covariance_rad2 = _covariance_rad2(scene, track.session, target, inside)
            for name, values in zip(_ELLIPSE, _ellipse(covariance_rad2), strict=True):
                columns[name][inside] = values
    return PointingTrace(**columns)


def _covariance_rad2(
    scene: PlanScene, number: int, target: VisibleTarget, inside: Indices
) -> Array:
    """At rows `inside`, linear between instants at which it is found, (k, 2, 2)."""
    scenario, table = scene.plan.scenario, scene.plan.table
    rows = session_rows(scenario.sessions[number], table.epoch_utc)
    los = los_on_rows(scenario, scene.rows.ephemeris, target, rows, INSTANTS)
    at_s = los.instants.t_s
    found_rad2 = mover_of(scenario).error_covariance_rad2(scene.rows.ephemeris, table, number, los)
    wanted_s = scene.rows.row[inside] / ROWS_PER_S
    parts = [np.interp(wanted_s, at_s, found_rad2[:, i, j]) for i, j in ((0, 0), (0, 1), (1, 1))]
    return np.stack([np.stack(parts[:2], -1), np.stack(parts[1:], -1)], axis=1)


def _ellipse(covariance_rad2: Array) -> tuple[Array, Array, Array]:
    """Half the major and the minor axis, and the turn of the major one, (n,) each."""
    a, b, c = covariance_rad2[:, 0, 0], covariance_rad2[:, 0, 1], covariance_rad2[:, 1, 1]
    middle, reach = (a + c) / 2.0, np.hypot((a - c) / 2.0, b)
    turn_rad = np.arctan2(2.0 * b, a - c) / 2.0 % np.pi
    return np.sqrt(middle + reach), np.sqrt(np.maximum(middle - reach, 0.0)), turn_rad


def view_plan(plan: FlightPlan, step_s: float | None, pixel_arcsec: float) -> PlanView:
    """By the planner's geometry, from the table and the scenario alone.

    step_s: a multiple of 0.2 s; chosen unless given.  pixel_arcsec: angle a pixel sees.
    Raises InvalidInput for the step, OutsideCoverage when orbit or attitude is unknown while a
    target is tracked.
    """
    sessions_and_cones = len(plan.scenario.sessions) + len(plan.scenario.slew.keep_out)
    row, step_s = view_rows(len(plan.table.t_s), sessions_and_cones, step_s)
    scene = scene_of(plan, row)
    targets = tuple(target_tracks(scene, math.radians(pixel_arcsec / 3600.0)))
    sun, moon = map(partial(body_track, scene), ("sun", "moon"))
    # Before them orbit and attitude aren't known, and columns of carrier, Sun and targets are NaN.
    unknown = len(row) - len(scene.rows.row)
    segments = [plan.segments[number] for number in _segment(plan, row).tolist()]
    platform, kind = plan.scenario.platform, parts_of(scene, row, round(step_s * ROWS_PER_S))
    return PlanView(
        plan=plan,
        epoch_utc=plan.table.epoch_utc,
        step_s=step_s,
        pixel_arcsec=pixel_arcsec,
        t_s=plan.table.t_s[row],
        activity=tuple(segment.kind for segment in segments),
        session=tuple(segment.session for segment in segments),
        axes=motion_at_rows(plan.table, row),
        limits={
            name: _bounds(*bounds)
            for name, bounds in zip(
                plan.table.dof_names,
                plan.scenario.platform.motion_bounds(plan.scenario.slew.jerk_max_deg_s3),
                strict=True,
            )
        },
        keyholes_rad=kind.keyholes_rad,
        frame_rad=tuple(2.0 * half_rad for half_rad in platform.frame_half_rad),
        baseline=kind.baseline,
        carrier=_from_first(carrier_track(scene), unknown),
        boresight=_from_first(boresight_trace(scene), unknown),
        footprint=_from_first(footprint_trace(scene), unknown),
        sun=_from_first(sun, unknown),
        moon=_from_first(moon, unknown),
        targets=tuple(_from_first(track, unknown) for track in targets),
        windows=session_windows(plan, pixel_arcsec),
        pointing=_from_first(pointing_trace(scene, targets), unknown),
        keep_out=tuple(
            replace(
                cone,
                separation_rad=_whole(cone.separation_rad, unknown),
                counts=(None,) * unknown + cone.counts,
            )
            for cone in kind.keep_out
        ),
        masks=kind.masks,
        exclusions=tuple(_from_first(one, unknown) for one in kind.exclusions),
        resources=tuple(
            ResourceTrace(
                name=curve.name,
                unit=curve.unit,
                limit=curve.limit,
                capacity=curve.capacity,
                level=np.interp(plan.table.t_s[row], curve.t_s, curve.level),
            )
            for curve in resource_curves(plan)
        ),
        gyros=kind.gyros,
        sky=sky_track(scene, unknown),
    )


def _bounds(angle: Bounds | None, rate: Bounds, acceleration: Bounds, jerk: Bounds) -> AxisBounds:
    least, most = angle or (None, None)
    return AxisBounds(
        angle_min_rad=least,
        angle_max_rad=most,
        rate_max_rad_s=rate[1],
        acceleration_max_rad_s2=acceleration[1],
        jerk_max_rad_s3=jerk[1],
    )


def _from_first(section: T, unknown: int) -> T:
    """With so many rows before its first."""
    columns = {name: one for name, one in vars(section).items() if isinstance(one, np.ndarray)}
    whole = {name: _whole(one, unknown) for name, one in columns.items()}
    return replace(section, **whole)  # type: ignore[type-var]  # a dataclass


def _whole(value_by_row: NDArray[V], unknown: int) -> NDArray[V]:
    """NaN, or False, in the rows before (n, ...)."""
    nothing = False if value_by_row.dtype == bool else np.nan
    return np.concatenate([np.full((unknown, *value_by_row.shape[1:]), nothing), value_by_row])


def _segment(plan: FlightPlan, row: Indices) -> Indices:
    """The segment that begins at or before each row."""
    starts_s = [elapsed_s(segment.start_utc, plan.table.epoch_utc) for segment in plan.segments]
    first_row = np.round(np.array(starts_s) * ROWS_PER_S)
    return np.searchsorted(first_row, row, side="right") - 1
