"""The summary of a plan on the terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from app.cli.report_parts import (
    or_dash,
    print_assumed,
    print_table,
    print_warnings,
    report_table,
)
from planner.world.frames.time_scales import elapsed_s, utc_from_text

_MS_PER_S = 1e3
_Members = Mapping[str, Any]


def print_report(console: Console, plan: _Members, epoch: str, rows: int) -> None:
    """What was taken for granted, segments, pointing error, margins, the spline, warnings."""
    total_ms = _MS_PER_S * sum(plan["solver"]["stages_wall_s"].values())
    console.print(
        Text.assemble(
            (plan["name"] or "Plan", "bold"),
            f", {plan['platform']}: {rows} rows from {epoch}, planned in {total_ms:.0f} ms",
        )
    )
    print_assumed(console, ((one["field"], one["detail"]) for one in plan["assumed"]))
    parts = (
        _segments(plan),
        _pointing(plan["pointing"]),
        _uncertainty(plan),
        _margins(plan),
        _keep_out(plan),
        _masks(plan),
        _comparison(plan),
        _vibration(plan),
    )
    for part in parts:
        print_table(console, part)
    print_warnings(console, plan["warnings"])
    passed = plan["verification"]["passed"]
    console.print(
        Text(f"verification {'passed' if passed else 'FAILED'}", style="green" if passed else "red")
    )


def _segments(plan: _Members) -> Table:
    table = report_table("segments", "<kind", "session", "<start", "<stop", "seconds")
    for segment in plan["segments"]:
        start, stop = utc_from_text(segment["start"]), utc_from_text(segment["stop"])
        table.add_row(
            segment["kind"],
            _session(segment["session"]),
            segment["start"],
            segment["stop"],
            f"{elapsed_s(stop, start):.1f}",
        )
    return table


def _pointing(pointing: list[_Members]) -> Table:
    columns = {
        "session": [_session(session["session"]) for session in pointing],
        "max arcsec": [f"{session['max_arcsec']:.3g}" for session in pointing],
        "rms arcsec": [f"{session['rms_arcsec']:.3g}" for session in pointing],
        "ground m": [or_dash(session["ground_max_m"], ".2g") for session in pointing],
        "least elevation deg": [
            or_dash(session["elevation_min_deg"], ".2f") for session in pointing
        ],
        "least range km": [or_dash(session["range_min_km"], ".6g") for session in pointing],
        "above the limb deg": [
            or_dash(session["limb_clearance_min_deg"], ".2f") for session in pointing
        ],
    }
    columns = {heading: texts for heading, texts in columns.items() if set(texts) != {"-"}}
    table = report_table("pointing error", *columns)
    for row in zip(*columns.values(), strict=True):
        table.add_row(*row)
    return table


def _uncertainty(plan: _Members) -> Table:
    table = report_table(
        "pointing budget, 1 sigma",
        "session",
        "arcsec",
        "ground m",
        "stays in the frame",
        "<most of it by",
        wrapped="most of it by",
    )
    for budget in plan["uncertainty"]:
        worst = max(budget["contributions"], key=lambda part: part["sigma_arcsec"])
        table.add_row(
            _session(budget["session"]),
            f"{budget['sigma_arcsec']:.0f}",
            or_dash(budget["ground_m"], ".0f"),
            f"{budget['probability_in_frame']:.1%}",
            worst["cause"],
        )
    return table


def _margins(plan: _Members) -> Table:
    table = report_table(
        "least margins", "<axis", "<limit of", "limit", "closest", "margin", "<unit", "<at UTC"
    )
    for axis, margins in plan["margins"].items():
        for name, margin in margins.items():
            table.add_row(
                axis,
                name,
                f"{margin['limit']:.6g}",
                f"{margin['extreme']:.6g}",
                f"{margin['margin']:.6g}",
                margin["unit"],
                margin["at"][11:-3],  # to a tenth of a second
                style="red" if margin["margin"] < 0.0 else None,
            )
    return table


def _keep_out(plan: _Members) -> Table:
    table = report_table(
        "cones to keep out of", "<about", "half angle deg", "closest deg", "<at UTC"
    )
    for cone in plan["keep_out"]:
        table.add_row(
            Text(cone["about"]),
            f"{cone['half_angle_deg']:g}",
            or_dash(cone["away_min_deg"], ".3f"),
            "-" if cone["at"] is None else cone["at"][11:-3],
            style="red" if cone["margin_deg"] is not None and cone["margin_deg"] < 0.0 else None,
        )
    return table


def _masks(plan: _Members) -> Table:
    table = report_table("masks to keep out of", "<name", "asked deg", "closest deg", "<at UTC")
    for mask in plan["masks"]:
        table.add_row(
            Text(mask["name"]),
            f"{mask['asked_deg']:g}",
            f"{mask['away_min_deg']:.3f}",
            mask["at"][11:-3],
            style="red" if mask["margin_deg"] < 0.0 else None,
        )
    return table


def _comparison(plan: _Members) -> Table:
    table = report_table(
        "optimal slew against the spline",
        "<slew",
        "<axis",
        "<by",
        "deg/s",
        "deg/s2",
        "deg/s3",
        "jerk², deg²/s⁵",
        "<breaks",
        wrapped="breaks",
    )
    for compared in plan["comparison"]:
        for axis in compared["ocp"]:
            for method, figures in (
                ("ocp", compared["ocp"][axis]),
                ("spline", compared["spline"][axis]),
            ):
                table.add_row(
                    _session(compared["session"]),
                    axis,
                    method,
                    f"{figures['peak_rate_deg_s']:.4f}",
                    f"{figures['peak_acceleration_deg_s2']:.4f}",
                    _or_jump(figures["peak_jerk_deg_s3"]),
                    _or_jump(figures["jerk_squared_integral_deg2_s5"]),
                    ", ".join(figures["limits_broken"]) or "-",
                    style="red" if figures["limits_broken"] else None,
                )
    return table


def _vibration(plan: _Members) -> Table:
    table = report_table(
        "vibration left after the slew", "slew", "<axis", "mode Hz", "ocp arcsec", "spline arcsec"
    )
    for compared in plan["comparison"]:
        for residual in compared["residual_vibration"]:
            for axis, ocp_arcsec in residual["ocp_arcsec"].items():
                table.add_row(
                    _session(compared["session"]),
                    axis,
                    f"{residual['frequency_hz']:g}",
                    f"{ocp_arcsec:.2g}",
                    f"{residual['spline_arcsec'][axis]:.2g}",
                )
    return table


def _session(number: int | None) -> str:
    """Counted from 1, as everything that people read; the answer's own number is an index."""
    return "final" if number is None else str(number + 1)


def _or_jump(value: float | None) -> str:
    return "jump" if value is None else f"{value:.3g}"
