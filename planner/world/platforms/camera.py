"""The camera of a platform: pixel, exposure, frame rate."""

import math
from typing import Annotated, Protocol

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within, spec

HRC_PIXEL_ARCSEC = math.degrees(1.15 / 350e3) * 3600.0  # 1.15 m from 350 km: Sumarokov 2016
PIXELS_ARCSEC = (1e-4, 36e3)


class Shutter(Protocol):
    """How often a camera looks, and how long at a time."""

    @property
    def pixel_rad(self) -> float: ...
    @property
    def exposure_s(self) -> float: ...
    @property
    def frames_per_s(self) -> float: ...
    def exposures_s(self, image_rad_s: Array) -> Array:
        """Of n frames, where the image moves so fast across the camera's lines; 0: it stands."""
        ...


@spec
class Camera:
    """A camera that takes one frame after the other; the HRC's figures unless given.

    Source: Sumarokov 2016, p. 85.

    pixel_arcsec: angle a pixel sees, in the middle of the frame.
    exposure_s: time for which the shutter is open for a frame.
    frames_per_s: number of frames that begin in a second. [1/s]
    """

    pixel_arcsec: Annotated[float, Within(*PIXELS_ARCSEC)] = HRC_PIXEL_ARCSEC
    exposure_s: Annotated[float, Within(1e-6, 60.0)] = 0.3
    frames_per_s: Annotated[float, Within(1e-3, 100.0)] = 3.0

    def __post_init__(self) -> None:
        if self.exposure_s * self.frames_per_s > 1.0 + 1e-9:
            raise ValueError(
                f"exposure_s must end before the next frame begins, {1.0 / self.frames_per_s:g} s "
                f"later at {self.frames_per_s:g} frames_per_s, not last {self.exposure_s:g} s"
            )

    @property
    def pixel_rad(self) -> float:
        """Angle a pixel sees, in the middle of the frame."""
        return math.radians(self.pixel_arcsec / 3600.0)

    def exposures_s(self, image_rad_s: Array) -> Array:
        """The same, however fast the image moves."""
        return np.full(len(image_rad_s), self.exposure_s)


HRC_CAMERA = Camera()
