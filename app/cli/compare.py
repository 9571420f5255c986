"""`slewtrack compare`: telemetry is compared with a plan, here or by a running service."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.files import (
    WholeAnswer,
    picture_format,
    problem_to,
    takes_standard_output,
    write,
    write_json,
)
from app.cli.planner import Members, Planner
from app.cli.progress_bar import told_progress
from app.cli.report_parts import report_console
from planner.base.errors import InvalidInput

if TYPE_CHECKING:
    from app.cli.local import Local


def compare(
    plan: Annotated[
        str,
        typer.Argument(
            metavar="PLAN_OR_REQUEST",
            help="Take this plan: its request as JSON; its whole answer, with --request; or the id "
            "of a plan that a service keeps.",
        ),
    ],
    telemetry: Annotated[
        Path,
        typer.Argument(help="Read CSV from this file: t_s or utc, NAME_deg or NAME_rate_deg_s."),
    ],
    request: Annotated[
        Path | None, typer.Option(help="Read the request here, if PLAN_OR_REQUEST is an answer.")
    ] = None,
    epoch: Annotated[
        str | None,
        typer.Option(metavar="UTC", help="Count t_s from this time; the plan's epoch by default."),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=OWN",
            help="Take the file's column OWN for NAME, such as alpha_arcsec='AZ encoder' "
            "(may be repeated).",
        ),
    ] = None,
    measurements: Annotated[
        list[Path] | None,
        typer.Option(
            help="Read corrections or image_offsets (JSON) here, or the answer of a horizon "
            "estimate during the plan (may be repeated)."
        ),
    ] = None,
    identify: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS.FIELD",
            help="Estimate this parameter of the platform's drives, such as beta.coulomb_deg_s2 "
            "(may be repeated); it takes 15 to 30 s of a processor.",
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw plan and flight here (png, svg; pdf without --url).")
    ] = None,
    json: WholeAnswer = None,
    url: Annotated[
        str | None,
        typer.Option(
            help="Ask this service, which keeps the plan; SLEWTRACK_URL by default, or "
            "http://127.0.0.1:8000. The API key is SLEWTRACK_KEY."
        ),
    ] = None,
) -> None:
    """Compare telemetry with the plan that was flown: clock, errors, oscillations, friction."""
    is_kept = not Path(plan).is_file()
    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(plot, json))
        picture = picture_format(plot, by_service=is_kept)
        content = telemetry.read_bytes()
        head: dict[str, Any] = {"plan": plan}
        if epoch is not None:
            head["samples"] = {"epoch": epoch}
        if column:
            head["columns"] = _mapping(column)
        for path in measurements or ():
            _add(head, path)
        if identify:
            head["identify"] = identify
        if is_kept:
            from app.cli.service import service

            with service(url) as client:
                answer, drawn = _compare(client, head, content, picture)
        else:
            from app.cli.local import Local

            here = Local()
            head["plan"] = _take(here, Path(plan), request)
            answer, drawn = _compare(here, head, content, picture)

        from app.cli.compare_report import print_comparison

        print_comparison(console, answer)
        write_json(json, answer)
        if plot and drawn is not None:
            write(plot, drawn)


def _mapping(pairs: Sequence[str]) -> dict[str, str]:
    columns = dict(pair.split("=", 1) for pair in pairs if "=" in pair)
    if len(columns) < len(pairs):
        raise InvalidInput(
            "write each once and as NAME=OWN, such as alpha_arcsec='AZ encoder'", field="--column"
        )
    return columns


def _add(head: dict[str, Any], path: Path) -> None:
    from app.requests.json_reader import json_document

    document = json_document(path.read_bytes())
    found = document if isinstance(document, dict) else {}
    if correction := found.get("correction"):
        found = {"corrections": [correction]}
    kinds = [kind for kind in ("corrections", "image_offsets") if isinstance(found.get(kind), list)]
    if not kinds:
        raise InvalidInput(
            f"{path} has no list corrections or image_offsets, and no horizon estimate's "
            "correction",
            field="--measurements",
        )
    for kind in kinds:
        head.setdefault(kind, []).extend(found[kind])


def _compare(
    planner: Planner, head: Members, content: bytes, picture: str | None
) -> tuple[Members, bytes | None]:
    answer = planner.compare(head, content)
    return answer, planner.draw_comparison(head, content, picture) if picture else None


def _take(here: "Local", path: Path, request: Path | None) -> str:
    """Planned anew from a request, or as an answer has it: the plan's id."""
    from app.requests.json_reader import json_document

    body = path.read_bytes()
    document = json_document(body)
    if not isinstance(document, dict) or "table" not in document:
        with told_progress("planning") as tell:
            return here.plan(body, progress=tell).id
    if request is None:
        raise InvalidInput(
            "PLAN_OR_REQUEST is a plan's answer, which doesn't hold the platform: name its "
            "request, too",
            field="--request",
        )
    return here.take(document, request.read_bytes())
