"""Plans that a running service keeps: listed, shown, exported, followed."""

from collections.abc import Callable, Sequence
from functools import partial
from http import HTTPStatus
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer
from rich.text import Text

from app.cli import files
from app.cli.one_line import FAILED
from app.cli.planner import Members
from app.cli.report_parts import UNBOUNDED, print_rows, report_console

if TYPE_CHECKING:
    from slewtrack.client import Progress

T = TypeVar("T")
_SECOND, _MINUTE = 19, 16  # characters of a time to these
_SHORT_ID = 13  # to the millisecond in which it was made

Id = Annotated[
    str,
    typer.Argument(
        metavar="ID", help="Take this plan, by its id in `slewtrack list`, or the beginning of one."
    ),
]


def list_plans(
    url: files.KeptUrl = None,
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
    wide: Annotated[
        bool, typer.Option("--wide", help="Print ids and times whole, however wide it gets.")
    ] = False,
    json: files.WholeAnswer = None,
) -> None:
    """List the plans that a service keeps, the latest first."""
    from app.cli.service import service

    with files.report_beside(json) as console, service(url) as client:
        narrow = {"state": state, "name": name, "target": target, "text": text}
        found = client.plans(limit=limit, after=after, before=before, **narrow)
        told = [dict(job.members) for job in found]
        if wide:
            console.width = UNBOUNDED
        print_rows(
            console, None, told, ("<id", "id", "", _short_id(told)), ("<state", "state"),
            ("<created", "created", _time(_SECOND), _time(_MINUTE)),
            ("<start", "start", _time(_SECOND), _time(_MINUTE)),
            ("~name", "name"), ("~targets", "targets", ", ".join),
        )  # fmt: skip
        if not found:
            console.print("there are none")
        files.write_json(json, {"plans": told})


def _short_id(plans: Sequence[Members]) -> Callable[[str], str]:
    """So much of each id that all differ."""
    count = _SHORT_ID
    while len({plan["id"][:count] for plan in plans}) < len(plans):
        count += 1
    return lambda plan_id: plan_id[:count]


def _time(characters: int) -> Callable[[str | None], str]:
    return lambda utc: "-" if utc is None else utc[:characters].replace("T", " ")


def show(plan_id: Id, url: files.KeptUrl = None, json: files.WholeAnswer = None) -> None:
    """Show a plan that a service keeps."""
    from app.cli.plan_report import print_plan
    from app.cli.service import service

    with files.report_beside(json) as console, service(url) as client:
        plan = client.get(client.named(plan_id))
        print_plan(console, plan.members, client.request(plan.id))
        files.write_json(json, plan.members)


def export(
    plan_id: Id,
    tables: Annotated[
        list[str],
        typer.Argument(
            metavar="FORMAT=PATH...",
            help="Write these files, as --export of `slewtrack plan` and `campaign` does.",
        ),
    ],
    url: files.KeptUrl = None,
) -> None:
    """Write the table of a plan that a service keeps, or the looks of a campaign, as files."""
    from app.cli.service import service
    from planner.output.export import EXPORTERS
    from slewtrack.client.calls import CAMPAIGN_FILES

    with files.report_beside(None, exports=tables), service(url) as client:
        wanted = files.formats_and_paths(tables, {**EXPORTERS, **CAMPAIGN_FILES})
        whole = client.named(plan_id)
        for name, path in wanted:
            ways = (client.export, client.export_campaign)
            files.write(path, _first_there(*(partial(way, whole, name) for way in ways)))


def watch(plan_id: Id, url: files.KeptUrl = None) -> None:
    """Follow a plan, campaign or flights to their end; 0 done, 1 failed or cancelled, 2 refused."""
    from app.cli.service import service

    console = report_console()

    def tell(now: "Progress") -> None:
        parts = "" if now.of is None else f" {now.done} of {now.of}"
        console.print(Text(f"{now.state}{': ' if now.stage else ''}{now.stage or ''}{parts}"))

    with service(url) as client:
        whole = client.named(plan_id)
        waits = (client.wait, client.wait_for_campaign, client.wait_for_flights)
        made = _first_there(*(partial(wait, whole, progress=tell) for wait in waits))
    if made["state"] != "done":
        raise typer.Exit(FAILED)


def _first_there(*ways: Callable[[], T]) -> T:
    """What the first of them gives whose kind the id is of; raises Refused."""
    from slewtrack.client import Refused

    for way in ways[:-1]:
        try:
            return way()
        except Refused as refused:
            if refused.problem.status != HTTPStatus.NOT_FOUND:
                raise
    return ways[-1]()
