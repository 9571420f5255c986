"""The view of a plan: columns over time from its table."""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.output.view.carrier import (
    BodyTrack,
    BoresightTrace,
    CarrierTrack,
    FootprintTrace,
    body_track,
    boresight_trace,
    carrier_track,
    footprint_trace,
)
from planner.output.view.cones import ConeTrace, cone_traces
from planner.output.view.masks import MaskTrace, mask_traces
from planner.output.view.motion import AxesMotion, BaselineSlew, baseline_slews, motion_at_rows
from planner.output.view.pointing import PointingTrace, pointing_trace
from planner.output.view.rows import view_rows
from planner.output.view.scene import scene_of
from planner.output.view.targets import TargetTrack, target_tracks
from planner.output.view.windows import session_windows
from planner.planning.opportunities import Opportunities
from planner.world.frames.time_scales import elapsed_s
from planner.world.plan import FlightPlan


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanView:
    """A plan at n of its rows.

    step_s: from row to row, but for the last.  t_s: since the table's epoch, (n,).  segment: index
    into the plan's segments of what the table does from the row on, (n,).
    first_known: the first row at which orbit and attitude are known; the columns of carrier, Sun,
    targets and cones have a line for each row from it on.
    """

    plan: FlightPlan
    step_s: float
    t_s: Array
    segment: Indices
    axes: AxesMotion
    baseline: tuple[BaselineSlew, ...]
    first_known: int
    carrier: CarrierTrack
    boresight: BoresightTrace
    footprint: FootprintTrace
    sun: BodyTrack
    moon: BodyTrack
    targets: tuple[TargetTrack, ...]
    windows: tuple[Opportunities | None, ...]
    pointing: PointingTrace
    keep_out: tuple[ConeTrace, ...]
    masks: tuple[MaskTrace, ...]


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
    return PlanView(
        plan=plan,
        step_s=step_s,
        t_s=plan.table.t_s[row],
        segment=_segment(plan, row),
        axes=motion_at_rows(plan.table, row),
        baseline=tuple(baseline_slews(plan, round(step_s * ROWS_PER_S))),
        first_known=len(row) - len(scene.rows.row),
        carrier=carrier_track(scene),
        boresight=boresight_trace(scene),
        footprint=footprint_trace(scene),
        sun=sun,
        moon=moon,
        targets=targets,
        windows=session_windows(plan, pixel_arcsec),
        pointing=pointing_trace(scene, targets),
        keep_out=tuple(cone_traces(scene)),
        masks=tuple(mask_traces(plan, row)),
    )


def _segment(plan: FlightPlan, row: Indices) -> Indices:
    """The segment that begins at or before each row."""
    starts_s = [elapsed_s(segment.start_utc, plan.table.epoch_utc) for segment in plan.segments]
    first_row = np.round(np.array(starts_s) * ROWS_PER_S)
    return np.searchsorted(first_row, row, side="right") - 1
