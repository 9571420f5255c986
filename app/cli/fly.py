"""`slewtrack fly`: a plan is made and flown many times, here or by a running service."""

import json as json_text
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.files import RequestFile, WholeAnswer, problem_to, read_request, takes_standard_output
from app.cli.files import write as write_file
from app.cli.progress_bar import OnProgress, progress_bar, reported_work
from app.cli.report_parts import report_console
from planner.base.errors import InvalidInput

if TYPE_CHECKING:
    from app.answers.flights import FlightsFound
    from app.work.flights import NewFlights

PICTURES = ("png", "svg", "pdf")


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
        image_format = _image_format(plot)
        body, _ = read_request(file)
        moving_object = (
            None
            if moving_object_m_s is None
            else {"speed_m_s": moving_object_m_s, "course_deg": course_deg}
        )
        asked = json_text.dumps(
            {"runs": runs, "seed": seed, "moving_object": moving_object}
        ).encode()

        from app.cli.fly_report import print_flights

        found = _fly_here(body, asked) if url is None else _fly_there(url, body, asked)
        print_flights(console, found)
        if plot:
            from app.cli.fly_figure import draw_flights

            write_file(plot, draw_flights(found, image_format))
        if json:
            write_file(json, json_text.dumps(found).encode() + b"\n")


def _image_format(plot: Path | None) -> str:
    image_format = plot.suffix.lstrip(".") or "png" if plot else "png"
    if image_format not in PICTURES:
        raise InvalidInput(
            f"must end in one of {', '.join(PICTURES)}, not {image_format!r}", field="--plot"
        )
    return image_format


def _fly_there(url: str, body: bytes, asked: bytes) -> Mapping[str, Any]:
    from app.cli.service import service, told_progress
    from app.requests.flights import read_flights_request

    read_flights_request(asked)  # before anything is planned
    with service(url) as client, told_progress() as tell:
        plan = client.plan(body, progress=tell)
        return client.fly(plan.id, asked, progress=tell).members


def _fly_here(body: bytes, asked: bytes) -> Mapping[str, Any]:
    from app.requests.flights import read_flights_request

    read_flights_request(asked)

    from app.store.ids import new_id
    from app.work.flights import PlanToFly, prepare_flights
    from app.work.plan import plan_and_pack

    with reported_work("planning"):
        plan = plan_and_pack(body)
        what = PlanToFly(
            plan_id=new_id(), asked=asked, request=body, table_columns=plan.table_columns
        )
        new = prepare_flights(what.to_bytes())
    with progress_bar("runs") as tell:
        found = _fly_parts(new, tell)

    from app.answers.members import to_json

    members: Mapping[str, Any] = json_text.loads(to_json(found))
    return members


def _fly_parts(new: "NewFlights", tell: OnProgress) -> "FlightsFound":
    """On all processors, each part in a child."""
    import zlib

    from app.answers.flights import FlightsHead, flights_found
    from app.answers.members import from_store
    from app.jobs.executors import LocalExecutor, Task
    from app.jobs.kinds import RUNS
    from app.jobs.worker_process import Stop
    from app.work.flights import fly_part, unpacked_outcomes
    from app.work.progress import Progress

    head = from_store(FlightsHead, json_text.loads(zlib.decompress(new.document)))
    done = [0] * len(new.parts)

    def told_by(part: int, progress: Progress) -> None:
        done[part] = progress.done or 0
        tell("runs", sum(done), head.runs)

    stops = [Stop() for _ in new.parts]
    executor = LocalExecutor(min(len(new.parts), os.cpu_count() or 1))
    try:
        futures = [
            executor.submit(
                Task(job_id=str(number), bounds=RUNS.bounds, work=fly_part, body=body),
                stop,
                lambda progress, number=number: told_by(number, progress),  # type: ignore[misc]
            )
            for number, (body, stop) in enumerate(zip(new.parts, stops, strict=True))
        ]
        outcomes = [unpacked_outcomes(future.result()) for future in futures]
    finally:
        for stop in stops:
            stop.request()
        executor.close()
    return flights_found(head, outcomes)
