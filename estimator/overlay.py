"""The picture of what was measured in a frame."""

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.found import CameraReport, VerticalEstimate
from estimator.images import Pixels
from planner.base.arrays import Array

_MEASURED = (60, 255, 60)
_EXPECTED = (60, 160, 255)


def draw_overlay(
    pixels: Pixels,
    camera: HorizonCamera,
    report: CameraReport,
    estimate: VerticalEstimate,
    expected_px: Array | None = None,
    longest_px: int = 1600,
) -> NDArray[np.uint8]:
    """The frame in 8-bit colour with the limb points used (green), the limb a plan expects
    (orange; `HorizonView.limb_px`) and the verdict, reduced to longest_px a side."""
    shrink = max(1.0, max(pixels.shape[:2]) / longest_px)
    size = [max(round(side / shrink), 1) for side in pixels.shape[1::-1]]
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    scale = 1.0 / 257.0 if pixels.dtype == np.uint16 else 1.0
    picture = np.asarray(np.rint(small * scale), dtype=np.uint8)
    if picture.ndim == 2 or picture.shape[2] == 1:
        grey = picture.reshape(picture.shape[:2])
        picture = np.stack([grey, grey, grey], axis=-1)
    picture = np.ascontiguousarray(picture[..., :3])
    thick = max(1, picture.shape[1] // 800)
    if expected_px is not None and len(expected_px) > 1:
        line = np.rint(expected_px[np.isfinite(expected_px[:, 0])] / shrink).astype(np.int32)
        cv2.polylines(picture, [line], False, _EXPECTED, thick)
    for x, y in np.rint(report.limb_px[::3] / shrink).astype(int):
        cv2.circle(picture, (int(x), int(y)), thick, _MEASURED, -1)
    verdict = str(estimate.verdict)
    if estimate.geocentric is not None:
        verdict += f" +-{np.rad2deg(estimate.geocentric.sigma_rad):.3f} deg"
    lines = [f"{camera.name}: {verdict}", f"arc {report.arc_deg:.0f} deg"]
    if report.reason is not None:
        lines.append(report.reason.name.lower().replace("_", " "))
    letters = max(0.4, picture.shape[1] / 1400.0)
    for k, text in enumerate(lines):
        place = (8, int(40 * letters * (k + 1)))
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, letters, (0, 0, 0), 3 * thick)
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, letters, (255, 255, 255), thick)
    return picture


def encode_png(picture: Pixels) -> bytes:
    """The picture as a PNG file."""
    _, coded = cv2.imencode(".png", picture)
    return bytes(coded)
