"""The figure of an imaging session: look angles, body rates and gimbals."""

from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.header_text import one_line
from planner.output.export.figure_parts import (
    DASHED,
    LIMIT_COLOUR,
    POINTS_MAX,
    TITLE_MAX,
    panels_over_time,
    picture_file,
    shade_spans,
    shown_text,
)
from planner.output.export.map_features import thinned
from planner.spacecraft.export.ground import SessionGround
from planner.spacecraft.export.session_table import SessionTable
from planner.spacecraft.export.tables import session_notes
from planner.spacecraft.table import TICK_S

_COLOURS = ("#0b5fa5", "#c8501e", "#3a7d44", "#7b5aa6")
_PANELS = (
    ("optical axis, deg", ("along the track", "across")),
    ("body rate, deg/s", ("x", "y", "z")),
    ("gimbal angle, deg", ("1", "2", "3", "4")),
    ("gimbal rate, deg/s", ("1", "2", "3", "4")),
)


def write_png(plan: SessionTable, created_utc: datetime) -> bytes:
    """1200 pixels wide."""
    return draw_session(plan, "png", created_utc)


def write_svg(plan: SessionTable, created_utc: datetime) -> bytes:
    """Text stays text."""
    return draw_session(plan, "svg", created_utc)


def draw_session(plan: SessionTable, image_format: str, created_utc: datetime) -> bytes:
    """The picture as a file of the given format; imaging is shaded, the rate limit dashed."""
    table = plan.table
    row = thinned(len(table.t_s), POINTS_MAX)
    title = plan.request.name or "Imaging session"
    figure, panels = panels_over_time(
        (label for label, _ in _PANELS),
        f"{shown_text(title, TITLE_MAX)} ({shown_text(plan.spacecraft.name, TITLE_MAX)})",
        table.epoch_utc,
        table.t_s[0],
        table.t_s[-1],
    )
    windows = [(w.first_row * TICK_S, w.last_row * TICK_S, w.request) for w in table.windows]
    shade_spans(panels, windows, "imaging")
    columns: tuple[Array, ...] = (
        np.stack(SessionGround(plan, row).look_angles_rad(), axis=1),
        table.omega_body_rad_s[row],
        table.gimbal_rad[row],
        table.gimbal_rate_rad_s[row],
    )
    for panel, (_, names), values_rad in zip(panels, _PANELS, columns, strict=True):
        for part, name in enumerate(names):
            panel.plot(
                table.t_s[row],
                np.degrees(values_rad[:, part]),
                color=_COLOURS[part],
                linewidth=1.4,
                label=name,
            )
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    limit_deg_s = np.degrees(plan.spacecraft.slew.rate_axis_rad_s)
    for bound in (-limit_deg_s, limit_deg_s):
        panels[1].axhline(bound, color=LIMIT_COLOUR, **DASHED)
    return picture_file(figure, image_format, one_line(title), session_notes(plan, created_utc))
