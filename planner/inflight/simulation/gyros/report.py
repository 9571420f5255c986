"""The steadiness of a body with gyros, as answers tell it."""

from typing import Annotated

import numpy as np

from planner.base.answer_members import (
    AngleSize,
    HalfTurn,
    Member,
    NotNegative,
    Share,
    Signed,
    answer,
)
from planner.base.arrays import Array


@answer
class GyroSteadiness:
    """The steadiness of a body with gyros while the camera images, the worst of all runs.

    steady: share of the runs that are steady: within 0.001 deg/s about each axis throughout. E.g.
    `1.0`.
    rate_error_rad_s: largest per body axis. E.g. `[0.0003, 0.0002, 0.0004]`.
    rate_error_rms_rad_s: root mean square of the vector, of all runs together. E.g. `0.0001`.
    pointing_error_rad: largest angle between the attitude and the commanded one. E.g. `0.0007`.
    spare_s: from when the body is steady for good to the start, negative when the camera starts
    too early. E.g. `2.6`.
    torque_max_n_m: length of the gyros' largest torque in the flight to the session and in it.
    [N m] E.g. `14.2`.
    momentum_max_n_m_s: length of the largest momentum that they held meanwhile. [N m s] E.g.
    `31.5`.
    gimbal_margin: least distance from a singularity meanwhile: the smallest singular value of
    their torque directions. E.g. `1.08`.
    gimbal_rate_max_rad_s: of the fastest gimbal meanwhile. E.g. `20.3`.
    """

    steady: Share
    rate_error_rad_s: Annotated[Array, Member("deg", 0.0, decimals=9)]
    rate_error_rms_rad_s: AngleSize
    pointing_error_rad: HalfTurn
    spare_s: Signed
    torque_max_n_m: NotNegative
    momentum_max_n_m_s: NotNegative
    gimbal_margin: NotNegative
    gimbal_rate_max_rad_s: AngleSize


def worst_of(numbers: Array) -> GyroSteadiness | None:
    """Of those of r runs, (r, 11); None of a platform without gyros, (r, 0)."""
    if numbers.shape[1] == 0:
        return None
    least, most = numbers.min(axis=0).tolist(), numbers.max(axis=0).tolist()
    return GyroSteadiness(
        steady=float(numbers[:, 0].mean()),
        rate_error_rad_s=numbers[:, 1:4].max(axis=0),
        rate_error_rms_rad_s=float(np.sqrt(np.mean(numbers[:, 4] ** 2))),
        pointing_error_rad=most[5],
        spare_s=least[6],
        torque_max_n_m=most[7],
        momentum_max_n_m_s=most[8],
        gimbal_margin=least[9],
        gimbal_rate_max_rad_s=most[10],
    )
