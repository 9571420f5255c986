"""The figure of a plan: angles, rates and accelerations with their limits."""

import io
import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from planner.errors import InvalidInput
from planner.frames.time_scales import elapsed_s, utc_text
from planner.platforms import AxisLimits
from planner.sessions.plan import Plan
from planner.verification import EarthFixedView

AXIS_COLOURS = ("#0b5fa5", "#c8501e")
SESSION_COLOUR = "#f3e9c6"
LIMIT_COLOUR = "#8a8a8a"
CLOSEST_COLOUR = "#7b5aa6"
CELL_EDGE_S = 1e-6  # just inside a cell, where the acceleration of its own cubic holds
DASHED: dict[str, Any] = {"linestyle": (0, (6, 4)), "linewidth": 1.0}
SCALE_SHARE = 0.15  # of a limit: a motion smaller than that would look like a straight line
TITLE_MAX = 60
FORMATS = ("png", "svg", "pdf")


def draw_plan(plan: Plan, image_format: str) -> bytes:
    """The picture as a file of the given format.

    Sessions are shaded, closest approaches and limits dashed.
    """
    if image_format not in FORMATS:
        raise InvalidInput(
            f"{image_format!r} is no picture format; use one of {', '.join(FORMATS)}",
            field="--plot",
        )
    figure = Figure(figsize=(10.0, 8.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    motion = _motion(plan)
    limits = plan.scenario.platform.axis_limits
    for order, (panel, label) in enumerate(
        zip(panels, ("angle, deg", "rate, deg/s", "acceleration, deg/s²"), strict=True)
    ):
        _shade_sessions(panel, plan)
        for axis, (name, colour) in enumerate(
            zip(plan.table.axis_names, AXIS_COLOURS, strict=True)
        ):
            t_s, value_deg = motion[order]
            panel.plot(t_s, value_deg[:, axis], color=colour, linewidth=1.6, label=name)
        _mark_closest_approaches(panel, plan)
        _draw_limits(panel, [_bounds_deg(axis)[order] for axis in limits], np.abs(value_deg).max())
        panel.set_ylabel(label)
        panel.grid(color="#e4e4e4", linewidth=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", frameon=False, ncols=len(labels))
    panels[-1].set_xlabel(f"seconds after {utc_text(plan.table.epoch_utc, 1)}")
    panels[-1].set_xlim(plan.table.t_s[0], plan.table.t_s[-1])
    title = plan.scenario.name or "Plan"
    panels[0].set_title(
        f"{title[:TITLE_MAX]} ({plan.scenario.platform.name[:TITLE_MAX]})",
        loc="left",
        fontweight="bold",
        parse_math=False,
    )
    picture = io.BytesIO()
    figure.savefig(picture, format=image_format, dpi=120)
    return picture.getvalue()


def _motion(plan: Plan) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Times and degrees of angle, rate, acceleration as flown: the Hermite between rows."""
    t_s = plan.table.t_s
    spline = CubicHermiteSpline(t_s, plan.table.angle_rad, plan.table.rate_rad_s)
    edges_s = np.column_stack([t_s[:-1] + CELL_EDGE_S, t_s[1:] - CELL_EDGE_S]).ravel()
    return [
        (t_s, np.degrees(plan.table.angle_rad)),
        (t_s, np.degrees(plan.table.rate_rad_s)),
        (edges_s, np.degrees(spline(edges_s, nu=2))),
    ]


def _bounds_deg(limits: AxisLimits) -> tuple[tuple[float, float], ...]:
    bounds_rad = (
        (limits.angle_min_rad, limits.angle_max_rad),
        (-limits.rate_max_rad_s, limits.rate_max_rad_s),
        (-limits.acceleration_max_rad_s2, limits.acceleration_max_rad_s2),
    )
    return tuple((math.degrees(low), math.degrees(high)) for low, high in bounds_rad)


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


def _mark_closest_approaches(panel: Axes, plan: Plan) -> None:
    """Of sessions that look at the Earth; not where a session begins or ends closest."""
    label: str | None = "closest approach"
    for session in plan.verification.sessions:
        if not isinstance(session.view, EarthFixedView):
            continue
        closest_utc = session.view.range_min_utc
        begun_s = elapsed_s(closest_utc, session.start_utc)
        if 0.0 < begun_s < elapsed_s(session.stop_utc, session.start_utc):
            at_s = elapsed_s(closest_utc, plan.table.epoch_utc)
            panel.axvline(at_s, color=CLOSEST_COLOUR, label=label, **DASHED)
            label = None


def _shade_sessions(panel: Axes, plan: Plan) -> None:
    epoch_utc = plan.table.epoch_utc
    for session in plan.scenario.sessions:
        panel.axvspan(
            elapsed_s(session.start, epoch_utc),
            elapsed_s(session.stop, epoch_utc),
            color=SESSION_COLOUR,
            zorder=0,
            label="session" if session is plan.scenario.sessions[0] else None,
        )
