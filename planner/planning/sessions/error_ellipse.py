"""The 1-sigma error ellipse of the pointing in the image, over a session."""

import numpy as np

from planner.base.arrays import Array
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.planning.sessions.uncertainty import (
    DRIVE_RAD,
    PointingScene,
    error_biases,
)
from planner.planning.sessions.uncertainty import (
    OPTIONS as BUDGET_OPTIONS,
)
from planner.world.attitude import AttitudeLaw
from planner.world.orbits import Ephemeris
from planner.world.platforms import TwoAxisPlatform
from planner.world.targets import VisibleTarget


def error_covariance_rad2(
    los: LineOfSight,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw,
    target: VisibleTarget,
    platform: TwoAxisPlatform,
    angle_rad: Array,
    *,
    clock_s: float = BUDGET_OPTIONS.clock_s,
) -> Array:
    """Covariances of the image place by the causes of `pointing_budget`, shape (n, 2, 2).

    In the order of the frame's sides: the first, turned by `frame_turn_rad` from the inner axis
    about the boresight, and the second across it.  angle_rad: (n, 2), the axes at the instants of
    `los`.  Its mean per axis is the square of the budget's `sigma_arcsec`.
    """
    scene = PointingScene(los, attitude, target, platform, angle_rad, len(los.instants))
    errors = attitude.errors(scene.instants)
    covariance_rad2 = np.tile(DRIVE_RAD**2 * np.eye(2), (len(los.instants), 1, 1))
    for bias in error_biases(scene, los, ephemeris, errors, clock_s):
        for part_rad in (bias.offsets_rad, bias.quarter_later_rad):
            if part_rad is not None:
                covariance_rad2 += part_rad[:, :, None] * part_rad[:, None, :]
    return covariance_rad2
