"""`slewtrack fly`: a plan is made and flown many times, here or by a running service."""

import json as json_text
from pathlib import Path
from typing import Annotated

import typer

from app.cli.files import (
    RequestFile,
    WholeAnswer,
    picture_format,
    problem_to,
    read_request,
    takes_standard_output,
    write,
    write_json,
)
from app.cli.planner import planner_at
from app.cli.progress_bar import told_progress
from app.cli.report_parts import report_console


def fly(
    file: RequestFile,
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
    json: WholeAnswer = None,
    url: Annotated[
        str | None,
        typer.Option(help="Plan and fly at this service, which keeps both: http://127.0.0.1:8000."),
    ] = None,
) -> None:
    """Plan, fly the plan many times with errors drawn at random, and report probabilities."""
    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(plot, json))
        image_format = picture_format(plot)
        body, _ = read_request(file)
        vehicle = {"speed_m_s": moving_object_m_s, "course_deg": course_deg}
        moving_object = None if moving_object_m_s is None else vehicle
        asked = json_text.dumps(
            {"runs": runs, "seed": seed, "moving_object": moving_object}
        ).encode()

        from app.requests.flights import read_flights_request

        read_flights_request(asked)  # before anything is planned
        with planner_at(url) as planner, told_progress("planning") as tell:
            plan = planner.plan(body, progress=tell)
            told = planner.fly(plan.id, asked, progress=tell).members

        from app.cli.fly_report import print_flights

        print_flights(console, told)
        if plot and image_format:
            from app.cli.fly_figure import draw_flights

            write(plot, draw_flights(told, image_format))
        write_json(json, told)
