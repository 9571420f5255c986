"""`slewtrack compare`: telemetry is compared with a plan, here or by a running service."""

import json as json_text
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.files import WholeAnswer, problem_to, takes_standard_output, write
from app.cli.report_parts import report_console
from planner.base.errors import FieldError, InvalidInput, InvalidRequest

if TYPE_CHECKING:
    from planner.world.plan import FlightPlan

_PICTURES = ("png", "svg")


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
    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(plot, json))
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
        if Path(plan).is_file():
            answer, picture = _here(Path(plan), request, head, content, _format(plot))
        else:
            answer, picture = _there(url, head, content, _format(plot))
        from app.answers.members import from_store
        from app.answers.telemetry import ComparisonResponse
        from app.cli.compare_report import print_comparison

        # The platform found is for the next request, which reads it strictly; the report tells what
        # was found of it.
        told = json_text.loads(answer) | {"platform": None}
        print_comparison(console, from_store(ComparisonResponse, told))
        if json:
            write(json, answer)
        if plot and picture is not None:
            write(plot, picture)


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


def _format(plot: Path | None) -> str | None:
    return None if plot is None else plot.suffix.lstrip(".").lower() or "png"


def _here(
    path: Path, request: Path | None, head: dict[str, Any], content: bytes, image: str | None
) -> tuple[bytes, bytes | None]:
    from app.answers.members import provenance
    from app.requests.telemetry import read_comparison_head
    from app.work.telemetry import SentTelemetry, answer_json, compare_sent

    plan, plan_id = _plan_of(path.read_bytes(), request)
    spec = read_comparison_head(json_text.dumps(head | {"plan": plan_id}).encode())
    now_utc = datetime.now(UTC)
    comparison = compare_sent(plan, SentTelemetry(request=spec, samples=content))
    answer = answer_json(comparison, spec, plan_id, provenance(now_utc, content))
    if image is None:
        return answer, None
    from planner.inflight.telemetry.figure import draw_comparison

    return answer, draw_comparison(comparison, image, now_utc)


def _plan_of(body: bytes, request: Path | None) -> "tuple[FlightPlan, str]":
    """Planned anew from a request, or as an answer has it; and the plan's id."""
    from app.requests.json_reader import json_document
    from app.requests.plan import read_plan_request
    from app.store.ids import new_id

    document = json_document(body)
    if isinstance(document, dict) and "table" in document:
        if request is None:
            raise InvalidInput(
                "PLAN_OR_REQUEST is a plan's answer, which doesn't hold the platform: name its "
                "request, too",
                field="--request",
            )
        return _of_answer(document, request.read_bytes()), str(document.get("id") or new_id())
    spec = read_plan_request(body)

    from app.cli.progress_bar import reported_work
    from app.work import progress
    from planner.planning.sessions.pipeline import make_plan

    with reported_work("planning"):
        made = make_plan(
            spec, on_stage=lambda stage: progress.report(progress.Progress(stage=stage))
        )
    return made, new_id()


def _of_answer(document: dict[str, Any], request: bytes) -> "FlightPlan":
    import numpy as np

    from app.requests.plan import read_plan_request
    from planner.base.commands import CommandTable
    from planner.world.frames.time_scales import utc_from_text
    from planner.world.plan import FlightPlan, Segment

    scenario = read_plan_request(request)
    names, table = scenario.platform.axis_names, document["table"]
    try:
        columns = [
            np.radians(np.array([table[f"{name}{kind}"] for name in names], dtype=float).T)
            for kind in ("_deg", "_rate_deg_s")
        ]
        segments = tuple(
            Segment(
                kind=one["kind"],
                session=one["session"],
                start_utc=utc_from_text(one["start"]),
                stop_utc=utc_from_text(one["stop"]),
            )
            for one in document["segments"]
        )
        epoch_utc = utc_from_text(table["epoch"])
    except (KeyError, TypeError, ValueError) as fault:
        detail = f"is no whole answer of a plan of this request: {fault}"
        raise InvalidRequest(FieldError(field="PLAN_OR_REQUEST", detail=detail)) from None
    return FlightPlan(
        scenario=scenario,
        segments=segments,
        table=CommandTable(
            epoch_utc=epoch_utc, axis_names=names, angle_rad=columns[0], rate_rad_s=columns[1]
        ),
    )


def _there(
    url: str | None, head: dict[str, Any], content: bytes, image: str | None
) -> tuple[bytes, bytes | None]:
    _require_drawn_there(image)
    from app.cli.service import json_of, service

    with service(url) as client:
        answer = json_of(client.compare(head, content))
        picture = client.draw_comparison(head, content, image) if image else None
    return answer, picture


def _require_drawn_there(image: str | None, drawn: Sequence[str] = _PICTURES) -> None:
    if image is not None and image not in drawn:
        raise InvalidInput(
            f"a service draws {' and '.join(drawn)}, not {image[:20]}; name one of these",
            field="--plot",
        )
