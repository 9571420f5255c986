"""Frames that hold the target, and their sharpness."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask, cross
from planner.motion.pointing.frame import places_in_frame
from planner.world.platforms import PlatformGeometry, Shutter

EXPOSURE_POINTS = 16  # 50 a second for the HRC: structure and drives swing at a few hertz
_WAYS = np.linspace(0.0, math.pi, 16, endpoint=False)  # a path is told up to 0.5 % too short
_WAY = np.array([np.cos(_WAYS), np.sin(_WAYS)])
# No frame is wider than 170 deg; a target farther out or behind the camera counts as there.
FARTHEST_RAD = math.radians(85.0)
_FARTHEST = math.tan(FARTHEST_RAD)


@dataclass(frozen=True, kw_only=True, eq=False)
class Frames:
    """What n frames show of the target.

    begins_s: when each shutter opens.  place_px: where the target is half-way through the exposure,
    from the frame's middle along its sides, (n, 2).  error_rad: the largest angle
    between the boresight and the target while the shutter is open.  smear_px: the longest way
    between two places of the target in the image meanwhile.  Both end where no frame reaches.
    share: of half of what holds the target, how far it is from the middle, along the side where
    that is more; it is inside up to 1.  All others (n,).
    """

    begins_s: Array
    place_px: Array
    error_rad: Array
    smear_px: Array
    share: Array

    @classmethod
    def joined(cls, blocks: Sequence["Frames"]) -> "Frames":
        """One after the other."""
        return cls(
            **{
                name: np.concatenate([getattr(block, name) for block in blocks])
                for name in cls.__dataclass_fields__
            }
        )

    @property
    def holds(self) -> Mask:
        """Whether the target is inside from the first moment of a frame to its last."""
        return self.share <= 1.0

    @property
    def is_sharp(self) -> Mask:
        """Whether it is that, and smeared over less than a pixel."""
        return self.holds & (self.smear_px < 1.0)


def exposures_s(
    camera: Shutter,
    start_s: float,
    stop_s: float,
    image_rad_s: Callable[[Array], Array] = np.zeros_like,
) -> Array:
    """Instants of each exposure from `start_s` to `stop_s`, (n, EXPOSURE_POINTS).

    The first frame begins with the session; one that would end after it isn't taken, unless no
    other is: a session shorter than an exposure has one frame as long as itself.
    image_rad_s: at instants (n,), how fast the image moves across the camera's lines.
    """
    session_s = stop_s - start_s
    shortest_s = min(camera.exposure_s, session_s)
    count = math.floor((session_s - shortest_s) * camera.frames_per_s + 1e-9) + 1
    begins_s = start_s + np.arange(count) / camera.frames_per_s
    lasts_s = np.minimum(camera.exposures_s(image_rad_s(begins_s)), session_s)
    is_over = begins_s + lasts_s <= stop_s + 2e-9 / camera.frames_per_s
    begins_s, lasts_s = begins_s[is_over], lasts_s[is_over]
    return np.asarray(begins_s[:, None] + np.linspace(0.0, lasts_s, EXPOSURE_POINTS, axis=1))


def frames_of(
    platform: PlatformGeometry,
    at_s: Array,
    position: Array,
    turn_rad: Array,
    directions_base: Array,
) -> Frames:
    """From the true motion and the true direction of the target.

    at_s: (n, p), instants of each exposure.  position: (n p, c), true, of axes their shafts', then.
    turn_rad: (n p, 3), how the camera has turned beside it, a small rotation vector in the axes of
    the base.  directions_base: (n p, 3), unit vectors.  Leaves out the turn of the
    image about the boresight, which smears the frame's corners, and the air.
    """
    seen = directions_base - cross(turn_rad, directions_base)
    place = places_in_frame(platform, position, seen).reshape(*at_s.shape, 2)
    with np.errstate(invalid="ignore"):  # of what is behind the camera
        ways = place @ _WAY
        extent = np.max(ways.max(axis=1) - ways.min(axis=1), axis=1)
    half = np.tan(np.minimum(platform.held_half_rad, FARTHEST_RAD))
    middle = place[:, at_s.shape[1] // 2]
    return Frames(
        begins_s=at_s[:, 0],
        place_px=np.clip(middle, -_FARTHEST, _FARTHEST) / platform.camera.pixel_rad,
        error_rad=np.arctan(np.hypot(place[..., 0], place[..., 1]).max(axis=1)),
        smear_px=np.fmin(extent, _FARTHEST) / platform.camera.pixel_rad,
        share=np.abs(place / half).max(axis=(1, 2)),
    )
