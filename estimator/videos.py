"""The pictures of videos, one film per camera, at even times."""

import math
from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from estimator.errors import InvalidImage
from estimator.images import Pixels


def video_frames(
    paths: Sequence[str], step_s: float, most: int
) -> tuple[int, Iterator[list[Pixels]]]:
    """The number of pictures every step_s in videos, one per camera, and the pictures; at most so
    many."""
    films = [cv2.VideoCapture(path) for path in paths]
    counts = []
    for path, film in zip(paths, films, strict=True):
        rate_hz = film.get(cv2.CAP_PROP_FPS)
        last = film.get(cv2.CAP_PROP_FRAME_COUNT) - 1.0
        if not film.isOpened() or not rate_hz > 0.0 or last < 0.0:
            raise InvalidImage(f"{path} is not a video that OpenCV can read", field="images")
        counts.append(math.floor((last + 0.1) / rate_hz / step_s) + 1)
    count = min([*counts, most])
    return count, ([_picture_at(film, k * step_s) for film in films] for k in range(count))


def _picture_at(film: cv2.VideoCapture, t_s: float) -> Pixels:
    """The first picture at or after t_s, to a tenth of a frame; pictures before it are passed."""
    wanted = math.ceil(t_s * film.get(cv2.CAP_PROP_FPS) - 0.1)
    while film.get(cv2.CAP_PROP_POS_FRAMES) < wanted and film.grab():
        pass
    done, picture = film.read()
    if not done:
        raise InvalidImage(f"the video breaks off {t_s:.3f} s after its start", field="images")
    return np.asarray(picture, dtype=np.uint8)
