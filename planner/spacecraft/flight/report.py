"""The steadiness of the camera over closed-loop runs, as answers tell it."""

import math

from planner.base.answer_members import AngleSize, Count, NotNegative, Share, Signed, answer
from planner.inflight.simulation.gyros.report import GyroSteadiness
from planner.world.platforms.gyro_craft import RATE_ERROR_MAX_RAD_S


@answer
class ImagingSteadiness(GyroSteadiness):
    """One imaging interval over all dispersed closed-loop runs, as of any body with gyros.

    request: name of the request it belongs to.
    look: number of the strip, look or leg within the request, from 0.
    steady: within 0.001 deg/s on every axis in every run.
    settled_s: from the end of the interval before until steady for good.
    smear_px: largest over one exposure.
    momentum_margin_n_m_s: least distance to the sphere of momentum that the gyros can take in every
    direction, since the interval before.
    """

    request: str
    look: Count
    steady: bool
    settled_s: NotNegative
    smear_px: NotNegative  # the rate error across the optical axis times the exposure
    momentum_margin_n_m_s: Signed


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
    windows: tuple[ImagingSteadiness, ...]

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
