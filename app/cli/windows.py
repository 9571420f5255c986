"""`slewtrack windows`: times at which targets can be seen."""

import json as json_text
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from app.cli.files import (
    RequestFile,
    WholeAnswer,
    problem_to,
    read_request,
    takes_standard_output,
    write,
)
from app.cli.planner import Members
from app.cli.progress_bar import reported_work
from app.cli.report_parts import (
    SHOWN_MAX,
    print_assumed,
    print_more,
    print_rows,
    print_warnings,
    report_console,
)
from planner.base.csv_cells import csv_lines

_FAR_KM = 1e5
_EDGES = ("target", "rise", "set", "duration_s", "opened_by", "closed_by", "highest_deg")


def windows(
    file: RequestFile,
    csv: Annotated[
        Path | None, typer.Option(help="Write one line per window here, at its closest approach.")
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """Search for windows of targets."""
    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(csv, json))
        body, read_utc = read_request(file)

        from app.requests.opportunities import read_opportunity_request

        request = read_opportunity_request(body)

        from app.answers.members import provenance
        from app.answers.opportunities import whole_opportunities
        from app.ids import new_id
        from app.work.campaign import answer_opportunities

        with reported_work("searching"):
            found = answer_opportunities(request, provenance(read_utc, body))
        axis_names, count = request.platform.axis_names, len(found.windows)
        told = Text.assemble((f"{count} windows", "bold"), f" of {len(request.targets)} targets")
        console.print(told)
        shown = map(json_text.loads, found.windows[:SHOWN_MAX])
        print_windows(console, axis_names, json_text.loads(found.head), shown, count)
        if csv:
            lines = windows_csv(axis_names, map(json_text.loads, found.windows))
            write(csv, lines.encode())
        if json:
            write(json, whole_opportunities(new_id(), found))


def print_windows(
    console: Console,
    axis_names: Sequence[str],
    head: Members,
    shown: Iterable[Members],
    count: int,
) -> None:
    """One line per window, seen at its closest approach."""
    print_assumed(console, head["assumed"])
    print_rows(
        console, "edges UTC, the rest at closest approach", shown,
        ("<target", "target"),
        ("<rise", lambda window: f"{window['rise'][:10]} {window['rise'][11:-5]}"),
        ("<set", lambda window: window["set"][11:-5]), ("elev", "closest.elevation_deg", ".1f"),
        ("km", "closest.range_km", _kilometres), ("m/px", "closest.ground_sample_across_m", ".2f"),
        ("Sun", "closest.sun_elevation_deg", ".0f"),
        *((axis, partial(_angle_deg, axis), ".1f") for axis in axis_names),
    )  # fmt: skip
    print_more(console, count)
    print_warnings(console, head["warnings"])


def _angle_deg(axis: str, window: Members) -> object:
    return window["closest"]["angles_deg"][axis]


def _kilometres(range_km: float | None) -> str:
    return "-" if range_km is None else format(range_km, ".3g" if range_km > _FAR_KM else ".0f")


def windows_csv(axis_names: Sequence[str], windows: Iterable[Members]) -> str:
    """One line per window: its edges, then the view at its closest approach."""
    return csv_lines(_csv_rows(axis_names, windows))


def _csv_rows(axis_names: Sequence[str], windows: Iterable[Members]) -> Iterator[list[object]]:
    from dataclasses import fields

    from app.answers.opportunities import SightingOut

    by_axis = ("angles_deg", "rates_deg_s")
    view = [field.name for field in fields(SightingOut) if field.name not in by_axis]
    angles = [f"{axis}_deg" for axis in axis_names]
    rates = [f"{axis}_rate_deg_s" for axis in axis_names]
    yield [*_EDGES, *(f"closest_{name}" for name in (*view, *angles, *rates))]
    for window in windows:
        seen = window["closest"]
        yield [
            *(window[name] for name in _EDGES),
            *(seen[name] for name in view),
            *(seen[kind][axis] for kind in by_axis for axis in axis_names),
        ]
