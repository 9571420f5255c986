"""`slewtrack horizon`: the local vertical is measured in image files and reported."""

import base64
import math
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.text import Text

from app.cli import files
from app.cli.planner import Members, planner_at, told_progress
from app.cli.report_parts import print_rows, print_warnings
from planner.base.errors import InvalidInput

if TYPE_CHECKING:
    from app.work.horizon import HorizonFrames, HorizonSession
    from estimator.images import Pixels

_STYLES = {"inconsistent": "red", "not_observable": "yellow"}
_VIDEOS = {".mp4", ".avi", ".mkv", ".mov", ".m4v", ".mpg", ".mpeg", ".webm", ".ts"}


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
    json: files.WholeAnswer = None,
    url: files.Url = None,
) -> None:
    """Estimate the local vertical from images of the horizon."""
    with files.report_beside(json, overlay) as console:
        body = request.read_bytes()
        import cv2

        from app.work.horizon import read_series

        series = read_series(body)
        cv2.setNumThreads(1)  # a frame is too small to share
        if series is None:
            answer = _estimate(url, body, [path.read_bytes() for path in images], overlay)
            print_estimate(console, answer)
        elif url is not None:
            raise InvalidInput(
                "a service measures one frame at a time: leave it out for a series", field="--url"
            )
        else:
            answer = measure_frames(series, body, images)
            print_series(console, answer)
        files.write_json(json, answer)


def _estimate(
    url: str | None, body: bytes, images: Sequence[bytes], overlay: Path | None
) -> Members:
    if overlay is not None:
        from app.cli.changes import with_settings

        body = with_settings(body, ["overlay=true"])
    with planner_at(url) as planner:
        answer = planner.estimate_vertical(images, body).members
    if overlay is not None:
        cameras = answer["cameras"]
        paths = overlay_paths(overlay, [camera["name"] for camera in cameras])
        for path, camera in zip(paths, cameras, strict=True):
            files.write(path, base64.b64decode(camera["overlay_png"]))
    return answer


def overlay_paths(path: Path, cameras: Sequence[str]) -> list[Path]:
    """The path itself for one camera, with each camera's place and name for several."""
    if len(cameras) == 1:
        return [path]
    plain = ["".join(c if c.isalnum() else "-" for c in name)[:40] for name in cameras]
    if len(set(plain)) < len(plain):
        plain = [f"{k}-{name}" for k, name in enumerate(plain)]
    return [path.with_name(f"{path.stem}-{name}{path.suffix or '.png'}") for name in plain]


def measure_frames(
    request: "HorizonSession | HorizonFrames", body: bytes, paths: Sequence[Path]
) -> Members:
    """A series of frames, or videos."""
    from app.answers.members import provenance
    from app.work import horizon as series
    from app.work.progress import Progress
    from estimator.errors import InvalidImage
    from estimator.images import decode_image
    from estimator.videos import video_frames
    from slewtrack.client.reading import ParsedAnswer

    frames: Iterator[list[Pixels]]
    if all(path.suffix.lower() in _VIDEOS for path in paths):
        if not isinstance(request, series.HorizonSession) or len(paths) != len(request.cameras):
            raise InvalidImage(
                "videos go with a session (orbit, cameras, start, step_s), one per camera",
                field="images",
            )
        count, frames = video_frames(
            [str(path) for path in paths], request.step_s, series.FRAMES_MAX
        )
        requests = request.requests(count)
    else:
        requests, pictures = series.frame_requests(request, len(paths)), iter(paths)
        frames = (
            [
                decode_image(next(pictures).read_bytes(), f"frames.{number}.{camera.name}", camera)
                for camera in one.cameras
            ]
            for number, one in enumerate(requests)
        )
    with told_progress("frames") as tell:
        told = (
            tell(Progress(stage="frames", done=number, of=len(requests))) or frame
            for number, frame in enumerate(frames)
        )
        origin = provenance(datetime.now(UTC), body)
        return ParsedAnswer(series.series_json(requests, told, origin))


def print_estimate(console: Console, estimate: Members) -> None:
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
