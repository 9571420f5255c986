"""The figure of a comparison: plan and flight, and what each axis was off by."""

from __future__ import annotations

import math
from datetime import datetime
from typing import TYPE_CHECKING, Any

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.header_text import one_line
from planner.output.export.description import notes
from planner.output.export.figure import AXIS_COLOURS, session_spans
from planner.output.export.figure_parts import (
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from planner.inflight.telemetry.compare import Comparison
    from planner.inflight.telemetry.findings import AxisComparison

_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0
_SWING_COLOUR, _STICK_COLOUR = "#7b5aa6", "#b3282d"
_MARK: dict[str, Any] = {"linewidth": 4.0, "solid_capstyle": "butt", "alpha": 0.8}


def write_comparison_png(comparison: Comparison, created_utc: datetime) -> bytes:
    """1200 pixels wide."""
    return draw_comparison(comparison, "png", created_utc)


def write_comparison_svg(comparison: Comparison, created_utc: datetime) -> bytes:
    """Text stays text."""
    return draw_comparison(comparison, "svg", created_utc)


def draw_comparison(comparison: Comparison, image_format: str, created_utc: datetime) -> bytes:
    """The picture as a file of the given format: angles, then each axis's error.

    Sessions are shaded; bars under an error are its oscillations and where the axis stuck.
    """
    plan = comparison.plan
    table = plan.table
    title = plan.scenario.name or "Plan"
    t_s = comparison.alignment.t_s(comparison.clean.tag_s)
    figure, panels = panels_over_time(
        ["angle, deg", *(f"{shown_text(axis.name, 18)} error, arcsec" for axis in comparison.axes)],
        f"{shown_text(title, TITLE_MAX)}: plan and flight",
        table.epoch_utc,
        float(t_s[0]),
        float(t_s[-1]),
    )
    shade_spans(panels, session_spans(comparison.plan), "session")
    for axis, colour in zip(comparison.axes, AXIS_COLOURS, strict=False):
        _draw_angles(panels[0], axis, colour)
    for panel, axis, colour in zip(panels[1:], comparison.axes, AXIS_COLOURS, strict=False):
        _draw_error(panel, axis, colour)
    for label, mark in (("oscillates", _SWING_COLOUR), ("sticks and slips", _STICK_COLOUR)):
        panels[0].plot([], [], color=mark, label=label, **_MARK)
    legend_below(figure, panels[0])
    return picture_file(figure, image_format, one_line(title), notes(plan, created_utc))


def _draw_angles(panel: Axes, axis: AxisComparison, colour: str) -> None:
    followed = axis.followed
    table = followed.motion.table
    row = thinned(len(table.t_s), POINTS_MAX)
    planned_deg = np.degrees(table.position[row, followed.motion.axis])
    panel.plot(table.t_s[row], planned_deg, color=colour, linewidth=1.6, label=axis.name)
    if followed.basis == "angles":
        seen = thinned(len(followed.t_s), 60)
        flown_rad = followed.motion.angle_rad(followed.t_s[seen]) + followed.error_rad[seen]
        panel.plot(
            followed.t_s[seen],
            np.degrees(flown_rad),
            color=colour,
            linestyle="none",
            marker="o",
            markersize=3.5,
            markerfacecolor="none",
            label=f"{axis.name} flown",
        )


def _draw_error(panel: Axes, axis: AxisComparison, colour: str) -> None:
    followed = axis.followed
    panel.axhline(0.0, color=LIMIT_COLOUR, linewidth=0.8)
    for run in followed.runs:
        t_s, error_rad = followed.t_s[run], followed.error_rad[run]
        row = _extremes(error_rad, POINTS_MAX // 2)
        panel.plot(t_s[row], error_rad[row] * _ARCSEC_PER_RAD, color=colour, linewidth=0.9)
    low, high = panel.get_ylim()
    for height, spans, mark in (
        (0.02, axis.oscillations, _SWING_COLOUR),
        (0.06, axis.stick_slip, _STICK_COLOUR),
    ):
        for one in spans:
            at = low + (height - 0.08) * (high - low)
            panel.plot([one.start_s, one.stop_s], [at, at], color=mark, **_MARK)
    text = f"rms {axis.rms_rad * _ARCSEC_PER_RAD:.3g} arcsec"
    if axis.oscillations:
        largest = max(axis.oscillations, key=lambda one: one.amplitude_rad)
        text += (
            f"; swings by {largest.amplitude_rad * _ARCSEC_PER_RAD:.3g} arcsec at "
            f"{largest.frequency_hz:.3g} Hz"
        )
    panel.set_title(text, loc="left", fontsize=9, pad=3)


def _extremes(error_rad: Array, most: int) -> Indices:
    """Rows of the least and the greatest of each of so many parts: no peak is lost."""
    if len(error_rad) <= 2 * most:
        return np.arange(len(error_rad))
    edges = np.linspace(0, len(error_rad), most + 1).astype(np.intp)[:-1]
    size = int(np.diff(edges).min())
    parts = error_rad[edges[:, None] + np.arange(size)]
    return np.unique(np.concatenate([edges + parts.argmin(axis=1), edges + parts.argmax(axis=1)]))
