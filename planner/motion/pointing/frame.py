"""The camera's frame on the platform, and where in it a direction is seen."""

import numpy as np

from planner.base.arrays import Array, cross
from planner.motion.pointing.angles import boresight_platform, carried_axes
from planner.world.platforms import TwoAxisPlatform


def frame_axes(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """Directions along the frame's sides, both square to the boresight, (n, 2, 3)."""
    return _side_axes(platform, angle_rad, boresight_platform(platform, angle_rad))


def places_in_frame(platform: TwoAxisPlatform, angle_rad: Array, los_platform: Array) -> Array:
    """Where directions are seen in the frame: tangents of their angles from its middle, (n, 2).

    angle_rad: (n, 2).  los_platform: unit vectors (n, 3).  In the order of the frame's sides;
    infinite for what stands beside or behind the camera.
    """
    boresight = boresight_platform(platform, angle_rad)
    sides = _side_axes(platform, angle_rad, boresight)
    ahead = np.sum(boresight * los_platform, axis=1)[:, None]
    across = np.einsum("nij,nj->ni", sides, los_platform)
    return np.where(ahead > 0.0, across / np.where(ahead > 0.0, ahead, 1.0), np.inf)


def _side_axes(platform: TwoAxisPlatform, angle_rad: Array, boresight_direction: Array) -> Array:
    inner = carried_axes(platform, angle_rad)[1]
    along = inner - np.sum(inner * boresight_direction, axis=1)[:, None] * boresight_direction
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    c, s = np.cos(platform.frame_turn_rad), np.sin(platform.frame_turn_rad)
    first = c * along + s * cross(boresight_direction, along)
    return np.stack([first, cross(boresight_direction, first)], axis=1)
