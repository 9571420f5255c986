"""A session in figures: its requests, slews, steadiness, and how good its choice is."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from planner.base.answer_members import (
    AngleSize,
    Count,
    Member,
    NotNegative,
    Share,
    Signed,
    answer,
)
from planner.inflight.simulation.gyros.report import GyroSteadiness
from planner.spacecraft.requests import LeftOut
from planner.spacecraft.verification import SpacecraftVerification, VerifiedWindow
from planner.world.frames.time_scales import RowUtc, Utc
from planner.world.platforms.gyro_craft import RATE_ERROR_MAX_RAD_S


@answer
class AttitudeSlewReport:
    """One slew beside its baselines at the same limits.

    start_utc: first row; UTC.
    stop_utc: last row; UTC.
    onto: number of the window it leads to, null for orbital orientation.
    angle_rad: between the attitudes at its ends.
    duration_s: of the slew.
    eigenaxis_s: of the quickest slew found about the Euler axis within the same limits.
    bang_coast_bang_s: of the paper's about the Euler axis, with any torque rate.
    torque_rate_peak_n_m_s: largest torque rate of the slew, without what turns the momentum held.
    eigenaxis_torque_rate_peak_n_m_s: largest torque rate of the slew about the Euler axis.
    method: method of the solution.
    time_from: the method that found the time of a `minimum_time` slew, `ocp`; null for slews that
    take the time there is.
    status: status in which the solver ended.
    solve_s: time it took to solve.
    """

    start_utc: RowUtc
    stop_utc: RowUtc
    onto: Count | None
    angle_rad: Annotated[float, Member("deg", 0.0, 180.0)]
    duration_s: NotNegative
    eigenaxis_s: NotNegative
    bang_coast_bang_s: NotNegative
    torque_rate_peak_n_m_s: NotNegative
    eigenaxis_torque_rate_peak_n_m_s: NotNegative
    method: str
    time_from: Literal["ocp"] | None
    status: str
    solve_s: NotNegative


@answer
class ImagingChoice:
    """The best choice found among the requests.

    value: of the requests chosen.
    greedy_value: worth of the choice that takes the most valuable request that fits, one after
    another.
    bound: no choice is worth more whose scans begin at the times tried, however quick its slews.
    gap_share: the difference between bound and `value`, as a share of the bound. E.g. `0.01`.
    """

    value: NotNegative
    greedy_value: NotNegative
    bound: NotNegative

    @property
    def gap_share(self) -> Share:
        return 1.0 - self.value / self.bound if self.bound > 0.0 else 0.0


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


@answer
class ImagingRequestSummary:
    """One request as it is planned.

    request: its name.
    mode: strip, stereo, area or corridor. E.g. `"strip"`.
    looks: number of times that the camera is on for it; 0 where it is left out.
    start_utc: first time that it is; UTC, null where it is left out.
    stop_utc: last time that it is; UTC, null where it is left out.
    """

    request: str
    mode: str
    looks: Count
    start_utc: Utc | None
    stop_utc: Utc | None


@answer
class ImagingSummary:
    """Summary of the session.

    name: as the request gives it.
    platform: the spacecraft's name.
    targets: names of the requests.
    start_utc: row 0 of the table; UTC.
    stop_utc: latest time at which the spacecraft is back in orbital orientation; UTC.
    requests: in the order of the request.
    """

    name: str
    platform: str
    targets: tuple[str, ...]
    start_utc: Utc
    stop_utc: Utc
    requests: tuple[ImagingRequestSummary, ...]


@dataclass(frozen=True, kw_only=True)
class SessionFound:
    """What is known of a session beside its table.

    name: as the request gives it.
    spacecraft: the spacecraft's name.
    summary: requests of the session, in short.
    windows: scans of the session, in order of time.
    left_out: requests that don't fit, and why.
    choice: quality of the choice among the requests.
    slews: between the windows, in order of time.
    verification: result of the independent verification.
    stabilisation: steadiness of the camera in closed loop.
    assumptions: values assumed because the paper doesn't give them.
    warnings: cautions to read before flying it. E.g.
    `["in 4 dispersed runs 75% of the imaging intervals were steady within 0.001 deg/s"]`.
    """

    name: str
    spacecraft: str
    summary: ImagingSummary
    windows: tuple[VerifiedWindow, ...]
    left_out: tuple[LeftOut, ...]
    choice: ImagingChoice
    slews: tuple[AttitudeSlewReport, ...]
    verification: SpacecraftVerification
    stabilisation: StabilisationReport
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]
