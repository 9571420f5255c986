"""`slewtrack plan`: a request is planned here, or by a running service."""

import json as json_text
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from app.cli.files import (
    Exports,
    RequestFile,
    WholeAnswer,
    formats_and_paths,
    problem_to,
    read_request,
    takes_standard_output,
    write,
)
from app.cli.progress_bar import reported_work
from app.cli.report_parts import print_warnings, report_console
from planner.base.errors import InvalidInput, Unverified


@dataclass(frozen=True, kw_only=True)
class _Outputs:
    """Where to write what is made."""

    csv: Path | None
    exports: Sequence[tuple[str, Path]]
    plot: Path | None
    json: Path | None


def plan(
    file: RequestFile,
    csv: Annotated[
        Path | None,
        typer.Option(help="Write the command table here, columns only; - is standard output."),
    ] = None,
    export: Exports = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw angles, rates and accelerations here (png, svg, pdf).")
    ] = None,
    json: WholeAnswer = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="FIELD=VALUE",
            help="Change a field of the request first, by its name in refusals: "
            "sessions.0.start=2015-02-27T17:36:20Z (may be repeated).",
        ),
    ] = None,
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
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only check whether it can be flown; write nothing.")
    ] = False,
    url: Annotated[
        str | None,
        typer.Option(help="Plan at this service, which keeps the plan: http://127.0.0.1:8000."),
    ] = None,
) -> None:
    """Plan sessions of a two-axis platform."""
    with problem_to(json):
        from planner.output.export import EXPORTERS

        exports = tuple(formats_and_paths(export, EXPORTERS))
        outputs = _Outputs(csv=csv, exports=exports, plot=plot, json=json)
        paths = (csv, plot, json, *(path for _, path in exports))
        console = report_console(to_stderr=takes_standard_output(*paths))
        body, read_utc = read_request(file)
        if settings or next_pass or start is not None:
            body = _changed(console, body, settings, start, next_pass=next_pass)
        if url is not None:
            _plan_there(console, url, body, outputs, dry_run=dry_run)
        else:
            _plan_here(console, body, read_utc, outputs, dry_run=dry_run)


def _changed(
    console: Console,
    body: bytes,
    settings: Sequence[str] | None,
    start: str | None,
    *,
    next_pass: bool,
) -> bytes:
    from app.cli.changes import at_next_pass, search_start, with_settings

    body = with_settings(body, settings)
    if not next_pass:
        if start is not None:
            raise InvalidInput("goes with --next-pass", field="--start")
        return body
    body, told = at_next_pass(body, search_start(start))
    console.print(told)
    return with_settings(body, settings)  # again, for what is set of the session that was moved


def _plan_here(
    console: Console, body: bytes, read_utc: datetime, outputs: _Outputs, *, dry_run: bool
) -> None:
    from app.requests.plan import read_plan_request

    request = read_plan_request(body)

    from app.work import progress
    from planner.planning.sessions.pipeline import make_plan

    with reported_work("planning"):
        result = make_plan(
            request, on_stage=lambda stage: progress.report(progress.Progress(stage=stage))
        )

    from app.answers.members import new_head, provenance, whole_answer
    from app.answers.plan import (
        plan_document,
        require_verified,
        table_json,
        verdict_state,
    )
    from planner.world.frames.time_scales import utc_text

    if dry_run:
        passed = result.verification.passed
        _say_whether_it_flies(console, passed, len(result.table.t_s), result.warnings)
        return
    checks = []
    if outputs.json and request.horizon_cameras:
        from app.work.horizon_views import horizon_checks

        checks = horizon_checks(result.scenario, request.horizon_cameras)
    document = plan_document(result, checks, provenance(read_utc, body))

    from app.cli.plan_report import print_report

    epoch = utc_text(result.table.epoch_utc, 1)
    print_report(console, json_text.loads(document), epoch, len(result.table.t_s))
    if outputs.json:
        head = new_head(verdict_state(result))
        write(outputs.json, whole_answer(head, document, table_json(result.table)))
    if outputs.plot:
        from planner.output.export.figure import draw_plan

        image_format = outputs.plot.suffix.lstrip(".") or "png"
        write(outputs.plot, draw_plan(result, image_format, read_utc))
    # A table that fails is shown beside the verdict, above, and nowhere else.
    require_verified(result.verification.findings)
    if outputs.csv:
        from planner.output.export.csv import table_csv

        write(outputs.csv, table_csv(result.table).encode())
    if outputs.exports:
        from planner.output.export import EXPORTERS

        for name, path in outputs.exports:
            write(path, EXPORTERS[name].write(result, read_utc))


def _plan_there(
    console: Console, url: str, body: bytes, outputs: _Outputs, *, dry_run: bool
) -> None:
    drawn = _drawn_there(outputs.plot)
    from app.cli.service import json_of, print_kept, service, table_only_csv, told_progress

    with service(url) as client:
        if dry_run:
            found = client.check(body)
            _say_whether_it_flies(console, found["flies"], found["rows"], found["warnings"])
            return
        with told_progress() as tell:
            made = client.plan(body, progress=tell)
        print_kept(console, made.members)
        console.print(f"kept as {made.id}")
        if outputs.json:
            write(outputs.json, json_of(made.members))
        if not made.passed:
            raise _unverified()
        wanted = (*outputs.exports, *drawn)
        files = [(path, client.export(made.id, name)) for name, path in wanted]
        if outputs.csv:
            files.append((outputs.csv, table_only_csv(client.export(made.id, "csv"))))
    for path, content in files:
        write(path, content)


def _drawn_there(plot: Path | None) -> Sequence[tuple[str, Path]]:
    """The picture as one of the formats that a service writes."""
    if plot is None:
        return ()
    image_format = plot.suffix.lstrip(".") or "png"
    if image_format not in ("png", "svg"):
        raise InvalidInput(
            f"a service draws .png and .svg, not {plot.suffix}; name one of these, or leave out "
            "--url",
            field="--plot",
        )
    return ((image_format, plot),)


def _unverified() -> Unverified:
    return Unverified(
        "the table failed its verification; only the whole answer holds it, beside the verdict"
    )


def _say_whether_it_flies(
    console: Console, flies: bool, rows: int, warnings: Sequence[str]
) -> None:
    print_warnings(console, warnings)
    if not flies:
        raise _unverified()
    console.print(f"flies: {rows} rows, verification passed; nothing was written")
