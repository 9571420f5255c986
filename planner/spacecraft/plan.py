"""Plans an imaging session: candidates, choice and turns, gimbals, judges."""

from contextlib import suppress
from dataclasses import dataclass
from datetime import timedelta
from functools import partial

import numpy as np

from planner import effort
from planner.commands import ROWS_PER_S
from planner.effort import EffortSpent, at_most
from planner.errors import (
    InfeasibleSlew,
    InvalidInput,
    Refusal,
    SearchEnded,
    Unreachable,
    VerificationFailed,
)
from planner.frames.time_scales import elapsed_s
from planner.spacecraft.flight.simulation import fly_many
from planner.spacecraft.flight.stabilisation import (
    ASSUMPTIONS,
    StabilisationReport,
    flown_windows,
    stabilisation,
)
from planner.spacecraft.imaging.candidates import ImagingSession
from planner.spacecraft.imaging.choice_with_turns import LeftOut, choose_and_turn, options_of
from planner.spacecraft.imaging.choose import Choice
from planner.spacecraft.imaging.timeline import PlannedTurn, Timeline
from planner.spacecraft.imaging.way_out import refusal_with_way_out
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import TICK_S, AttitudeTable
from planner.spacecraft.turns.turn_time import turn_time
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.spacecraft.vehicle.gimbals import gimbal_rows, total_momentum_eci
from planner.spacecraft.verification import SpacecraftVerification, verify_table

# Of `planner.effort`: 10 s for a session of one request, 1.5 s for each more, a minute at most.
REQUEST_MORE, SESSION_MOST = 150_000.0, 6_000_000.0
FLOWN_ROW = 4.5


@dataclass(frozen=True, kw_only=True)
class ImagingPlan:
    """The plan of a session.

    table: what is flown.  turns: each beside its eigenaxis baselines.  choice: worth and bound
    of what was chosen (against the turn times as estimated).  stabilisation: of the dispersed
    closed-loop runs.  assumptions: what the numbers rest on that the paper doesn't give.
    """

    request: ImagingPlanRequest
    spacecraft: AgileSpacecraft
    table: AttitudeTable
    turns: tuple[PlannedTurn, ...]
    choice: Choice
    left_out: tuple[LeftOut, ...]
    verification: SpacecraftVerification
    stabilisation: StabilisationReport
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]


def plan_imaging(request: ImagingPlanRequest) -> ImagingPlan:
    """Plan, verify and simulate an imaging session.

    Raises Unreachable when no request can be seen, InfeasibleSlew when none can be turned to,
    InvalidInput for momentum beyond the sphere, VerificationFailed when the judge objects,
    SearchEnded when it takes more work than such a request may make.
    """
    more = REQUEST_MORE * (len(request.requests) - 1)
    with at_most(min(effort.PLAN + more, SESSION_MOST)):
        return _planned_or_refused(request)
    raise SearchEnded(
        "what is asked of this session takes more work than may be done for it before any plan "
        "is found; ask for fewer or smaller requests at a time",
        field="requests",
    )


def _planned_or_refused(request: ImagingPlanRequest) -> ImagingPlan:
    try:
        return _planned(request)
    except (Unreachable, InfeasibleSlew, InvalidInput) as why:
        with suppress(EffortSpent):
            raise refusal_with_way_out(
                request, why, lambda other: make_session(other, other.definition()), _works
            ) from why
        raise


def _works(request: ImagingPlanRequest) -> bool:
    try:
        return bool(_planned(request).table.windows)
    except Refusal:
        return False


def _planned(request: ImagingPlanRequest) -> ImagingPlan:
    spacecraft = request.definition()
    _refuse_momentum(request, spacecraft)
    session = make_session(request, spacecraft)
    options, left_out = options_of(request, session)
    choice, timeline, warnings = choose_and_turn(request, session, options)
    table = make_table(request, session, timeline)
    verification = verify_table(table, request)
    if not verification.passed:
        raise VerificationFailed("; ".join(verification.findings))
    states = session.ephemeris.states(session.instants(table.t_s))
    runs = _affordable_runs(request, len(table.t_s))
    seeds = range(request.seed, request.seed + runs)
    if runs < request.simulation_runs:
        warnings += (
            f"{runs} of the {request.simulation_runs} dispersed runs were flown: more would take "
            "more work than may be made for one session",
        )
    keep = partial(flown_windows, spacecraft, table, verification)
    return ImagingPlan(
        request=request,
        spacecraft=spacecraft,
        table=table,
        turns=timeline.turns,
        choice=choice,
        left_out=(*left_out, *_not_chosen(request, choice, left_out)),
        verification=verification,
        stabilisation=stabilisation(fly_many(spacecraft, table, states, seeds, keep)),
        assumptions=ASSUMPTIONS,
        warnings=(*session.ephemeris.warnings, *warnings),
    )


def _affordable_runs(request: ImagingPlanRequest, rows: int) -> int:
    """As many of the dispersed runs as may still be flown, one at least where any is asked for."""
    run = FLOWN_ROW * rows
    runs = min(request.simulation_runs, max(int(effort.remaining() / run), 1))
    effort.count(runs * run)
    return runs


def _refuse_momentum(request: ImagingPlanRequest, spacecraft: AgileSpacecraft) -> None:
    stored = float(np.linalg.norm(request.settings.momentum_n_m_s))
    sphere = spacecraft.slew.momentum_sphere_n_m_s
    if stored > sphere:
        raise InvalidInput(
            f"the gyros store {stored:.1f} N m s at the start, beyond the {sphere:.0f} N m s "
            f"sphere they are steered in; unload at least {stored - sphere:.1f} N m s first",
            field="settings.momentum_n_m_s",
            limit="momentum",
        )


def make_session(request: ImagingPlanRequest, spacecraft: AgileSpacecraft) -> ImagingSession:
    """The orbit and the spacecraft of a request, made ready."""
    margin = timedelta(seconds=200)
    return ImagingSession(
        ephemeris=request.orbit.ephemeris(request.start - margin, request.stop + margin),
        epoch_utc=request.start,
        duration_s=int(elapsed_s(request.stop, request.start) / TICK_S + 1e-6) * TICK_S,
        spacecraft=spacecraft,
        turn_time=turn_time(spacecraft),
    )


def make_table(
    request: ImagingPlanRequest, session: ImagingSession, timeline: Timeline
) -> AttitudeTable:
    """Rows of a timeline with the gimbal angles and rates that fly it."""
    spacecraft = session.spacecraft
    rows = len(timeline.motion.omega_body_rad_s)
    inertia = np.array(spacecraft.inertia_kg_m2)
    omega = timeline.motion.omega_body_rad_s
    states = session.ephemeris.states(session.instants(np.arange(rows) / ROWS_PER_S))
    gyros = np.array(request.settings.momentum_n_m_s)
    total = total_momentum_eci(
        timeline.attitude,
        timeline.attitude[0].apply(inertia * omega[0] + gyros),
        states.r_sat_eci_m,
        inertia,
    )
    imaging = np.zeros(rows - 1, dtype=bool)
    for window in timeline.windows:
        imaging[window.first_row : window.last_row] = True
    angles, rates = gimbal_rows(
        spacecraft.array,
        timeline.attitude.inv().apply(total) - inertia * omega,
        imaging,
        spacecraft.gains.null_gain_rad_s,
    )
    return AttitudeTable(
        epoch_utc=request.start,
        eci_from_body_xyzw=timeline.attitude.as_quat(),
        omega_body_rad_s=omega,
        alpha_body_rad_s2=timeline.motion.alpha_body_rad_s2,
        gimbal_rad=angles,
        gimbal_rate_rad_s=rates,
        windows=timeline.windows,
    )


def _not_chosen(
    request: ImagingPlanRequest, choice: Choice, left_out: tuple[LeftOut, ...]
) -> tuple[LeftOut, ...]:
    """Requests with candidates that the best choice has no time for."""
    done = set(choice.requests)
    unseen = {one.name for one in left_out}
    gap = "no better choice exists" if choice.proven_optimal else "the choice is not proven best"
    return tuple(
        LeftOut(name=one.name, reason=f"no time beside requests worth more ({gap})")
        for number, one in enumerate(request.requests)
        if number not in done and one.name not in unseen
    )
