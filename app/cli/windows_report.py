"""The summary of opportunities on the terminal, and their CSV for a spreadsheet."""

from dataclasses import fields

from rich.console import Console
from rich.table import Table
from rich.text import Text

from app.answers.opportunities import SightingOut, WindowOut
from app.cli.report_parts import or_dash, print_assumed, print_table, print_warnings, report_table
from planner.base.csv_cells import csv_lines
from planner.planning.opportunities import Opportunities

SHOWN_MAX = 100
FAR_KM = 1e5


def print_windows(console: Console, result: Opportunities, windows: list[WindowOut]) -> None:
    """One line per window, seen at its closest approach; the first SHOWN_MAX of them."""
    console.print(
        Text.assemble((f"{len(windows)} windows", "bold"), f" of {len(result.ids)} targets")
    )
    print_assumed(console, ((one.field, one.detail) for one in result.assumed))
    print_table(console, _table(result.axis_names, windows[:SHOWN_MAX]))
    if len(windows) > SHOWN_MAX:
        console.print(f"and {len(windows) - SHOWN_MAX} more: see --csv or --json")
    print_warnings(console, result.warnings)


def _table(axis_names: tuple[str, str], windows: list[WindowOut]) -> Table:
    table = report_table(
        "edges UTC, the rest at closest approach",
        "<target",
        "<rise",
        "<set",
        *("elev", "km", "m/px", "Sun", *axis_names),
    )
    for window in windows:
        seen = window.closest
        table.add_row(
            Text(window.target),
            window.rise[:10] + " " + window.rise[11:-5],
            window.set[11:-5],
            f"{seen.elevation_deg:.1f}",
            or_dash(seen.range_km, ".3g" if (seen.range_km or 0.0) > FAR_KM else ".0f"),
            or_dash(seen.ground_sample_across_m, ".2f"),
            or_dash(seen.sun_elevation_deg, ".0f"),
            *(or_dash(seen.angles_deg[axis], ".1f") for axis in axis_names),
        )
    return table


def windows_csv(axis_names: tuple[str, str], windows: list[WindowOut]) -> str:
    """One line per window: its edges, then the view at its closest approach."""
    edges = ("target", "rise", "set", "duration_s", "opened_by", "closed_by", "highest_deg")
    by_axis = ("angles_deg", "rates_deg_s")
    view = [field.name for field in fields(SightingOut) if field.name not in by_axis]
    angles = [f"{axis}_deg" for axis in axis_names]
    rates = [f"{axis}_rate_deg_s" for axis in axis_names]
    rows: list[list[object]] = [[*edges, *(f"closest_{name}" for name in (*view, *angles, *rates))]]
    for window in windows:
        seen = window.closest
        rows.append(
            [
                *(getattr(window, name) for name in edges),
                *(getattr(seen, name) for name in view),
                *(seen.angles_deg[axis] for axis in axis_names),
                *(seen.rates_deg_s[axis] for axis in axis_names),
            ]
        )
    return csv_lines(rows)
