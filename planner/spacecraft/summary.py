"""The summary of an imaging session, its slews beside baselines, and the worth of its choice."""

from typing import TYPE_CHECKING, Annotated, Literal

from planner.base.answer_members import Count, Member, NotNegative, answer
from planner.spacecraft.table import TICK_S
from planner.world.frames.time_scales import RowUtc, Utc, shifted_utc

if TYPE_CHECKING:
    from planner.spacecraft.plan import ImagingPlan
    from planner.spacecraft.requests import Request


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
    """The best choice found among the requests; a better one may exist.

    value: of the requests chosen.
    greedy_value: worth of the choice that takes the most valuable request that fits, one after
    another.
    """

    value: NotNegative
    greedy_value: NotNegative


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


def summarise(plan: "ImagingPlan") -> ImagingSummary:
    """Of a session as it was planned."""
    request = plan.request
    return ImagingSummary(
        name=request.name,
        platform=request.spacecraft,
        targets=tuple(one.name for one in request.requests),
        start_utc=request.start,
        stop_utc=request.stop,
        requests=tuple(_summarise_request(plan, one) for one in request.requests),
    )


def _summarise_request(plan: "ImagingPlan", request: "Request") -> ImagingRequestSummary:
    epoch_utc = plan.table.epoch_utc
    looks = [window for window in plan.windows if window.request == request.name]
    first_row = min((look.first_row for look in looks), default=None)
    last_row = max((look.last_row for look in looks), default=None)
    return ImagingRequestSummary(
        request=request.name,
        mode=request.mode,
        looks=len(looks),
        start_utc=None if first_row is None else shifted_utc(epoch_utc, first_row * TICK_S),
        stop_utc=None if last_row is None else shifted_utc(epoch_utc, last_row * TICK_S),
    )


def report_slews(plan: "ImagingPlan") -> tuple[AttitudeSlewReport, ...]:
    """In order of time."""
    epoch_utc = plan.table.epoch_utc
    return tuple(
        AttitudeSlewReport(
            start_utc=shifted_utc(epoch_utc, slew.first_row * TICK_S),
            stop_utc=shifted_utc(epoch_utc, slew.last_row * TICK_S),
            onto=slew.window,
            **vars(slew.comparison),
        )
        for slew in plan.slews
    )
