"""The payload's boresight by SciPy's rotations, not by the planner's."""

import numpy as np
from scipy.spatial.transform import Rotation

from planner.world.platforms import ISS_HRC


def scipy_boresight(angle_rad, axes=ISS_HRC.axes_platform, zero_direction=(0.0, 0.0, 1.0)):
    """Unit vectors in the platform frame, (n, 3), by axis angles (n, 2), outer axis first."""
    outer, inner = axes
    turn_outer = Rotation.from_rotvec(np.outer(angle_rad[:, 0], outer))
    turn_inner = Rotation.from_rotvec(np.outer(angle_rad[:, 1], inner))
    return (turn_outer * turn_inner).apply(zero_direction)
