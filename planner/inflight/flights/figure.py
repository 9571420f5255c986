"""The picture of flights: what frames show as planned, and how far runs miss."""

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from planner.output.export.figure_parts import DASHED, LIMIT_COLOUR, picture_file, utc_ticks
from planner.world.frames.time_scales import utc_from_text

_COLOUR, _MISSES = "#0b5fa5", "#c8501e"


def draw_flights(found: Mapping[str, Any], image_format: str) -> bytes:
    """Of an answer, a row a session: what its frames show as planned, a histogram of the misses."""
    sessions = found["sessions"]
    figure = Figure(figsize=(12.0, 3.2 * len(sessions)), layout="constrained")
    rows = figure.subplots(len(sessions), 3, squeeze=False)
    epoch_utc = utc_from_text(found["epoch"])
    for one, (smear, error, misses) in zip(sessions, rows, strict=True):
        nominal, t_s = one["nominal"], one["nominal"]["t_s"]
        for panel, values, label in (
            (smear, nominal["smear_px"], "smear as planned, pixels"),
            (error, nominal["error_arcsec"], "error as planned, arcsec"),
        ):
            _label(panel, label)
            panel.plot(t_s, values, color=_COLOUR, linewidth=1.0)
            ticks_s, texts = utc_ticks(epoch_utc, t_s[0], t_s[-1])
            panel.set_xticks(ticks_s[::2], texts[::2])
            panel.set_ylim(bottom=0.0)
        smear.axhline(1.0, color=LIMIT_COLOUR, **DASHED)
        smear.set_title(
            f"session {one['session'] + 1}: {one['label']}", loc="left", parse_math=False
        )
        if (missed := one["misses"]) is not None:
            _label(misses, f"of {found['flown']} runs")
            misses.stairs(missed["counts"], missed["edges_arcsec"], fill=True, color=_MISSES)
            misses.set_xlabel(f"largest miss, arcsec ({missed['beyond']} runs beyond)")
    title = f"{found['flown']} flights, seed {found['seed']}"
    return picture_file(figure, image_format, title, found["warnings"])


def _label(panel: Axes, label: str) -> None:
    panel.set_ylabel(label)
    panel.grid(color="#e4e4e4", linewidth=0.6)
    panel.spines[["top", "right"]].set_visible(False)
