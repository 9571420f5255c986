"""The figure of a plan: angles, rates and accelerations with their limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.interpolation import cubic_coefficients
from planner.output.export.description import notes, one_line, session_label
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
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.plan import FlightPlan
from planner.world.platforms import AxisLimits
from planner.world.targets import EarthFixedTarget

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXIS_COLOURS = ("#0b5fa5", "#c8501e")
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

    Sessions are shaded, closest approaches and limits dashed.
    """
    table, limits = plan.table, plan.scenario.two_axis.axis_limits
    title = plan.scenario.name or "Plan"
    figure, panels = panels_over_time(
        ("angle, deg", "rate, deg/s", "acceleration, deg/s²"),
        f"{shown_text(title, TITLE_MAX)} ({shown_text(plan.scenario.platform.name, TITLE_MAX)})",
        table.epoch_utc,
        table.t_s[0],
        table.t_s[-1],
    )
    shade_spans(panels, _sessions(plan), "session")
    closest_s = list(_closest_approaches_s(plan))
    for order, (panel, (t_s, value_deg)) in enumerate(zip(panels, _motion(table), strict=True)):
        for axis, (name, colour) in enumerate(zip(table.dof_names, AXIS_COLOURS, strict=True)):
            panel.plot(t_s, value_deg[:, axis], color=colour, linewidth=1.6, label=name)
        for number, at_s in enumerate(closest_s):
            label = None if number else "closest approach"
            panel.axvline(at_s, color=CLOSEST_COLOUR, label=label, **DASHED)
        _draw_limits(panel, [_bounds_deg(axis)[order] for axis in limits], np.abs(value_deg).max())
    legend_below(figure, panels[0])
    return picture_file(figure, image_format, one_line(title), notes(plan, created_utc))


def _sessions(plan: FlightPlan) -> Iterator[tuple[float, float, str]]:
    for number, session in enumerate(plan.scenario.sessions):
        start_s, stop_s = (
            elapsed_s(moment, plan.table.epoch_utc) for moment in (session.start, session.stop)
        )
        yield start_s, stop_s, session_label(session, number)


def _motion(table: CommandTable) -> list[tuple[Array, Array]]:
    """Times and degrees of angle, rate, acceleration as flown: the Hermite between rows."""
    row = thinned(len(table.t_s), POINTS_MAX)
    cell = thinned(len(table.t_s) - 1, POINTS_MAX // 2)
    edges_s = np.column_stack([table.t_s[cell], table.t_s[cell + 1]]).ravel()
    return [
        (table.t_s[row], np.degrees(table.position[row])),
        (table.t_s[row], np.degrees(table.rate_rad_s[row])),
        (edges_s, np.degrees(_accelerations_rad_s2(table, cell))),
    ]


def _accelerations_rad_s2(table: CommandTable, cell: Indices) -> Array:
    """At the start and the end of each cell's cubic, in turn, (2 k, m)."""
    h = COMMAND_STEP_S
    angle, rate = table.position, table.rate_rad_s
    *_, c2, c3 = cubic_coefficients(h, angle[cell], angle[cell + 1], rate[cell], rate[cell + 1])
    ends = np.stack([2.0 * c2, 2.0 * c2 + 6.0 * c3], axis=1) / h**2
    return np.asarray(ends.reshape(-1, ends.shape[2]))


def _bounds_deg(limits: AxisLimits) -> tuple[tuple[float, float], ...]:
    return tuple((math.degrees(low), math.degrees(high)) for low, high in limits.bounds[:3])


def _draw_limits(panel: Axes, bounds_deg: list[tuple[float, float]], peak_deg: float) -> None:
    """Dashed, in an axis's colour where the axes differ; in words when far off the motion."""
    if peak_deg < SCALE_SHARE * min(min(abs(low), abs(high)) for low, high in bounds_deg):
        ranges = dict.fromkeys(f"{low:g}..{high:g}" for low, high in bounds_deg)
        text = f"limits {' and '.join(ranges)}, off the scale"
        panel.text(0.01, 0.93, text, transform=panel.transAxes, va="top", color=LIMIT_COLOUR)
        return
    same = len(set(bounds_deg)) == 1
    for bounds, colour in zip(bounds_deg, AXIS_COLOURS, strict=True):
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
