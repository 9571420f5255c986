"""The arguments of the `slewtrack` command, and the calls that carry them out.

Exit codes: 0 done, 1 failed (by us, or a table that fails its verification), 2 refused;
what goes wrong is one line on stderr.
Imports wait until a command needs them: `plan` must not pay for the web server.
"""

import gc
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from app.cli.compare import compare
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
from app.cli.fly import fly
from app.cli.kept import export, list_plans, show, watch
from app.cli.keys import keys
from app.cli.one_line import FAILED, REFUSED, one_line_for_what_goes_wrong, say
from app.cli.plan import plan
from app.cli.progress_bar import progress_bar, reported_work
from app.cli.report_parts import report_console


class _OneLinePerFault(TyperGroup):
    """Reports a wrong argument as every other refusal is reported."""

    def main(self, *args: Any, **options: Any) -> Any:  # noqa: ANN401 (Typer's own signature)
        given = options.get("args", args[0] if args else None)
        words = ["slewtrack", *(sys.argv[1:] if given is None else given)]
        options |= {"standalone_mode": False, "obj": words}
        try:
            code = super().main(*args, **options)
        except typer.TyperException as fault:
            context = getattr(fault, "ctx", None)
            where = context.command_path if context else "slewtrack"
            say(f"{fault.format_message().rstrip('.')}; see {where} --help")
            sys.exit(REFUSED)
        except typer.Abort:
            sys.exit(FAILED)
        sys.exit(code or 0)

    def invoke(self, context: Any) -> Any:  # noqa: ANN401 (Typer's own signature)
        with one_line_for_what_goes_wrong(context.obj or ()):
            return super().invoke(context)


main = typer.Typer(
    cls=_OneLinePerFault,
    help="Plan the motion of pointing instruments.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from app.versions import VERSION

        print(f"slewtrack {VERSION}")
        raise typer.Exit


@main.callback(invoke_without_command=True)
def _help_without_command(
    context: typer.Context,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())
        raise typer.Exit(REFUSED)


main.add_typer(keys, name="keys")


main.command()(plan)
main.command()(fly)
main.command("list")(list_plans)
main.command()(show)
main.command()(export)
main.command()(watch)
main.command()(compare)


@main.command()
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
        from app.answers.opportunities import opportunities_json, windows_out
        from app.cli.windows_report import print_windows, windows_csv
        from planner.planning.opportunities import find_opportunities

        with reported_work("searching"):
            result = find_opportunities(request)
        answer = windows_out(result)
        print_windows(console, result, answer)
        if csv:
            write(csv, windows_csv(result.axis_names, answer).encode())
        if json:
            write(json, opportunities_json(result, request.name, provenance(read_utc, body)))


@main.command()
def campaign(
    file: RequestFile,
    plans: Annotated[
        Path | None, typer.Option(help="Write each pass's plan and its request into this folder.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Write one line per look here.")] = None,
    json: Annotated[
        Path | None,
        typer.Option(help="Write the choice, its bound, and each pass with its looks here."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only choose; plan and write nothing.")
    ] = False,
) -> None:
    """Choose and plan sessions of many targets over days."""
    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(csv, json))
        body, _ = read_request(file)

        import zlib
        from json import loads

        from app.cli.campaign import (
            campaign_csv,
            campaign_json,
            print_campaign,
            run_campaign,
            write_plans,
        )

        choice, passes = run_campaign(body, plans_too=not dry_run)
        document = zlib.decompress(choice.document)
        print_campaign(console, loads(document), passes)
        if dry_run:
            return
        if plans:
            write_plans(plans, passes)
        if csv:
            write(csv, campaign_csv(passes).encode())
        if json:
            write(json, campaign_json(document, passes))


@main.command()
def horizon(
    request: Annotated[
        Path,
        typer.Argument(help="Read the request from this file: an estimate, a list, or a session."),
    ],
    images: Annotated[
        list[Path],
        typer.Argument(
            help="Read one image per camera in their order, frame after frame; or one video each."
        ),
    ],
    overlay: Annotated[
        Path | None,
        typer.Option(help="Write the annotated frame here (PNG), for several cameras with -NAME."),
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """Estimate the local vertical from images of the horizon."""
    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(overlay, json))
        from app.cli.horizon import measure_frames, measure_one
        from app.work.horizon_series import read_series

        body = request.read_bytes()
        series = read_series(body)
        if series is None:
            answer = measure_one(console, body, images, overlay)
        else:
            answer = measure_frames(console, series, body, images)
        if json:
            write(json, answer)


@main.command()
def spacecraft(
    file: RequestFile,
    export: Exports = None,
    json: WholeAnswer = None,
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run", help="Only check whether the session can be flown; write nothing."
        ),
    ] = False,
) -> None:
    """Plan an imaging session of the CMG spacecraft and report."""
    with problem_to(json):
        from planner.spacecraft.export import IMAGING_EXPORTERS

        exports = list(formats_and_paths(export, IMAGING_EXPORTERS))
        console = report_console(
            to_stderr=takes_standard_output(json, *(path for _, path in exports))
        )
        body, read_utc = read_request(file)

        from app.requests.spacecraft import read_spacecraft_request

        request = read_spacecraft_request(body)

        from app.cli.spacecraft_report import print_session
        from planner.spacecraft.plan import plan_imaging

        with progress_bar("planning") as tell:
            result = plan_imaging(request, tell)
        print_session(console, result)
        if dry_run:
            return
        for name, path in exports:
            write(path, IMAGING_EXPORTERS[name].write(result, read_utc))
        if json:
            from app.answers.members import provenance
            from app.answers.spacecraft import spacecraft_plan_json

            write(json, spacecraft_plan_json(result, provenance(read_utc, body)))


def _port(text: str | int) -> int:
    if not str(text).isdecimal() or not 0 <= int(text) <= 65535:
        raise typer.BadParameter(f"must be a whole number from 0 to 65535, not {text!r}")
    return int(text)


@main.command()
def serve(
    host: Annotated[
        str, typer.Option(help="Listen at this address; beyond loopback, make a key first.")
    ] = "127.0.0.1",
    port: Annotated[
        int,
        typer.Option(parser=_port, metavar="PORT", help="Listen at this port; 0 takes a free one."),
    ] = 8000,
) -> None:
    """Serve the planner's page (/) and the HTTP API (/docs), beyond loopback with API keys."""
    gc.disable()  # nothing that is loaded is garbage: looking for some takes a sixth of a start
    from app.http.serving import serve_on
    from app.settings import settings_of_environment

    gc.freeze()
    gc.enable()
    serve_on(host, port, settings_of_environment())


@main.command()
def worker(
    scheduler: Annotated[
        str, typer.Option(help="Take work from this Dask scheduler: tcp://HOST:PORT or tls://.")
    ],
    solves: Annotated[
        int | None,
        typer.Option(min=1, help="Solve so many plans at a time; one per processor by default."),
    ] = None,
) -> None:
    """Solve for services that are set to the same Dask scheduler."""
    from app.jobs.dask_address import check_scheduler
    from app.log.logs import configure_logs
    from app.settings import settings_of_environment

    settings = settings_of_environment()
    check_scheduler(scheduler, "worker", "--scheduler")
    from app.jobs.dask_worker import work_for

    configure_logs(settings.log_level, settings.log_format)  # once Dask has its loggers
    work_for(scheduler, solves or settings.workers)
