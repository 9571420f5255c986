"""Plans that a running service keeps: listed, shown, exported, followed."""

from collections.abc import Callable
from http import HTTPStatus
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from app.cli.files import (
    WholeAnswer,
    formats_and_paths,
    problem_to,
    takes_standard_output,
    write,
    write_json,
)
from app.cli.one_line import FAILED
from app.cli.report_parts import print_rows, report_console

if TYPE_CHECKING:
    from slewtrack.client import Client, Progress

_SECOND = 19  # characters of a time to the second

Url = Annotated[
    str | None,
    typer.Option(
        help="Ask this service; SLEWTRACK_URL by default, or http://127.0.0.1:8000. The API key "
        "is SLEWTRACK_KEY."
    ),
]
Id = Annotated[
    str, typer.Argument(metavar="ID", help="Take this plan, by its id in `slewtrack list`.")
]


def list_plans(
    url: Url = None,
    limit: Annotated[int, typer.Option(min=1, help="List at most so many plans.")] = 20,
    state: Annotated[
        str | None,
        typer.Option(help="List only plans queued, running, done, refused, failed or cancelled."),
    ] = None,
    name: Annotated[str | None, typer.Option(help="List only plans with this in the name.")] = None,
    target: Annotated[
        str | None, typer.Option(help="List only plans with this in a target's name.")
    ] = None,
    text: Annotated[
        str | None,
        typer.Option(help="List only plans with this in the name, the platform's or a target's."),
    ] = None,
    after: Annotated[
        str | None, typer.Option(metavar="UTC", help="List only plans that end after this time.")
    ] = None,
    before: Annotated[
        str | None, typer.Option(metavar="UTC", help="List only plans that begin before this time.")
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """List the plans that a service keeps, the latest first."""
    from app.cli.service import service

    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(json))
        with service(url) as client:
            found = client.plans(
                limit=limit,
                state=state,
                name=name,
                target=target,
                text=text,
                after=after,
                before=before,
            )
        print_rows(
            console, None, [dict(job.members) for job in found],
            ("<id", "id"), ("<state", "state"), ("<created", "created", _to_the_second),
            ("<start", "start", _to_the_second), ("<name", "name"),
            ("~targets", "targets", ", ".join),
        )  # fmt: skip
        if not found:
            console.print("there are none")
        write_json(json, {"plans": [dict(job.members) for job in found]})


def _to_the_second(utc: str | None) -> str:
    return "-" if utc is None else utc[:_SECOND].replace("T", " ")


def show(plan_id: Id, url: Url = None, json: WholeAnswer = None) -> None:
    """Show a plan that a service keeps."""
    from app.cli.plan_report import print_plan
    from app.cli.service import service

    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(json))
        with service(url) as client:
            plan = client.get(plan_id)
        print_plan(console, plan.members)
        write_json(json, plan.members)


def export(
    plan_id: Id,
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FORMAT=PATH...",
            help="Write these files, as --export of `slewtrack plan` does.",
        ),
    ],
    url: Url = None,
) -> None:
    """Write the table of a plan that a service keeps, in one format or several."""
    from app.cli.service import service
    from planner.output.export import EXPORTERS

    wanted = list(formats_and_paths(files, EXPORTERS))
    takes_standard_output(*(path for _, path in wanted))
    with service(url) as client:
        for name, path in wanted:
            write(path, client.export(plan_id, name))


def watch(plan_id: Id, url: Url = None) -> None:
    """Follow a plan, campaign or flights to their end; 0 done, 1 failed or cancelled, 2 refused."""
    from app.cli.service import service

    console = report_console()

    def tell(now: "Progress") -> None:
        parts = "" if now.of is None else f" {now.done} of {now.of}"
        console.print(Text(f"{now.state}{': ' if now.stage else ''}{now.stage or ''}{parts}"))

    with service(url) as client:
        has_passed = _follow(client, plan_id, tell)
    if not has_passed:
        raise typer.Exit(FAILED)


def _follow(client: "Client", job_id: str, tell: "Callable[[Progress], None]") -> bool:
    from slewtrack.client import Refused

    waits: tuple[Callable[[], bool], ...] = (
        lambda: client.wait(job_id, progress=tell).passed,
        lambda: client.wait_for_campaign(job_id, progress=tell).state == "done",
    )
    for wait in waits:
        try:
            return wait()
        except Refused as refused:
            if refused.problem.status != HTTPStatus.NOT_FOUND:
                raise
    return client.wait_for_flights(job_id, progress=tell).state == "done"
