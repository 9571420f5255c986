"""What does the `slewtrack` command do?

Exit codes: 0 done, 1 our failure, 2 refused; a refusal is one line on stderr.
Imports wait until a command needs them: `plan` must not pay for the web server.
"""

import ipaddress
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from planner.errors import Refusal, SolverFailed, VerificationFailed

FAILED, REFUSED = 1, 2

main = typer.Typer(
    help="Plans how a pointing instrument moves.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@main.command()
def plan(
    file: Annotated[str, typer.Argument(help="The request as JSON; - reads standard input.")],
    csv: Annotated[Path | None, typer.Option(help="Write the command table here.")] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw angles, rates and accelerations here (png, svg, pdf).")
    ] = None,
    json: Annotated[
        Path | None, typer.Option(help="Write the whole answer of the HTTP service here.")
    ] = None,
) -> None:
    """Plan the sessions of a request and report."""
    with _one_line_for_what_goes_wrong():
        body = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()

        import hashlib
        from datetime import UTC, datetime

        from app.api.plan_request import read_plan_request

        scenario = read_plan_request(body)

        from app.report import print_report
        from planner.pipeline import make_plan

        now_utc = datetime.now(UTC)
        made = make_plan(scenario)
        print_report(made)
        if csv:
            from planner.export.csv import table_csv

            _write(csv, table_csv(made.table).encode())
        if json:
            from app.api.plan_response import plan_json

            digest = hashlib.sha256(body).hexdigest()
            _write(json, plan_json(made, input_sha256=digest, planned_at_utc=now_utc))
        if plot:
            from app.figure import draw_plan

            _write(plot, draw_plan(made, plot.suffix.lstrip(".") or "png"))


@main.command()
def serve(
    host: Annotated[str, typer.Option(help="A loopback address.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535)] = 8000,
) -> None:
    """Serve the HTTP API and its pages (/docs) on this machine."""
    with _one_line_for_what_goes_wrong():
        if not _is_loopback(host):
            raise Refusal(
                f"{host} can be reached from other machines and the service has no keys yet; "
                "use 127.0.0.1 or ::1",
                field="--host",
            )

        import uvicorn

        from app.main import create_app

        uvicorn.run(create_app(), host=host, port=port, server_header=False)


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


@contextmanager
def _one_line_for_what_goes_wrong() -> Iterator[None]:
    try:
        yield
    except Refusal as refusal:
        failed = isinstance(refusal, SolverFailed | VerificationFailed)
        _say(_with_field(refusal))
        raise typer.Exit(FAILED if failed else REFUSED) from None
    except OSError as error:
        _say(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        raise typer.Exit(REFUSED) from None
    except Exception as error:  # noqa: BLE001 (the edge: a user gets one line, not a traceback)
        _say(f"internal error: {type(error).__name__}: {error}")
        raise typer.Exit(FAILED) from None


def _with_field(refusal: Refusal) -> str:
    if refusal.field is None or refusal.detail.startswith(refusal.field):
        return refusal.detail
    return f"{refusal.field}: {refusal.detail}"


def _say(text: str) -> None:
    print(f"slewtrack: {' '.join(text.split())}", file=sys.stderr)
