"""The arguments of the `slewtrack` command, and what it does with them.

Exit codes: 0 done, 1 failed (by us, or a table that fails its verification), 2 refused;
what goes wrong is one line on stderr.
Imports wait until a command needs them: `plan` must not pay for the web server.
"""

import sys
from collections.abc import Collection, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from app.cli.keys import keys
from app.cli.one_line import FAILED, REFUSED, one_line_for_what_goes_wrong, say
from planner.errors import InvalidInput

RequestFile = Annotated[str, typer.Argument(help="The request as JSON; - reads standard input.")]
WholeAnswer = Annotated[
    Path | None, typer.Option(help="Write the whole answer of the HTTP service here.")
]


class _OneLinePerFault(TyperGroup):
    """Reports a wrong argument as every other refusal is reported."""

    def main(self, *args: Any, **options: Any) -> Any:  # noqa: ANN401 (Typer's own signature)
        try:
            code = super().main(*args, **options | {"standalone_mode": False})
        except typer.TyperException as fault:
            context = getattr(fault, "ctx", None)
            where = context.command_path if context else "slewtrack"
            say(f"{fault.format_message().rstrip('.')}; see {where} --help")
            sys.exit(REFUSED)
        except typer.Abort:
            sys.exit(FAILED)
        sys.exit(code or 0)

    def invoke(self, context: Any) -> Any:  # noqa: ANN401 (Typer's own signature)
        with one_line_for_what_goes_wrong():
            return super().invoke(context)


main = typer.Typer(
    cls=_OneLinePerFault,
    help="Plans how a pointing instrument moves.",
    add_completion=False,
    pretty_exceptions_enable=False,
)


@main.callback(invoke_without_command=True)
def _help_without_command(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())
        raise typer.Exit(REFUSED)


main.add_typer(keys, name="keys")


@main.command()
def plan(
    file: RequestFile,
    csv: Annotated[
        Path | None, typer.Option(help="Write the command table here, columns only.")
    ] = None,
    export: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORMAT=PATH",
            help="Write the table in a format that says its frames and units: "
            "docs/http.md lists them, and so does the refusal of an unknown one (may be repeated).",
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw angles, rates and accelerations here (png, svg, pdf).")
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """Plan the sessions of a request and report."""
    body, read_utc = _read(file)

    from planner.export import EXPORTERS

    exports = list(_formats_and_paths(export, EXPORTERS))

    from app.requests.plan import read_plan_request

    request = read_plan_request(body)

    from app.cli.plan_report import print_report
    from planner.sessions.pipeline import make_plan

    result = make_plan(request)
    print_report(result)
    if json:
        from app.answers.members import provenance
        from app.answers.plan import plan_json

        checks = []
        if request.horizon_cameras:
            from app.work.horizon_views import horizon_checks

            checks = horizon_checks(result.scenario, request.horizon_cameras)
        _write(json, plan_json(result, provenance(read_utc, body), checks))
    if plot:
        try:
            from app.cli.figure import draw_plan
        except ModuleNotFoundError as missing:
            raise InvalidInput(
                f"drawing needs {missing.name}, which isn't installed: install "
                "slewtrack[plot], or leave it out",
                field="--plot",
            ) from None

        _write(plot, draw_plan(result, plot.suffix.lstrip(".") or "png"))

    from app.answers.plan import require_verified

    # A table that fails is shown beside the verdict, above, and nowhere else.
    require_verified(result.verification.findings)
    if csv:
        from planner.export.csv import table_csv

        _write(csv, table_csv(result.table).encode())
    for name, path in exports:
        _write(path, EXPORTERS[name].write(result, read_utc))


@main.command()
def windows(
    file: RequestFile,
    csv: Annotated[
        Path | None, typer.Option(help="Write one line per window here, at its closest approach.")
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """Tell when targets can be seen."""
    body, read_utc = _read(file)

    from app.requests.opportunities import read_opportunity_request

    request = read_opportunity_request(body)

    from app.answers.members import provenance
    from app.answers.opportunities import opportunities_json, windows_out
    from app.cli.windows_report import print_windows, windows_csv
    from planner.opportunities import find_opportunities

    result = find_opportunities(request)
    answer = windows_out(result)
    print_windows(result, answer)
    if csv:
        _write(csv, windows_csv(result.axis_names, answer).encode())
    if json:
        _write(json, opportunities_json(result, request.name, provenance(read_utc, body)))


@main.command()
def campaign(
    file: RequestFile,
    plans: Annotated[
        Path | None, typer.Option(help="Write each pass's plan and its request into this folder.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Write one line per look here.")] = None,
    json: Annotated[
        Path | None, typer.Option(help="Write what was chosen, and how good it is, here.")
    ] = None,
) -> None:
    """Choose, order and plan sessions for many targets over days."""
    body, _ = _read(file)

    import zlib
    from json import loads

    from app.cli.campaign import campaign_csv, print_campaign, run_campaign, write_plans

    choice, passes = run_campaign(body)
    document = zlib.decompress(choice.document)
    print_campaign(loads(document), passes)
    if plans:
        write_plans(plans, passes)
    if csv:
        _write(csv, campaign_csv(passes).encode())
    if json:
        _write(json, document)


@main.command()
def horizon(
    request: Annotated[
        Path, typer.Argument(help="The request for an estimate, a list of them, or a session.")
    ],
    images: Annotated[
        list[Path],
        typer.Argument(
            help="One image per camera in their order, frame after frame; or one video each."
        ),
    ],
    overlay: Annotated[
        Path | None,
        typer.Option(help="Write the annotated frame here (PNG); of several cameras -NAME each."),
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """Measure the local vertical in images of the horizon."""
    from app.cli.horizon import measure_frames, measure_one
    from app.work.horizon_series import read_series

    body = request.read_bytes()
    series = read_series(body)
    if series is None:
        answer = measure_one(body, images, overlay)
    else:
        answer = measure_frames(series, body, images)
    if json:
        _write(json, answer)


@main.command()
def spacecraft(
    file: RequestFile,
    export: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORMAT=PATH",
            help="Write the table as csv, netcdf or aem (may be repeated).",
        ),
    ] = None,
    json: WholeAnswer = None,
) -> None:
    """Plan an imaging session of the CMG spacecraft and report."""
    body, read_utc = _read(file)

    from planner.spacecraft.export import IMAGING_EXPORTERS

    exports = list(_formats_and_paths(export, IMAGING_EXPORTERS))

    from app.requests.spacecraft import read_spacecraft_request

    request = read_spacecraft_request(body)

    from app.cli.spacecraft_report import print_session
    from planner.spacecraft.plan import plan_imaging

    result = plan_imaging(request)
    print_session(result)
    for name, path in exports:
        _write(path, IMAGING_EXPORTERS[name].write(result, read_utc))
    if json:
        from app.answers.members import provenance
        from app.answers.spacecraft import spacecraft_plan_json

        _write(json, spacecraft_plan_json(result, provenance(read_utc, body)))


def _port(text: str | int) -> int:
    if not str(text).isdecimal() or not 0 <= int(text) <= 65535:
        raise typer.BadParameter(f"must be a whole number from 0 to 65535, not {text!r}")
    return int(text)


@main.command()
def serve(
    host: Annotated[str, typer.Option(help="Beyond loopback, make a key first.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(parser=_port, metavar="PORT", help="0 for any free.")] = 8000,
) -> None:
    """Serve the HTTP API and its pages (/docs); beyond this machine with API keys only."""
    from app.jobs.disposable import start_server

    start_server()  # what children need is loaded while the service itself is
    from app.http.serving import serve_on
    from app.settings import settings_of_environment

    serve_on(host, port, settings_of_environment())


@main.command()
def worker(
    scheduler: Annotated[str, typer.Option(help="The Dask scheduler: tcp://HOST:PORT or tls://.")],
    solves: Annotated[
        int | None, typer.Option(min=1, help="Solves at a time; default: the processors.")
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


def _read(file: str) -> tuple[bytes, datetime]:
    """A request as it stands in its file, and when it was read."""
    body = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
    return body, datetime.now(UTC)


def _formats_and_paths(
    texts: list[str] | None, formats: Collection[str]
) -> Iterator[tuple[str, Path]]:
    for text in texts or ():
        name, _, path = text.partition("=")
        if name not in formats or not path:
            raise InvalidInput(
                f"{text[:80]!r} is no FORMAT=PATH; the formats are {', '.join(formats)}",
                field="--export",
            )
        yield name, Path(path)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
