"""The figure of a plan: attitude, rates, accelerations and resources with their limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import datetime
from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.header_text import one_line
from planner.base.table_motion import accelerations_rad_s2
from planner.output.export.description import notes, session_label
from planner.output.export.figure_parts import (
    DASHED,
    LIMIT_COLOUR,
    POINTS_MAX,
    TITLE_MAX,
    legend_below,
    panels_over_time,
    picture_file,
    shade_spans,
    shown_text,
)
from planner.output.export.map_features import thinned
from planner.planning.resources import ResourceCurve, resource_curves
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.plan import FlightPlan
from planner.world.platforms import Bounds
from planner.world.targets import EarthFixedTarget

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXIS_COLOURS = ("#0b5fa5", "#c8501e", "#3a7d34", "#444444")
CLOSEST_COLOUR = "#7b5aa6"
SCALE_SHARE = 0.15  # of a limit: a motion smaller than that would look like a straight line


def write_png(plan: FlightPlan, created_utc: datetime) -> bytes:
    """1200 pixels wide."""
    return draw_plan(plan, "png", created_utc)


def write_svg(plan: FlightPlan, created_utc: datetime) -> bytes:
    """Text stays text."""
    return draw_plan(plan, "svg", created_utc)


def draw_plan(plan: FlightPlan, image_format: str, created_utc: datetime) -> bytes:
    """The picture as a file of the given format.

    Sessions are shaded, closest approaches and limits dashed.  Resources have a panel each.
    """
    table, limits = (
        plan.table,
        plan.scenario.platform.motion_bounds(plan.scenario.slew.jerk_max_deg_s3),
    )
    channels = [channel for channel in table.channels if channel.of == "position"]
    parts = tuple(channel.dof for channel in channels)
    title = plan.scenario.name or "Plan"
    levels = {
        name: list(curves)
        for name, curves in groupby(resource_curves(plan), attrgetter("resource"))
    }
    figure, panels = panels_over_time(
        (
            "angle, deg" if channels[0].unit == "degree" else "attitude, quaternion",
            "rate, deg/s",
            "acceleration, deg/s²",
            *(f"{name}, {curves[0].unit}" for name, curves in levels.items()),
        ),
        f"{shown_text(title, TITLE_MAX)} ({shown_text(plan.scenario.platform.name, TITLE_MAX)})",
        table.epoch_utc,
        table.t_s[0],
        table.t_s[-1],
    )
    shade_spans(panels, session_spans(plan), "session")
    closest_s = list(_closest_approaches_s(plan))
    for panel, curves in zip(panels[3:], levels.values(), strict=True):
        _draw_levels(panel, curves)
    for order, (panel, (t_s, value_by_row)) in enumerate(
        zip(panels[:3], _motion(table), strict=True)
    ):
        for value, name, colour in zip(value_by_row.T, parts, AXIS_COLOURS, strict=False):
            panel.plot(t_s, value, color=colour, linewidth=1.6, label=name)
        for number, at_s in enumerate(closest_s):
            label = None if number else "closest approach"
            panel.axvline(at_s, color=CLOSEST_COLOUR, label=label, **DASHED)
        bounds = [axis[order] for axis in limits]
        _draw_limits(panel, _in_degrees(bounds), np.abs(value_by_row).max())
    legend_below(figure, panels[0])
    return picture_file(figure, image_format, one_line(title), notes(plan, created_utc))


def _draw_levels(panel: Axes, curves: list[ResourceCurve]) -> None:
    """Each with its limit; of wheels about x, y and z in their axes' colours."""
    for curve, colour in zip(curves, AXIS_COLOURS, strict=False):
        points = thinned(len(curve.t_s), POINTS_MAX)
        panel.plot(curve.t_s[points], curve.level[points], color=colour, linewidth=1.6)
        limits = {curve.limit, -curve.limit} if curve.resource == "momentum" else {curve.limit}
        for limit in limits:
            panel.axhline(limit, color=LIMIT_COLOUR if len(curves) == 1 else colour, **DASHED)


def session_spans(plan: FlightPlan) -> Iterator[tuple[float, float, str]]:
    """From when to when, s since the table's epoch, and its label."""
    for number, session in enumerate(plan.scenario.sessions):
        start_s, stop_s = (
            elapsed_s(moment, plan.table.epoch_utc) for moment in (session.start, session.stop)
        )
        yield start_s, stop_s, session_label(session, number)


def _motion(table: CommandTable) -> list[tuple[Array, Array]]:
    """Times, and degrees of angle, rate and acceleration as flown; of a body its quaternion."""
    row = thinned(len(table.t_s), POINTS_MAX)
    cell = thinned(len(table.t_s) - 1, POINTS_MAX // 2)
    edges_s = np.column_stack([table.t_s[cell], table.t_s[cell + 1]]).ravel()
    position = table.position[row]
    if table.acceleration_rad_s2 is None:
        position = np.degrees(position)
    return [
        (table.t_s[row], position),
        (table.t_s[row], np.degrees(table.rate_rad_s[row])),
        (edges_s, np.degrees(np.concatenate(accelerations_rad_s2(table, cell)))),
    ]


def _in_degrees(bounds_rad: list[Bounds | None]) -> list[Bounds]:
    return [(math.degrees(one[0]), math.degrees(one[1])) for one in bounds_rad if one is not None]


def _draw_limits(panel: Axes, bounds_deg: list[tuple[float, float]], peak_deg: float) -> None:
    """Dashed, in an axis's colour where the axes differ; in words when far off the motion."""
    if bounds_deg and peak_deg < SCALE_SHARE * min(
        min(abs(low), abs(high)) for low, high in bounds_deg
    ):
        ranges = dict.fromkeys(f"{low:g}..{high:g}" for low, high in bounds_deg)
        text = f"limits {' and '.join(ranges)}, off the scale"
        panel.text(0.01, 0.93, text, transform=panel.transAxes, va="top", color=LIMIT_COLOUR)
        return
    same = len(set(bounds_deg)) <= 1
    for bounds, colour in zip(bounds_deg, AXIS_COLOURS, strict=False):
        for bound in bounds:
            panel.axhline(bound, color=LIMIT_COLOUR if same else colour, **DASHED)
    panel.plot([], [], color=LIMIT_COLOUR, label="limits", **DASHED)


def _closest_approaches_s(plan: FlightPlan) -> Iterator[float]:
    """Of sessions that look at the Earth; not where a session begins or ends closest."""
    epoch_utc = plan.table.epoch_utc
    for session in plan.scenario.sessions:
        if not isinstance(session.target, EarthFixedTarget):
            continue
        start_s, stop_s = (elapsed_s(at, epoch_utc) for at in (session.start, session.stop))
        instants = Instants(epoch_utc, np.arange(start_s, stop_s, COMMAND_STEP_S))
        ephemeris = plan.scenario.orbit.ephemeris(session.start, session.stop)
        r_sat_itrf_m = np.einsum(
            "nij,nj->ni", c_itrf_from_eci(instants), ephemeris.states(instants).r_sat_eci_m
        )
        range_m = np.linalg.norm(r_sat_itrf_m - session.target.r_target_itrf_m(instants), axis=1)
        nearest = int(np.argmin(range_m))
        if 0 < nearest < len(range_m) - 1:
            yield float(instants.t_s[nearest])
