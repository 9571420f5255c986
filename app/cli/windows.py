"""`slewtrack windows`: times at which targets can be seen, found here or by a running service."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from app.cli import files
from app.cli import report_parts as parts
from app.cli.planner import Members, planner_at, told_progress
from planner.base.csv_cells import csv_lines
from slewtrack.client import next_pass
from slewtrack.client.answers import Include

_FAR_KM = 1e5
_EDGES = (
    *("target", "rise", "set", "duration_s", "opened_by", "closed_by", "highest_deg"),
    "probability_in_frame",
)
_ANGLES = "angles_deg"  # by the names of two axes, or along and across a body's track
_BY_NAME = {_ANGLES: "_deg", "rates_deg_s": "_rate_deg_s"}


def windows(
    file: files.RequestFile,
    csv: Annotated[
        Path | None, typer.Option(help="Write one line per window here, at its closest approach.")
    ] = None,
    json: files.WholeAnswer = None,
    probability: Annotated[
        bool, typer.Option(help="Report how likely the target stays in the frame: 3 ms a window.")
    ] = True,
    settings: files.Settings = None,
    url: files.Url = None,
) -> None:
    """Search for windows of targets."""
    with files.report_beside(json, csv) as console:
        body = files.read_request(file, settings)
        told: Include = ("view", "probability", "reasons") if probability else next_pass.TOLD
        with planner_at(url) as planner, told_progress("opportunities"):
            found = planner.opportunities(body, include=told)
        print_windows(console, found.members)
        if url is not None:
            console.print(f"kept as {found.id}")
        if csv:
            files.write(csv, windows_csv(found.members["windows"]).encode())
        files.write_json(json, found.members)


def print_windows(console: Console, found: Members) -> None:
    windows = found["windows"]
    targets = len({window["target"] for window in windows}) + len(found["unseen"])
    console.print(Text.assemble((f"{len(windows)} windows", "bold"), f" of {targets} targets"))
    parts.print_assumed(console, found["assumed"])
    parts.print_rows(
        console, "edges UTC, the rest at closest approach", windows[: parts.SHOWN_MAX],
        ("<target", "target"),
        ("<rise", lambda window: f"{window['rise'][:10]} {window['rise'][11:-5]}"),
        ("<set", lambda window: window["set"][11:-5]), ("elev", "closest.elevation_deg", ".1f"),
        ("km", "closest.range_km", _kilometres), ("m/px", "closest.ground_sample_across_m", ".2f"),
        ("Sun", "closest.sun_elevation_deg", ".0f"),
        *((one, _angle_of(one), ".1f") for one in _angle_names(windows)),
        ("in frame", lambda window: window.get("probability_in_frame"), ".2f"), keys=2,
    )  # fmt: skip
    parts.print_more(console, len(windows))
    parts.print_reasons(console, "can't be seen", found["reasons"])
    parts.print_warnings(console, found["warnings"])


def _angle_names(windows: Sequence[Members]) -> Sequence[str]:
    return [*windows[0]["closest"][_ANGLES]] if windows else ()


def _angle_of(name: str) -> Callable[[Members], object]:
    return lambda window: window["closest"][_ANGLES][name]


def _kilometres(range_km: float | None) -> str:
    return "-" if range_km is None else format(range_km, ".3g" if range_km > _FAR_KM else ".0f")


def windows_csv(windows: Sequence[Members]) -> str:
    """One line per window: its edges, then the view at its closest approach."""
    from planner.output.windows.rows import SIGHTING

    view = [name for name in SIGHTING if name not in _BY_NAME]
    by_name = [f"{one}{unit}" for unit in _BY_NAME.values() for one in _angle_names(windows)]
    rows = (
        [
            *(window.get(name) for name in _EDGES),
            *(seen[name] for name in view),
            *(seen[kind][one] for kind in _BY_NAME for one in seen[kind]),
        ]
        for window in windows
        for seen in [window["closest"]]
    )
    heading = [*_EDGES, *(f"closest_{name}" for name in (*view, *by_name))]
    return csv_lines([heading, *rows])
