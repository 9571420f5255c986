"""`slewtrack fly`: a plan is made and flown many times, here or by a running service."""

import json as json_text
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from app.cli import files
from app.cli.plan_report import session_number
from app.cli.planner import Members, planner_at, told_progress
from app.cli.report_parts import print_rows, print_warnings


def fly(
    file: files.RequestFile,
    runs: Annotated[int, typer.Option(help="Fly so many runs.")] = 400,
    seed: Annotated[int, typer.Option(help="Draw the errors from this seed.")] = 0,
    moving_object_m_s: Annotated[
        float | None,
        typer.Option(help="Report how far a vehicle of this speed moves in the image in 10 s."),
    ] = None,
    course_deg: Annotated[
        float, typer.Option(help="Set the vehicle's course, clockwise from north.")
    ] = 0.0,
    plot: Annotated[
        Path | None,
        typer.Option(help="Draw smear, error and misses here (png, svg, pdf)."),
    ] = None,
    json: files.WholeAnswer = None,
    settings: files.Settings = None,
    url: files.Url = None,
) -> None:
    """Plan, fly the plan many times with errors drawn at random, and report probabilities."""
    with files.report_beside(json, plot) as console:
        image_format = files.picture_format(plot)
        body = files.read_request(file, settings)
        vehicle = {"speed_m_s": moving_object_m_s, "course_deg": course_deg}
        moving_object = None if moving_object_m_s is None else vehicle
        flights = {"runs": runs, "seed": seed, "moving_object": moving_object}
        asked = json_text.dumps(flights).encode()

        from app.requests.json_reader import JsonReader
        from planner.inflight.flights.request import FlightsRequest

        JsonReader(FlightsRequest).read(asked)  # before anything is planned
        with planner_at(url) as planner, told_progress("planning") as tell:
            plan = planner.plan(body, progress=tell)
            told = planner.fly(plan.id, asked, progress=tell).members
        print_flights(console, told)
        if plot and image_format:
            from planner.inflight.flights.figure import draw_flights

            files.write(plot, draw_flights(told, image_format))
        files.write_json(json, told)


def print_flights(console: Console, found: Members) -> None:
    console.print(
        Text.assemble(
            (f"{found['flown']} flights", "bold"),
            f" (seed {found['seed']}): all frames hold their target with a probability of ",
            (_in_frame(found), "bold"),
            ", sharp as well ",
            (_sharp(found), "bold"),
            "; between brackets 95 % confidence",
        )
    )
    print_rows(
        console, "under errors", found["sessions"],
        ("session", "session", session_number), ("<target", "label"),
        ("told", "budget_probability_in_frame", ".3f"), ("in frame", _in_frame), ("sharp", _sharp),
        ("frames held", "frames_held", ".1%"), ("frames sharp", "frames_sharp", ".1%"),
        ("smear px", lambda one: one["smear_px"] and one["smear_px"][1], ".2f"),
        ("miss m", lambda one: one["miss_m"] and one["miss_m"][1], ".0f"), keys=2,
    )  # fmt: skip
    print_rows(
        console, "as planned",
        ({"session": one["session"], **one["nominal"]} for one in found["sessions"]),
        ("session", "session", session_number), ("frames", "frames"), ("held", "held"),
        ("sharp", "sharp"), ("error arcsec", lambda one: max(one["error_arcsec"]), ".2f"),
        ("smear px", lambda one: max(one["smear_px"]), ".2f"),
        ("sample m", lambda one: min(one["ground_sample_across_m"] or (), default=None), ".2f"),
        ("object px", "moving_object_px",
         lambda px: f"{min(px):.0f}..{max(px):.0f}" if px else "-"),
    )  # fmt: skip
    print_rows(
        console, "causes of the errors", found["contributors"],
        ("<cause", "cause"), ("of misses", "share", ".1%"), ("+-", "share_sigma", ".1%"),
        ("of smear", "smear_share", ".1%"), ("+-", "smear_share_sigma", ".1%"),
    )  # fmt: skip
    print_warnings(console, found["warnings"])


def _in_frame(one: Members) -> str:
    return _probability(one["probability_in_frame"], one["in_frame_interval"])


def _sharp(one: Members) -> str:
    return _probability(one["probability_sharp"], one["sharp_interval"])


def _probability(value: float | None, share_interval: list[float] | None) -> str:
    if value is None or share_interval is None:
        return "-"
    return f"{value:.3f} ({share_interval[0]:.3f}..{share_interval[1]:.3f})"
