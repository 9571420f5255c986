"""`slewtrack horizon`: the local vertical is measured in image files and reported."""

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from app.cli.files import WholeAnswer, problem_to, takes_standard_output, write_json
from app.cli.planner import Members
from app.cli.report_parts import print_rows, print_warnings, report_console

_STYLES = {"inconsistent": "red", "not_observable": "yellow"}


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
        from app.cli.horizon_images import measure_frames, measure_one
        from app.work.horizon_series import read_series

        body = request.read_bytes()
        series = read_series(body)
        if series is None:
            answer = measure_one(body, images, overlay)
            print_estimate(console, answer)
        else:
            answer = measure_frames(series, body, images)
            print_series(console, answer)
        write_json(json, answer)


def print_estimate(console: Console, estimate: Members) -> None:
    """Verdict, nadirs, check, cameras, warnings."""
    console.print(_verdict(estimate))
    for name, member in (("geocentric", ""), ("geodetic", "geodetic_")):
        nadir, sigma_deg = estimate[f"nadir_{member}body"], estimate[f"{member}sigma_deg"]
        if nadir is not None:
            axes = ", ".join(f"{part:.6f}" for part in nadir)
            console.print(Text(f"{name} nadir in body axes [{axes}], 1 sigma {sigma_deg:.4f} deg"))
    height_km, sigma_km = estimate["limb_height_km"], estimate["limb_height_sigma_km"]
    if height_km is not None and sigma_km is not None:
        console.print(f"limb {height_km:.1f} km high, 1 sigma {sigma_km:.1f} km")
    if (check := estimate["check"]) is not None:
        console.print(
            f"off the prediction by {check['angle_deg']:.4f} deg "
            f"({check['along_deg']:+.4f} along, "
            f"{check['across_deg']:+.4f} across), probability {check['probability']:.2g}",
        )
    why = estimate["explanation"]
    print_rows(
        console, None, estimate["cameras"],
        ("<camera", "name"), ("arc deg", "arc_deg", ".1f"), ("residual px", "residual_px", ".2f"),
        ("~used", lambda one: "yes" if one["used"] else f"no: {one['explanation'] or why}"),
    )  # fmt: skip
    print_warnings(console, estimate["warnings"])


def print_series(console: Console, series: Members) -> None:
    """One line per frame, then the bias."""
    print_rows(
        console, None, series["frames"],
        ("<UTC", "at"), ("<verdict", "verdict"), ("sigma deg", "sigma_deg", ".4f"),
        ("along deg", "along_deg", ".4f"), ("across deg", "across_deg", ".4f"),
        ("~reason", "reason", lambda reason: reason or ""),
    )  # fmt: skip
    console.print(_verdict(series))
    if not series["used"]:
        return
    for axis, name in enumerate(("along", "across")):
        sigma_deg = math.sqrt(series["covariance_deg2"][axis][axis])
        console.print(
            f"bias {name} {series['bias_deg'][axis]:+.4f} deg, 1 sigma {sigma_deg:.4f}, "
            f"scatter {series['scatter_deg'][axis]:.4f}"
        )
    console.print(
        f"{series['used']} of {len(series['frames'])} frames used, probability "
        f"{series['probability']:.2g}"
    )


def _verdict(answer: Members) -> Text:
    verdict, why = answer["verdict"], answer.get("explanation")
    text = verdict.replace("_", " ") + (f": {why}" if why else "")
    return Text(text, style=_STYLES.get(verdict, "green"))
