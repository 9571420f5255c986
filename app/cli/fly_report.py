"""The report of flights on the terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from app.cli.report_parts import or_dash, print_table, print_warnings, report_table

Members = Mapping[str, Any]  # of a FlightsFound, this command's or a service's


def print_flights(console: Console, found: Members) -> None:
    """Probabilities, sessions, what is to blame, warnings."""
    console.print(
        Text.assemble(
            (f"{found['flown']} flights", "bold"),
            f" (seed {found['seed']}): all frames hold their target with a probability of ",
            (_probability(found["probability_in_frame"], found["in_frame_interval"]), "bold"),
            ", sharp as well ",
            (_probability(found["probability_sharp"], found["sharp_interval"]), "bold"),
            "; between brackets 95 % confidence",
        )
    )
    print_table(console, _sessions(found))
    print_table(console, _as_planned(found))
    print_table(console, _contributors(found["contributors"]))
    print_warnings(console, found["warnings"])


def _probability(value: float | None, share_interval: list[float] | None) -> str:
    if value is None or share_interval is None:
        return "-"
    return f"{value:.3f} ({share_interval[0]:.3f}..{share_interval[1]:.3f})"


def _sessions(found: Members) -> Table:
    table = report_table(
        "under errors",
        "session",
        "<target",
        "told",
        "in frame",
        "sharp",
        "frames held",
        "frames sharp",
        "smear px",
        "miss m",
    )
    for one in found["sessions"]:
        table.add_row(
            str(one["session"] + 1),
            Text(one["label"]),
            f"{one['budget_probability_in_frame']:.3f}",
            _probability(one["probability_in_frame"], one["in_frame_interval"]),
            _probability(one["probability_sharp"], one["sharp_interval"]),
            or_dash(one["frames_held"], ".1%"),
            or_dash(one["frames_sharp"], ".1%"),
            or_dash(one["smear_px"][1] if one["smear_px"] else None, ".2f"),
            or_dash(one["miss_m"][1] if one["miss_m"] else None, ".0f"),
        )
    return table


def _as_planned(found: Members) -> Table:
    table = report_table(
        "as planned",
        "session",
        "frames",
        "held",
        "sharp",
        "error arcsec",
        "smear px",
        "sample m",
        "object px",
    )
    for one in found["sessions"]:
        nominal = one["nominal"]
        samples_m, moved_px = nominal["ground_sample_across_m"], nominal["moving_object_px"]
        table.add_row(
            str(one["session"] + 1),
            str(nominal["frames"]),
            str(nominal["held"]),
            str(nominal["sharp"]),
            f"{max(nominal['error_arcsec']):.2f}",
            f"{max(nominal['smear_px']):.2f}",
            or_dash(min(samples_m) if samples_m else None, ".2f"),
            f"{min(moved_px):.0f}..{max(moved_px):.0f}" if moved_px else "-",
        )
    return table


def _contributors(contributors: list[Members]) -> Table:
    table = report_table("to blame", "<cause", "of misses", "+-", "of smear", "+-")
    for one in contributors:
        table.add_row(
            one["cause"],
            f"{one['share']:.1%}",
            f"{one['share_sigma']:.1%}",
            f"{one['smear_share']:.1%}",
            f"{one['smear_share_sigma']:.1%}",
        )
    return table
