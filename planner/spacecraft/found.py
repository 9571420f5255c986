"""Slews of a session beside their baselines, and how good its choice is."""

from typing import Annotated, Literal

from planner.base.answer_members import Count, Internal, Member, NotNegative, Share, answer
from planner.world.frames.time_scales import RowUtc


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
    first_row: Internal[int]
    last_row: Internal[int]


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
