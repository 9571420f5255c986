"""The steadiness of the camera over closed-loop runs, as answers tell it."""

import math
from typing import Annotated

from planner.base.answer_members import (
    AngleSize,
    Count,
    HalfTurn,
    Member,
    NotNegative,
    Share,
    Signed,
    answer,
)
from planner.base.arrays import Array
from planner.world.platforms.gyro_craft import RATE_ERROR_MAX_RAD_S


@answer
class WindowSteadiness:
    """One imaging interval over all dispersed closed-loop runs.

    request: name of the request it belongs to.
    look: number of the strip, look or leg within the request, from 0.
    steady: within 0.001 deg/s on every axis in every run.
    rate_error_rad_s: largest per body axis.
    rate_error_rms_rad_s: root mean square of the vector.
    pointing_error_rad: largest angle between actual and commanded optical axis.
    settled_s: from the end of the interval before until steady for good.
    spare_s: from then to the start, negative when the camera starts too early.
    smear_px: largest over one exposure.
    momentum_margin_n_m_s: least distance to the sphere of momentum that the gyros can take in every
    direction, since the interval before.
    gimbal_margin: least distance from a singularity of the gyros since the interval before: the
    smallest singular value of their torque directions.
    gimbal_rate_max_rad_s: of the fastest gimbal.
    """

    request: str
    look: Count
    steady: bool
    rate_error_rad_s: Annotated[Array, Member("deg", 0.0, decimals=9)]  # at 5 ms steps
    rate_error_rms_rad_s: AngleSize
    pointing_error_rad: HalfTurn  # what the computer can't know included
    settled_s: NotNegative
    spare_s: Signed
    smear_px: NotNegative  # the rate error across the optical axis times the exposure
    momentum_margin_n_m_s: Signed
    gimbal_margin: NotNegative
    gimbal_rate_max_rad_s: AngleSize


@answer
class StabilisationReport:
    """Closed-loop runs of the table.

    runs: number of dispersed runs.
    share_steady: of intervals times runs; null without any.
    worst_rad_s: largest rate error on any axis; null without any.
    windows: each interval over all runs.
    """

    runs: Count
    share_steady: Share | None
    worst_rad_s: AngleSize | None
    windows: tuple[WindowSteadiness, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Of images that would be blurred, or may be."""
        if self.runs == 0:
            return (
                "the table was not flown in closed loop, so whether the camera is steady enough is "
                "not known; ask for simulation_runs",
            )
        if self.share_steady is None or self.share_steady == 1.0:
            return ()
        return (
            f"in {self.runs} dispersed runs {self.share_steady:.0%} of the imaging intervals were "
            f"steady within {math.degrees(RATE_ERROR_MAX_RAD_S):g} deg/s; a longer "
            "settings.settle_s, a smaller settings.rate_axis_max_deg_s (the gyro reads 1.6) or the "
            'objective "smooth" leaves more',
        )
