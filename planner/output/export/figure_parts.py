"""Parts that the figures of all plans share: panels over UTC, shaded spans, the file."""

from __future__ import annotations

import io
from collections.abc import Iterable
from datetime import datetime
from typing import TYPE_CHECKING, Any

from planner.base.errors import InvalidInput
from planner.world.frames.time_scales import shifted_utc, utc_text

if TYPE_CHECKING:  # matplotlib takes 0.3 s to import, which only a figure should pay
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPAN_COLOUR = "#f3e9c6"
LIMIT_COLOUR = "#8a8a8a"
DASHED: dict[str, Any] = {"linestyle": (0, (6, 4)), "linewidth": 1.0}
NAME_MAX, TITLE_MAX = 18, 60
POINTS_MAX = 6000  # more than there are pixels
FORMATS = ("png", "svg", "pdf")
_TICKS_MAX = 8
_TICK_STEPS_S = (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 21600)
_DAY_S = 86400
_ACROSS = 120  # characters of a name's size side by side over a panel


def panels_over_time(
    labels: Iterable[str], title: str, epoch_utc: datetime, start_s: float, stop_s: float
) -> tuple[Figure, list[Axes]]:
    """One panel a label, above each other; times are seconds after the epoch, told in UTC."""
    from matplotlib.figure import Figure

    labels = list(labels)
    figure = Figure(figsize=(10.0, 2.67 * len(labels)), layout="constrained")
    panels = list(figure.subplots(len(labels), 1, sharex=True, squeeze=False)[:, 0])
    for panel, label in zip(panels, labels, strict=True):
        panel.set_ylabel(label)
        panel.grid(color="#e4e4e4", linewidth=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    ticks_s, texts = utc_ticks(epoch_utc, start_s, stop_s)
    panels[-1].set_xticks(ticks_s, texts)
    panels[-1].set_xlim(start_s, stop_s)
    panels[-1].set_xlabel(f"UTC on {utc_text(shifted_utc(epoch_utc, start_s))[:10]}")
    panels[0].set_title(title, loc="left", fontweight="bold", parse_math=False, pad=18)
    return figure, panels


def utc_ticks(epoch_utc: datetime, start_s: float, stop_s: float) -> tuple[list[float], list[str]]:
    """Full seconds, minutes or hours of UTC, as seconds after the epoch, and their texts."""
    step_s = next(
        (step for step in _TICK_STEPS_S if (stop_s - start_s) / step <= _TICKS_MAX), _DAY_S
    )
    of_day_s = (
        3600 * epoch_utc.hour
        + 60 * epoch_utc.minute
        + epoch_utc.second
        + epoch_utc.microsecond / 1e6
    )
    first = -int(-(of_day_s + start_s) // step_s) * step_s - of_day_s
    ticks_s = []
    while first <= stop_s:
        ticks_s.append(first)
        first += step_s
    return ticks_s, [utc_text(shifted_utc(epoch_utc, t_s), 0)[11:19] for t_s in ticks_s]


def shown_text(text: str, most: int) -> str:
    """Of any script, on one line, without what can't be drawn."""
    plain = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return plain if len(plain) <= most else plain[: most - 1] + "…"


def shade_spans(panels: list[Axes], spans: Iterable[tuple[float, float, str]], label: str) -> None:
    """From start to stop of each, its name above the first panel where there is room.

    label: what they are, for the first panel's legend.
    """
    spans = list(spans)
    for panel in panels:
        for number, (start_s, stop_s, _) in enumerate(spans):
            is_told = panel is panels[0] and not number
            panel.axvspan(
                start_s, stop_s, color=SPAN_COLOUR, zorder=0, label=label if is_told else None
            )
    first_s, last_s = panels[0].get_xlim()
    middles_s = [0.5 * (start_s + stop_s) for start_s, stop_s, _ in spans]
    for middle_s, (_, _, name) in zip(middles_s, spans, strict=True):
        away_s = (abs(middle_s - other_s) for other_s in middles_s if other_s != middle_s)
        character_s = (last_s - first_s) / _ACROSS
        most = int(min(away_s, default=last_s - first_s) / character_s)
        if most < 8:  # that little can't be read
            continue
        shown = shown_text(name, most)
        half_s = 0.5 * len(shown) * character_s
        panels[0].text(
            min(max(middle_s, first_s + half_s), last_s - half_s),
            1.01,
            shown,
            transform=panels[0].get_xaxis_transform(),
            ha="center",
            va="bottom",
            fontsize=8,
            parse_math=False,
        )


def legend_below(figure: Figure, panel: Axes) -> None:
    """What a panel's lines are."""
    handles, labels = panel.get_legend_handles_labels()
    labels = [shown_text(label, NAME_MAX) for label in labels]
    legend = figure.legend(
        handles, labels, loc="outside lower center", frameon=False, ncols=len(labels)
    )
    for text in legend.get_texts():
        text.set_parse_math(False)


def picture_file(figure: Figure, image_format: str, title: str, notes: Iterable[str]) -> bytes:
    """Its bytes, the same for the same figure; the notes are in its metadata.

    Raises InvalidInput for a format there is none of.
    """
    if image_format not in FORMATS:
        raise InvalidInput(
            f"{image_format!r} is no picture format; use one of {', '.join(FORMATS)}",
            field="--plot",
        )
    from matplotlib import rc_context

    told = "\n".join(notes)
    metadata: dict[str, dict[str, str | None]] = {
        "png": {"Title": title, "Description": told, "Software": "slewtrack"},
        "svg": {"Title": title, "Description": told, "Creator": "slewtrack", "Date": None},
        "pdf": {"Title": title, "Subject": told, "Creator": "slewtrack", "CreationDate": None},
    }
    picture = io.BytesIO()
    with rc_context({"svg.hashsalt": "slewtrack", "svg.fonttype": "none"}):
        figure.savefig(picture, format=image_format, dpi=120, metadata=metadata[image_format])
    return picture.getvalue()
