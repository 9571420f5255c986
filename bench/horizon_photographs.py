"""A rendered scene as a crew's photograph would show it.

All that a photograph adds and nobody calibrates: sRGB with a contrast curve, vignetting, an
exposure of its own, lateral colour, a window's reflections, panels in frame with bright edges,
sharpening halos at the limb, and JPEG with its colour at half resolution.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator.rendering.sensor import Image

Floats = NDArray[np.float64]
Picture = NDArray[np.float32]

_FULL_WELL_E, _READ_NOISE_E = 15e3, 10.0
_HALF_WIDTH_TAN = np.tan(np.deg2rad(30.0))


class Photograph:
    """Stands where a `Sensor` does, with everything about it drawn at random."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.exposure = rng.uniform(0.5, 1.3)
        self.contrast = rng.uniform(0.0, 0.6)
        self.vignetting = rng.uniform(0.0, 0.8)
        self.reflection = rng.uniform(0.0, 0.06) * (rng.random() < 0.5)
        self.panels = int(rng.integers(1, 3)) * int(rng.random() < 0.5)
        self.lateral_colour = rng.uniform(-1e-3, 1e-3)
        self.sharpening = rng.uniform(0.0, 1.5)
        self.jpeg_quality = int(rng.integers(50, 96))
        self.blur_px = rng.uniform(0.5, 1.3)

    def expose(self, scene: Floats, rng: np.random.Generator) -> Image:
        light = self._through_lens(scene.astype(np.float32))
        brightest = float(np.percentile(light[::4, ::4].mean(axis=2), 97.0))
        light *= np.float32(self.exposure / max(brightest, 1e-9))
        for _ in range(self.panels):
            light = _with_panel(light, rng)
        if self.reflection:
            light = self._behind_glass(light, rng)
        light = cv2.GaussianBlur(light, (0, 0), self.blur_px)
        electrons = np.maximum(light * _FULL_WELL_E, 0.0)
        electrons = rng.normal(electrons, np.sqrt(electrons + _READ_NOISE_E**2))
        return self._developed(np.clip(electrons / _FULL_WELL_E, 0.0, 1.0))

    def _through_lens(self, light: Picture) -> Picture:
        height, width = light.shape[:2]
        y, x = np.mgrid[0:height, 0:width].astype(np.float32)
        x -= 0.5 * (width - 1)
        y -= 0.5 * (height - 1)
        bent = []
        for channel, scale in enumerate((self.lateral_colour, 0.0, -self.lateral_colour)):
            place = [
                (axis * (1.0 + scale) + 0.5 * (size - 1)).astype(np.float32)
                for axis, size in ((x, width), (y, height))
            ]
            one = np.ascontiguousarray(light[..., channel])
            bent.append(cv2.remap(one, *place, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
        tan2 = (x**2 + y**2) * (_HALF_WIDTH_TAN / (0.5 * width)) ** 2
        return np.stack(bent, axis=-1) * ((1.0 + tan2) ** (-2.0 * self.vignetting))[..., None]

    def _behind_glass(self, light: Picture, rng: np.random.Generator) -> Picture:
        height, width = light.shape[:2]
        room = cv2.GaussianBlur(light[:, ::-1], (0, 0), width / 60.0)
        shift = np.array([[1.0, 0.0, rng.uniform(5, 25)], [0.0, 1.0, rng.uniform(-15, 15)]])
        second = cv2.warpAffine(light, shift, (width, height), borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(light + self.reflection * (room + 0.25 * second))

    def _developed(self, light: Floats) -> Image:
        tone = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        tone += self.contrast * (tone**2 * (3.0 - 2.0 * tone) - tone)
        tone += self.sharpening * (tone - cv2.GaussianBlur(tone, (0, 0), 1.2))
        picture = np.rint(np.clip(tone, 0.0, 1.0) * 255.0).astype(np.uint8)
        _, coded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg_quality])
        return np.asarray(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def _with_panel(light: Picture, rng: np.random.Generator) -> Picture:
    """A solar panel from somewhere in the frame down past its edge, its rim in the sun."""
    height, width = light.shape[:2]
    lean = rng.uniform(-0.6, 0.6)
    along = np.array([np.sin(lean), np.cos(lean)])
    half = 0.5 * rng.uniform(0.04, 0.16) * width * np.array([along[1], -along[0]])
    top = np.array([rng.uniform(0.0, width), rng.uniform(-0.2, 0.5) * height])
    end = top + 1.5 * height * along
    corners = np.array([top - half, top + half, end + half, end - half])
    outline = [np.rint(16.0 * corners).astype(np.int32)]
    face = np.zeros((height, width), np.uint8)
    cv2.fillPoly(face, outline, 255, cv2.LINE_AA, 4)
    rim = np.zeros((height, width), np.uint8)
    cv2.polylines(rim, outline, True, 255, 2, cv2.LINE_AA, 4)
    for mask, level in ((face, rng.uniform(0.02, 0.5)), (rim, rng.uniform(0.3, 1.5))):
        cover = (mask / np.float32(255.0))[..., None]
        light = light * (1.0 - cover) + cover * np.float32(level)
    return light
