"""The view's parts of two axes: keyholes, the paper's spline, cones and masks on the axes."""

import math
from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Array, Indices, angle_rad, cross
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.motion.baseline import paper_profiles
from planner.motion.pointing.angles import (
    axis_angles,
    boresight_platform,
    keyholes_rad,
    within_stops,
)
from planner.motion.slew import AxisState
from planner.output.view.columns import BaselineSlew, ConeTrace, MaskTrace
from planner.output.view.motion import by_dof
from planner.output.view.platforms.parts import OUTLINE_POINTS, KindParts
from planner.output.view.scene import PlanScene
from planner.world.plan import FlightPlan, segment_rows
from planner.world.platforms import FieldMask, TwoAxisPlatform
from planner.world.rules.two_axis import axes_of

OUTLINES_MAX = 31  # instants; a page draws the one next to its cursor
_STEP_RAD = math.radians(2.0)  # a great circle bends on the axes


def two_axis_parts(scene: PlanScene, row: Indices, every: int) -> KindParts:
    """The spline at every so many rows."""
    return KindParts(
        keyholes_rad=keyholes_rad(axes_of(scene.plan.scenario)),
        baseline=tuple(_baseline_slews(scene.plan, every)),
        keep_out=tuple(_cone_traces(scene)),
        masks=tuple(_mask_traces(scene.plan, row)),
    )


def _cone_traces(scene: PlanScene) -> Iterator[ConeTrace]:
    """Of each cone of the scenario."""
    platform = axes_of(scene.plan.scenario)
    count = len(scene.rows.instants)
    outlined = np.unique(np.linspace(0, count - 1, min(count, OUTLINES_MAX)).round().astype(int))
    boresight = boresight_platform(platform, scene.plan.table.position[scene.rows.row])
    for number, cone in enumerate(scene.plan.scenario.slew.keep_out):
        axis_platform, counts_rad = scene.keep_out_axis(cone)
        half_angle_rad = math.radians(cone.half_angle_deg)
        yield ConeTrace(
            number=number,
            about=cone.about,
            half_angle_rad=half_angle_rad,
            separation_rad=angle_rad(boresight, axis_platform),
            counts=tuple((counts_rad > 0.0).tolist()),
            outline_t_s=scene.rows.instants.t_s[outlined],
            outline_rad=dict(
                zip(
                    platform.axis_names,
                    _outlines_rad(platform, axis_platform[outlined], half_angle_rad),
                    strict=True,
                )
            ),
        )


def _outlines_rad(platform: TwoAxisPlatform, axis: Array, half_angle_rad: float) -> Array:
    """axis: the cone's, (k, 3).

    Shape (2, k, 2, OUTLINE_POINTS): axes, instants, ways of pointing there, points around.
    """
    spare = np.eye(3)[np.abs(axis).argmin(axis=1)]
    first = cross(axis, spare)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = cross(axis, first)
    around = np.linspace(0.0, 2.0 * np.pi, OUTLINE_POINTS)[None, :, None]
    side = math.cos(half_angle_rad) * axis[:, None] + math.sin(half_angle_rad) * (
        np.cos(around) * first[:, None] + np.sin(around) * second[:, None]
    )
    both_rad = within_stops(platform, axis_angles(platform, side.reshape(-1, 3)).angle_rad)
    shaped = both_rad.reshape(2, len(axis), OUTLINE_POINTS, 2)
    return np.asarray(shaped.transpose(3, 1, 0, 2))


def _mask_traces(plan: FlightPlan, row: Indices) -> Iterator[MaskTrace]:
    """Of each mask, at these rows of the table."""
    platform = axes_of(plan.scenario)
    boresight = boresight_platform(platform, plan.table.position[row])
    for number, mask in enumerate(platform.masks):
        outline_platform = _outline_platform(mask)
        outline_rad = within_stops(platform, axis_angles(platform, outline_platform).angle_rad)
        yield MaskTrace(
            number=number,
            name=mask.name,
            asked_rad=mask.margin_rad,
            away_rad=-mask.polygon.depth_rad(boresight),
            outline_platform=outline_platform,
            outline_rad={
                name: outline_rad[..., axis] for axis, name in enumerate(platform.axis_names)
            },
        )


def _outline_platform(mask: FieldMask) -> Array:
    """Along its sides in steps of at most _STEP_RAD, (m, 3)."""
    corners = mask.polygon.corner_directions
    nexts = np.roll(corners, -1, axis=0)
    points = [corners[:1]]
    for first, second, side_rad in zip(corners, nexts, angle_rad(corners, nexts), strict=True):
        steps = math.ceil(side_rad / _STEP_RAD)
        along_rad = np.linspace(0.0, side_rad, steps + 1)[1:, None]
        points.append(
            (np.sin(side_rad - along_rad) * first + np.sin(along_rad) * second) / np.sin(side_rad)
        )
    return np.concatenate(points)


def _baseline_slews(plan: FlightPlan, every: int) -> Iterator[BaselineSlew]:
    """Of each slew, at every so many rows and its end; none of a spline's plan."""
    table = plan.table
    if not plan.scenario.slew.keeps_limits:
        return
    for segment in plan.segments:
        if segment.kind != "slew":
            continue
        first, last = segment_rows(table, segment)
        profiles = paper_profiles(
            _states(table, first, 0.0 * table.rate_rad_s[first]),
            _states(table, last, _acceleration_after(table, last)),
            (last - first) / ROWS_PER_S,
            plan.scenario.slew,
        )
        row = np.unique([*range(first, last, every), last])
        parts = [profile.evaluate((row - first) / ROWS_PER_S) for profile in profiles]
        motion = (np.stack([part[order] for part in parts], axis=1) for order in range(4))
        yield BaselineSlew(
            session=segment.session,
            t_s=row / ROWS_PER_S,
            axes=by_dof(table.dof_names, *motion),
        )


def _states(table: CommandTable, row: int, acceleration_rad_s2: Array) -> tuple[AxisState, ...]:
    return tuple(
        AxisState(angle_rad=float(q), rate_rad_s=float(v), acceleration_rad_s2=float(a))
        for q, v, a in zip(
            table.position[row], table.rate_rad_s[row], acceleration_rad_s2, strict=True
        )
    )


def _acceleration_after(table: CommandTable, row: int) -> Array:
    """Of the track that begins there, (m,), by its rates on three rows; 0 where the table ends.

    The spline needs it only to aim ahead by its filter's lag: an error of 1 % is 0.01 arcsec.
    """
    rate = table.rate_rad_s[row : row + 3]
    if len(rate) < 3:
        return np.zeros(rate.shape[1])
    return np.asarray((-3.0 * rate[0] + 4.0 * rate[1] - rate[2]) / (2.0 * COMMAND_STEP_S))
