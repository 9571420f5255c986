"""The camera's frame against the platform's base, and where in it a direction is seen."""

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.world.platforms import PlatformGeometry


def frame_axes(platform: PlatformGeometry, position: Array) -> Array:
    """Directions along the frame's sides in the base's axes, square to the boresight, (n, 2, 3).

    position: as `Motion` has it, (n, c).
    """
    return np.asarray(_q_frame_from_base(platform, position).as_matrix()[:, :2])


def places_in_frame(platform: PlatformGeometry, position: Array, directions_base: Array) -> Array:
    """Where directions are seen in the frame: tangents of their angles from its middle, (n, 2).

    position: (n, c).  directions_base: unit vectors (n, 3).  In the order of the frame's sides;
    infinite for what stands beside or behind the camera.
    """
    seen = _q_frame_from_base(platform, position).apply(directions_base)
    ahead = seen[:, 2:]
    return np.where(ahead > 0.0, seen[:, :2] / np.where(ahead > 0.0, ahead, 1.0), np.inf)


def _q_frame_from_base(platform: PlatformGeometry, position: Array) -> Rotation:
    turn = Rotation.from_rotvec([0.0, 0.0, -platform.frame_turn_rad])
    return turn * platform.q_payload_from_base(position)
