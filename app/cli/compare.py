"""`slewtrack compare`: telemetry is compared with a plan, here or by a running service."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from app.cli import files
from app.cli.planner import Members, planner_at
from app.cli.report_parts import print_rows, print_warnings
from planner.base.errors import InvalidInput

_TIME = slice(11, 23)


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
        typer.Argument(help="Read CSV from this file: t_s or utc, NAME_deg, or a body's q_1 ..."),
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
    json: files.WholeAnswer = None,
    url: files.KeptUrl = None,
) -> None:
    """Compare telemetry with the plan that was flown: clock, errors, oscillations, friction."""
    is_kept = not Path(plan).is_file()
    with files.report_beside(json, plot) as console:
        picture = files.picture_format(plot, by_service=is_kept)
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
        with planner_at((url or "") if is_kept else None) as planner:
            head["plan"] = planner.named(plan, request)
            answer = planner.compare(head, content).members
            drawn = planner.draw_comparison(head, content, picture) if picture else b""
        print_comparison(console, answer)
        files.write_json(json, answer)
        if plot:
            files.write(plot, drawn)


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


def print_comparison(console: Console, answer: Members) -> None:
    for line in (*_samples(answer["samples"]), *_clock(answer)):
        console.print(Text(line))
    print_rows(
        console, "errors in arcsec, lag in ms", _errors(answer),
        ("<axis", "axis"), ("<phase", "phase"), ("<from", "from", str, lambda time: time[:8]),
        ("samples", "samples"), ("rms", "rms_arcsec", ".2f"), ("max", "max_arcsec", ".2f"),
        ("mean", "mean_arcsec", ".2f"), ("lag", "lag_s", _milliseconds),
        ("1 sigma", "lag_sigma_s", _milliseconds), keys=2,
    )  # fmt: skip
    for name, axis in answer["axes"].items():
        for line in _what_it_did(name, axis):
            console.print(Text(line))
        for beyond in axis["limits_exceeded"]:
            told = f"{name} {beyond['limit']} {beyond['value']:g} {beyond['unit']} beyond "
            console.print(Text(f"{told}{beyond['bound']:g} from {_span(beyond)}", style="red"))
    for parts in answer["pointing"]:
        along, across = parts["attitude_arcsec"]
        console.print(
            f"{parts['at'][_TIME]} by {parts['measured']}: attitude moves the target by "
            f"{along:+.1f}, {across:+.1f} arcsec in the frame"
        )
    for one in answer["parameters"]:
        error = "" if one["sigma"] is None else f", 1 sigma {one['sigma']:.2g}"
        told = f"{one['name']} {one['found']:.4g}{error}; planned with {one['planned']:.4g}"
        console.print(Text(told))
    print_warnings(console, answer["warnings"])


def _samples(samples: Members) -> Iterator[str]:
    lost = ", ".join(f"{count} {reason}" for reason, count in samples["dropped"].items())
    units = ", ".join(f"{column['name']} in {column['unit']}" for column in samples["columns"])
    yield (
        f"{samples['used']} of {samples['read']} rows used"
        + (f" (dropped: {lost})" if lost else "")
        + f", {samples['start'][_TIME]} to {samples['stop'][_TIME]}, {len(samples['gaps'])} gaps; "
        + units
    )


def _clock(answer: Members) -> Iterator[str]:
    offset, drift = answer["time_offset_s"], answer["clock_drift"]
    since = f" ahead at {answer['epoch']}"
    yield f"{_ahead(offset, since)}; {_drift(drift)}"
    yield f"  if {offset['assumes']}"
    if common := answer["common_offset_s"]:
        yield _ahead(common)
        yield f"  if {common['assumes']}"
    if (ideal := answer["ideal_offset_s"]) and (ideal_drift := answer["ideal_drift"]):
        yield f"{_ahead(ideal)}; {_drift(ideal_drift)}"
        yield f"  if {ideal['assumes']}"
    for pair in answer["inseparable"]:
        yield f"{' and '.join(pair['members'])} are hardly told apart: {pair['correlation']:+.3f}"


def _ahead(offset: Members, since: str = "") -> str:
    return f"clock {offset['value']:+.6f} s{since}, 1 sigma {offset['sigma']:.2g}"


def _drift(drift: Members) -> str:
    return f"drift {1e6 * drift['value']:+.3f} ppm, 1 sigma {1e6 * drift['sigma']:.2g}"


def _errors(answer: Members) -> Iterator[dict[str, Any]]:
    """Of each axis, then of its phases, which have no lag of their own."""
    for name, axis in answer["axes"].items():
        yield {**axis, "axis": name, "phase": f"all, of {axis['basis']}", "from": ""}
        for phase in axis["phases"]:
            session = "" if phase["session"] is None else f" {phase['session'] + 1}"
            told = {"axis": "", "phase": f"{phase['kind']}{session}", "from": phase["start"][_TIME]}
            yield {**phase, **told, "lag_s": "", "lag_sigma_s": ""}


def _milliseconds(size: float | str | None) -> str:
    return size if isinstance(size, str) else "-" if size is None else f"{1e3 * size:.2f}"


def _what_it_did(name: str, axis: Members) -> Iterator[str]:
    if bias := axis["bias"]:
        gain = axis["gain"]
        told = f"gain {gain['value']:.7f}, 1 sigma {gain['sigma']:.2g}; " if gain else ""
        yield f"{name} {told}bias {_told(bias, '+.3f', axis['bias_unit'])}"
    if rate_bias := axis["rate_bias_arcsec_s"]:
        yield f"{name} rates: bias {_told(rate_bias, '+.3f', 'arcsec/s')}"
    if wander := axis["wander_arcsec"]:
        forgets = _told(axis["wander_half_life_s"], ".1f", "s")
        yield f"{name} wanders by {_told(wander, '.2f', 'arcsec')}; forgets half in {forgets}"
    for swing in axis["oscillations"]:
        yield (
            f"{name} oscillates {_span(swing)}: "
            f"{swing['frequency_hz']:.3f} Hz, {swing['amplitude_arcsec']:.2f} arcsec"
        )
    for stuck in axis["stick_slip"]:
        yield (
            f"{name} sticks and slips {_span(stuck)}: {stuck['slips']} slips of up to "
            f"{stuck['slip_arcsec']:.2f} arcsec below {stuck['rate_arcsec_s']:.1f} arcsec/s"
        )


def _told(estimate: Members, decimals: str, unit: str) -> str:
    return f"{estimate['value']:{decimals}} {unit}, 1 sigma {estimate['sigma']:.2g}"


def _span(stretch: Members) -> str:
    return f"{stretch['start'][_TIME]} to {stretch['stop'][_TIME]}"
