"""A real image sensor's view of a scene: the renderer's lens and electronics."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.spec import Within, spec

Image = NDArray[np.uint8] | NDArray[np.uint16]


@spec
class Sensor:
    """Lens blur, noise, depth and coding of an image.

    blur_px: 1-sigma of the lens's blur.
    exposure: brightness of the scene's 97th percentile as a fraction of saturation.
    full_well_e: electrons of a saturated pixel; 0 means no noise at all.
    read_noise_e: rms of the read-out's noise.
    gamma: 1 for raw data, 2.2 for a camera's JPEG.
    bits: depth of a pixel.
    colour: three channels instead of one.
    jpeg_quality: of the JPEG the image has been through; null for none. E.g. `90`.
    """

    blur_px: Annotated[float, Within(0.0, 50.0)] = 0.7
    exposure: Annotated[float, Within(0.01, 100.0)] = 0.7
    full_well_e: Annotated[float, Within(0.0, 1e9)] = 20e3
    read_noise_e: Annotated[float, Within(0.0, 1e9)] = 12.0
    gamma: Annotated[float, Within(0.1, 10.0)] = 1.0
    bits: Annotated[int, Within(8, 16)] = 8
    colour: bool = False
    jpeg_quality: Annotated[int, Within(1, 100)] | None = None

    def __post_init__(self) -> None:
        if self.bits not in (8, 16):
            raise ValueError(f"bits must be 8 or 16, not {self.bits}")

    def expose(self, radiance_ratio: Array, rng: np.random.Generator) -> Image:
        """A picture (h, w) or, in colour, (h, w, 3) of a scene's radiance (h, w, 3)."""
        import cv2  # no request needs it

        light = radiance_ratio if self.colour else radiance_ratio.mean(axis=2)
        light = cv2.GaussianBlur(light, (0, 0), self.blur_px) if self.blur_px > 0 else light
        brightest = float(np.percentile(light[::4, ::4], 97.0))
        light = light * (self.exposure / max(brightest, 1e-12))
        if self.full_well_e > 0.0:
            electrons = rng.normal(
                light * self.full_well_e, np.sqrt(light * self.full_well_e + self.read_noise_e**2)
            )
            light = electrons / self.full_well_e
        light = np.clip(light, 0.0, 1.0) ** (1.0 / self.gamma)
        if self.bits == 16:
            return np.asarray(np.rint(light * 65535.0), dtype=np.uint16)
        picture = np.asarray(np.rint(light * 255.0), dtype=np.uint8)
        if self.jpeg_quality is None:
            return picture
        _, coded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg_quality])
        return np.asarray(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED), dtype=np.uint8)
