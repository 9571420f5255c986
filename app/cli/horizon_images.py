"""The local vertical measured in image files: one frame, a series of them, or videos."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

import cv2

from app.answers.horizon import estimate_out
from app.answers.members import provenance, to_json
from app.cli.files import write
from app.cli.planner import ParsedAnswer
from app.cli.progress_bar import Tell, progress_bar
from app.requests.horizon import read_estimate_request
from app.work.horizon import measure
from app.work.horizon_series import (
    HorizonFrames,
    HorizonSession,
    frame_requests,
    measure_series,
    series_json,
    video_frames,
)
from estimator.errors import InvalidImage
from estimator.images import Pixels, decode_image
from estimator.request import HorizonRequest

_VIDEOS = {".mp4", ".avi", ".mkv", ".mov", ".m4v", ".mpg", ".mpeg", ".webm", ".ts"}


def measure_one(body: bytes, paths: Sequence[Path], overlay: Path | None) -> ParsedAnswer:
    """One frame, as the service answers it."""
    cv2.setNumThreads(1)  # a frame is too small to share
    images = tuple(path.read_bytes() for path in paths)
    request = read_estimate_request(body)
    estimate, overlays = measure(request, images, draw=overlay is not None)
    if overlay is not None:
        names = [camera.name for camera in request.cameras]
        for path, png in zip(overlay_paths(overlay, names), overlays, strict=True):
            write(path, png)
    origin = provenance(datetime.now(UTC), body, *images)
    shown = overlays if request.overlay else ()
    return ParsedAnswer(to_json(estimate_out(estimate, request.epoch, shown, origin)))


def overlay_paths(path: Path, cameras: Sequence[str]) -> list[Path]:
    """The path itself for one camera, with each camera's place and name for several."""
    if len(cameras) == 1:
        return [path]
    plain = ["".join(c if c.isalnum() else "-" for c in name)[:40] for name in cameras]
    if len(set(plain)) < len(plain):
        plain = [f"{k}-{name}" for k, name in enumerate(plain)]
    return [path.with_name(f"{path.stem}-{name}{path.suffix or '.png'}") for name in plain]


def measure_frames(
    request: HorizonSession | HorizonFrames, body: bytes, paths: Sequence[Path]
) -> ParsedAnswer:
    """A series of frames."""
    cv2.setNumThreads(1)
    if all(path.suffix.lower() in _VIDEOS for path in paths):
        if not isinstance(request, HorizonSession) or len(paths) != len(request.cameras):
            raise InvalidImage(
                "videos go with a session (orbit, cameras, start, step_s), one per camera",
                field="images",
            )
        count, films = video_frames([str(path) for path in paths], request.step_s)
        with progress_bar("frames") as tell:
            series = measure_series(request.requests(count), _told(films, count, tell))
    else:
        requests = frame_requests(request, len(paths))
        with progress_bar("frames") as tell:
            pictures = _told(_pictures(requests, iter(paths)), len(requests), tell)
            series = measure_series(requests, pictures)
    return ParsedAnswer(series_json(series, provenance(datetime.now(UTC), body)))


def _told(frames: Iterator[list[Pixels]], count: int, tell: Tell) -> Iterator[list[Pixels]]:
    """The same, each told as it is taken."""
    for number, frame in enumerate(frames):
        tell("frames", number, count)
        yield frame


def _pictures(requests: Sequence[HorizonRequest], paths: Iterator[Path]) -> Iterator[list[Pixels]]:
    for number, request in enumerate(requests):
        yield [
            decode_image(next(paths).read_bytes(), f"frames.{number}.{camera.name}", camera)
            for camera in request.cameras
        ]
