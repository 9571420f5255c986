"""`slewtrack plan`: a request is planned here, or by a running service."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.cli import files
from app.cli.planner import Members, planner_at, told_progress
from app.cli.report_parts import print_warnings
from planner.base.errors import InvalidInput, Unverified


def plan(
    file: files.RequestFile,
    csv: files.TableCsv = None,
    export: files.Exports = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw angles, rates and accelerations here (png, svg, pdf).")
    ] = None,
    json: files.WholeAnswer = None,
    settings: files.Settings = None,
    next_pass: Annotated[
        bool,
        typer.Option(
            "--next-pass", help="Move the one session to the next window of its target first."
        ),
    ] = False,
    start: Annotated[
        str | None,
        typer.Option(help="Begin the search of --next-pass at this UTC; now by default."),
    ] = None,
    dry_run: files.DryRun = False,
    url: files.Url = None,
) -> None:
    """Plan sessions of a platform."""
    with files.report_beside(json, csv, plot, exports=export) as console:
        picture = files.picture_format(plot, by_service=url is not None)
        body = files.read_request(file, settings)
        from planner.output.export import EXPORTERS

        exports = files.formats_and_paths(export, EXPORTERS)
        if next_pass:
            from app.cli.changes import at_next_pass, with_settings

            body, told = at_next_pass(body, start)
            console.print(told)
            body = with_settings(body, settings)  # again, for what is set of the moved session
        elif start is not None:
            raise InvalidInput("goes with --next-pass", field="--start")
        with planner_at(url) as planner:
            if dry_run:
                say_whether_it_flies(console, planner.check(body))
                return
            with told_progress("planning") as tell:
                made = planner.plan(body, progress=tell)
            from app.cli.plan_report import print_plan

            print_plan(console, made.members, body)
            if url is not None:
                console.print(f"kept as {made.id}")
            files.write_json(json, made.members)
            # A table that fails is shown beside the verdict, and nowhere else.
            if plot and picture and (made.passed or url is None):
                files.write(plot, planner.export(made.id, picture))
            _require_verified(made.members["verification"])
            if csv:
                files.write(csv, files.table_only(planner.export(made.id, "csv")))
            for name, path in exports:
                files.write(path, planner.export(made.id, name))


def _require_verified(verdict: Members) -> None:
    if verdict["passed"]:
        return
    from app.work.plan import require_verified
    from planner.verification import Finding

    told = ("severity", "limit", "axis", "detail")
    require_verified(Finding(**{name: one[name] for name in told}) for one in verdict["findings"])


def say_whether_it_flies(console: Console, found: Members) -> None:
    """Of a dry run's answer; raises Unverified."""
    print_warnings(console, found["warnings"])
    if not found["flies"]:
        raise Unverified(
            "the table failed its verification; only the whole answer holds it, beside the verdict"
        )
    rows = f"{found['rows']} rows" if "rows" in found else f"{found['requests']} requests"
    without = ", ".join(found.get("left_out", ()))
    rows += f" without {without}" if without else ""
    console.print(f"flies: {rows}, verification passed; nothing was written")
