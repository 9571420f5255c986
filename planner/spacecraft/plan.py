"""Plans an imaging session: candidates, choice and slews, table, verification, simulation."""

from contextlib import suppress
from dataclasses import dataclass

from planner.base import effort
from planner.base.commands import CommandTable
from planner.base.effort import WorkLimitReached, at_most
from planner.base.errors import (
    InfeasibleSlew,
    Refusal,
    SearchEnded,
    Unreachable,
    VerificationFailed,
)
from planner.base.reporting import Reporter, tell_nobody
from planner.planning.sessions.assembly import table_work
from planner.planning.sessions.pipeline import StageClock, complete_plan
from planner.planning.sessions.plan import Plan
from planner.spacecraft.flights import ASSUMPTIONS, stabilisation
from planner.spacecraft.found import (
    ImagingChoice,
    ImagingRequestSummary,
    ImagingSummary,
    SessionFound,
)
from planner.spacecraft.imaging.alternatives import refusal_with_alternative
from planner.spacecraft.imaging.choice import choose_and_slew, options_of
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.imaging.timeline import report_slews
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.verification import VerifiedWindow, verify_table
from planner.world.frames.time_scales import Instants


@dataclass(frozen=True, kw_only=True)
class SessionWork:
    """Of `effort`: what a session may take."""

    request_more: float = 150_000.0  # 1.5 s; a session of one request has 10 s
    session_most: float = 6_000_000.0  # a minute
    simulated_row: float = 4.5  # a row of the closed loop
    try_share: float = 0.25  # of a session's work, to find out whether an alternative to it works


OPTIONS = SessionWork()


@dataclass(frozen=True, kw_only=True)
class ImagingPlan(SessionFound):
    """The plan of a session; whole: of the body, whose sessions are the scans."""

    request: ImagingPlanRequest
    whole: Plan

    @property
    def table(self) -> CommandTable:
        return self.whole.table


def plan_imaging(request: ImagingPlanRequest, tell: Reporter = tell_nobody) -> ImagingPlan:
    """Plan, verify and simulate an imaging session.

    tell: is called when a stage begins, and with how many runs are flown.
    Raises Unreachable when no request can be seen, InfeasibleSlew when none can be turned to,
    VerificationFailed when the judge objects, SearchEnded when it takes more work than such a
    request may make.
    """
    with at_most(_bound_work(request)), suppress(SearchEnded):
        try:
            return _make_plan(request, tell)
        except (Unreachable, InfeasibleSlew) as why:
            tell("alternatives", 0, 1)
            with suppress(WorkLimitReached):
                raise refusal_with_alternative(request, why, _is_found) from why
            raise
    easier = ["ask for fewer or smaller requests at a time"]
    if request.objective == "minimum_time":
        easier.append('for the objective "smooth"')
    if any(request.settings.momentum_n_m_s):
        easier.append("for less momentum in the gyros")
    raise SearchEnded(
        "what is asked of this session takes more work than may be done for it before any plan "
        f"is found; {', or '.join(easier)}",
        field="requests",
    )


def _bound_work(request: ImagingPlanRequest) -> float:
    """The work that may be done for a session."""
    more = OPTIONS.request_more * (len(request.requests) - 1)
    return min(effort.PLAN + more, OPTIONS.session_most)


def _is_found(request: ImagingPlanRequest) -> bool:
    """Whether a plan of it is found with a part of the work of a session."""
    with at_most(OPTIONS.try_share * _bound_work(request)), suppress(Refusal):
        return bool(_make_plan(request, tell_nobody, refine=False).windows)
    return False


def _make_plan(request: ImagingPlanRequest, tell: Reporter, *, refine: bool = True) -> ImagingPlan:
    clock = StageClock(tell=tell)
    with clock.time("candidates"):
        session = make_session(request)
        options, unseen = options_of(session)
    with clock.time("choice and slews"):
        chosen = choose_and_slew(session, options, refine=refine)
    timeline = chosen.timeline
    effort.count(table_work(timeline.scenario, timeline.joins[-1].stop_row))
    whole = complete_plan(timeline.scenario, session.ephemeris, timeline.joins, clock)
    verification = verify_table(whole.table, whole.verification, timeline.windows, request)
    if not verification.passed:
        raise VerificationFailed("; ".join(verification.findings))
    tell("bound", 0, 1)
    value = chosen.choice.value
    bound = max(chosen.first.bound(session.priorities), value)
    warnings, slews = whole.warnings, tuple(report_slews(session.platform, whole))
    # As many as may still be made, one at least where any is asked for.
    run_work = OPTIONS.simulated_row * len(whole.table.position)
    runs = min(request.simulation_runs, max(int(effort.remaining() / run_work), 1))
    effort.count(runs * run_work)
    if runs < request.simulation_runs:
        warnings += (
            f"{runs} of the {request.simulation_runs} dispersed runs were flown: more would take "
            "more work than may be made for one session",
        )
    tell("flight", 0, runs)
    report = stabilisation(
        session.spacecraft,
        whole.table,
        verification.windows,
        session.ephemeris.states(Instants(whole.table.epoch_utc, whole.table.t_s)),
        range(request.seed, request.seed + runs),
        lambda done: tell("flight", done, runs),
    )
    return ImagingPlan(
        name=request.name,
        spacecraft=request.spacecraft,
        summary=_summary(request, verification.windows),
        request=request,
        whole=whole,
        windows=verification.windows,
        slews=slews,
        choice=ImagingChoice(value=value, greedy_value=chosen.choice.greedy_value, bound=bound),
        left_out=(*unseen, *chosen.left_out),
        verification=verification,
        stabilisation=report,
        assumptions=ASSUMPTIONS,
        warnings=(*warnings, *report.warnings),
    )


def _summary(request: ImagingPlanRequest, windows: tuple[VerifiedWindow, ...]) -> ImagingSummary:
    looks = {one.name: [w for w in windows if w.request == one.name] for one in request.requests}
    return ImagingSummary(
        name=request.name,
        platform=request.spacecraft,
        targets=tuple(looks),
        start_utc=request.start,
        stop_utc=request.stop,
        requests=tuple(
            ImagingRequestSummary(
                request=one.name,
                mode=one.mode,
                looks=len(looks[one.name]),
                start_utc=looks[one.name][0].start_utc if looks[one.name] else None,
                stop_utc=looks[one.name][-1].stop_utc if looks[one.name] else None,
            )
            for one in request.requests
        ),
    )
