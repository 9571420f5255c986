"""The arguments of the `slewtrack` command, and the calls that carry them out.

Exit codes: 0 done, 1 failed (by us, or a table that fails its verification), 2 refused;
what goes wrong is one line on stderr.
Imports wait until a command needs them: `plan` must not pay for the web server.
"""

import gc
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from app.cli.campaign import campaign
from app.cli.compare import compare
from app.cli.fly import fly
from app.cli.horizon import horizon
from app.cli.kept import export, list_plans, show, watch
from app.cli.keys import keys
from app.cli.one_line import FAILED, REFUSED, one_line_for_what_goes_wrong, say
from app.cli.plan import plan
from app.cli.spacecraft import spacecraft
from app.cli.windows import windows


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


_PLATFORM = (plan, fly, list_plans, show, export, watch, compare)
for command in (*_PLATFORM, windows, campaign, horizon, spacecraft):
    main.command(command.__name__.removesuffix("_plans"))(command)


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
    check_scheduler(scheduler, "client", "--scheduler")  # as its children are, for prices
    from app.jobs.dask_executor import work_for

    configure_logs(settings.log_level, settings.log_format)  # once Dask has its loggers
    work_for(scheduler, solves or settings.workers)
