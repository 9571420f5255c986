"""How is an imaging session planned?  Candidates, choice, timeline, gimbals, judges."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.commands import ROWS_PER_S
from planner.errors import InfeasibleSlew, InvalidInput, Refusal, Unreachable, VerificationFailed
from planner.frames.time_scales import elapsed_s
from planner.spacecraft.flight.simulation import fly_many
from planner.spacecraft.flight.stabilisation import (
    ASSUMPTIONS,
    StabilisationReport,
    flown_windows,
    stabilisation,
)
from planner.spacecraft.imaging.candidates import Candidate, ImagingSession, candidates
from planner.spacecraft.imaging.choose import Choice, choose
from planner.spacecraft.imaging.ground_arc import fitted_profile
from planner.spacecraft.imaging.timeline import (
    InertialHold,
    Misfit,
    Outcome,
    PlannedTurn,
    Timeline,
    TurnsDoNotFit,
    build_timeline,
    looks_of,
)
from planner.spacecraft.imaging.way_out import refusal_with_way_out
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import TICK_S, AttitudeTable
from planner.spacecraft.turns.turn_time import MovingEnds, turn_time
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.spacecraft.vehicle.gimbals import gimbal_rows, total_momentum_eci
from planner.spacecraft.verification import SpacecraftVerification, verify_table

Array = NDArray[np.float64]
EASES_S = (3.0, 1.5, 0.6)  # tried in this order, added to every turn
EASED_ROUNDS = 2
HOPELESS_S = 10.0  # missing: no other moment to image the same will do
ROUNDS = 12  # choices revised when a turn needs more time than estimated


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A request that isn't imaged, and why."""

    name: str
    reason: str


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
    InvalidInput for momentum beyond the sphere, VerificationFailed when the judge objects.
    """
    try:
        return _planned(request)
    except (Unreachable, InfeasibleSlew, InvalidInput) as why:
        refusal = refusal_with_way_out(
            request, why, lambda other: make_session(other, other.definition()), _works
        )
        raise refusal from why


def _works(request: ImagingPlanRequest) -> bool:
    try:
        return bool(_planned(request).table.windows)
    except Refusal:
        return False


def _planned(request: ImagingPlanRequest) -> ImagingPlan:
    spacecraft = request.definition()
    _refuse_momentum(request, spacecraft)
    session = make_session(request, spacecraft)
    options, left_out = _options(request, session)
    choice, timeline = _chosen(request, session, options)
    table = make_table(request, session, timeline)
    verification = verify_table(table, request)
    if not verification.passed:
        raise VerificationFailed("; ".join(verification.findings))
    states = session.ephemeris.states(session.instants(table.t_s))
    seeds = range(request.seed, request.seed + request.simulation_runs)
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
        warnings=session.ephemeris.warnings,
    )


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


def _options(
    request: ImagingPlanRequest, session: ImagingSession
) -> tuple[list[Candidate], tuple[LeftOut, ...]]:
    """Candidates that can be turned to from the session's start and back before its end."""
    found: list[Candidate] = []
    left_out: list[LeftOut] = []
    refusal: Refusal | None = None
    for number, one in enumerate(request.requests):
        try:
            found += _within_session(candidates(one, number, session), number, session)
        except (Unreachable, InfeasibleSlew) as why:
            refusal = refusal or why
            left_out.append(LeftOut(name=one.name, reason=why.detail))
    if not found and refusal is not None:
        raise refusal
    return found, tuple(left_out)


def _within_session(
    options: list[Candidate], number: int, session: ImagingSession
) -> list[Candidate]:
    profile = fitted_profile(
        None, session.ephemeris, session.epoch_utc, (-1.0, session.duration_s + 1.0)
    )
    kept = []
    for option in options:
        attitude, motion = profile.at(np.array([max(option.start_s - 20.0, 0.0), option.stop_s]))
        rest = MovingEnds(attitude.as_quat(), attitude.apply(motion.omega_body_rad_s))
        there_s = float(session.turn_time.ticks(rest[:1], option.entry)[0]) * TICK_S
        back_s = float(session.turn_time.ticks(option.exit, rest[1:])[0]) * TICK_S
        if there_s <= option.start_s and option.stop_s + back_s <= session.duration_s:
            kept.append(option)
    if not kept:
        first = options[0]
        raise InfeasibleSlew(
            f"the turn onto requests.{number} and back to orbital orientation needs about "
            f"{there_s:.1f} s before its start and {back_s:.1f} s after its end, more than the "
            f"session leaves (it could be imaged {first.start_s:.1f} to {first.stop_s:.1f} s "
            "after the start); start earlier or stop later by as much",
            field=f"requests.{number}",
            limit="time",
        )
    return kept


def _chosen(
    request: ImagingPlanRequest, session: ImagingSession, options: list[Candidate]
) -> tuple[Choice, Timeline]:
    """Choose and fly.  Where all that can be seen fits, the turns share the time left over:
    a slower turn shakes the structure less."""
    first = _choice(request, session, options, {}, set())
    if set(first.requests) == {option.request for option in options}:
        for ease_s in EASES_S:
            eased = replace(session, turn_time=session.turn_time.eased(ease_s))
            try:
                found = _flown_eased(request, eased, first)
            except InfeasibleSlew:  # the turns are as short as they can be already
                break
            if found is not None:
                return found
    return _flown(request, session, options, first, ROUNDS)


def _flown_eased(
    request: ImagingPlanRequest, eased: ImagingSession, first: Choice
) -> tuple[Choice, Timeline] | None:
    """Everything imaged with the longer turns, or None.  What the choice is measured by stays."""
    try:
        options, _ = _options(request, eased)
    except (Unreachable, InfeasibleSlew):
        return None
    choice = _choice(request, eased, options, {}, set())
    if choice.value < first.value:
        return None
    choice, timeline = _flown(request, eased, options, choice, EASED_ROUNDS)
    if choice.value < first.value:
        return None
    return replace(choice, bound=first.bound, greedy_value=first.greedy_value), timeline


def _flown(
    request: ImagingPlanRequest,
    session: ImagingSession,
    options: list[Candidate],
    choice: Choice,
    rounds: int,
) -> tuple[Choice, Timeline]:
    """Fly the choice; a pair whose turn doesn't fit gets the time it needs, and another is made."""
    extra: dict[tuple[int, int], int] = {}
    barred: set[int] = set()
    momentum = np.array(request.settings.momentum_n_m_s)
    names = [one.name for one in request.requests]
    known: dict[Hashable, Outcome] = {}
    misfits: tuple[Misfit, ...] = ()
    for revised in range(rounds):
        if len(barred) == len(options):
            break
        if revised:
            choice = _choice(request, session, options, extra, barred)
        try:
            timeline = build_timeline(
                session,
                looks_of(options, choice.chosen),
                names,
                momentum,
                request.objective,
                _initial(request),
                known,
            )
        except TurnsDoNotFit as why:
            misfits = why.misfits
            _learn(misfits, options, extra, barred)
            continue
        return choice, timeline
    refusal = misfits[0].why
    refusal.field = "requests"
    raise refusal


def _choice(
    request: ImagingPlanRequest,
    session: ImagingSession,
    options: list[Candidate],
    extra: dict[tuple[int, int], int],
    barred: set[int],
) -> Choice:
    """The best choice among those not barred; `chosen` counts all options."""
    open_ones = [k for k in range(len(options)) if k not in barred]
    place = {k: position for position, k in enumerate(open_ones)}
    choice = choose(
        [options[k] for k in open_ones],
        [one.priority for one in request.requests],
        session.turn_time,
        {
            (place[a], place[b]): ticks
            for (a, b), ticks in extra.items()
            if a in place and b in place
        },
    )
    return replace(choice, chosen=tuple(open_ones[k] for k in choice.chosen))


def _learn(
    misfits: Sequence[Misfit],
    options: Sequence[Candidate],
    extra: dict[tuple[int, int], int],
    barred: set[int],
) -> None:
    """Keep pairs further apart, and bar candidates that don't fit with themselves or the ends."""
    for one in misfits:
        if one.before is None or one.after is None or one.before == one.after:
            culprit = next(k for k in (one.after, one.before) if k is not None)
            barred.add(culprit)
            if one.why.missing_s > HOPELESS_S:
                request = options[culprit].request
                barred.update(k for k, other in enumerate(options) if other.request == request)
        else:
            extra[one.before, one.after] = max(one.ticks, extra.get((one.before, one.after), 0))


def _initial(request: ImagingPlanRequest) -> InertialHold | None:
    if request.initial_q_body_from_eci_xyzw is None:
        return None
    return InertialHold(Rotation.from_quat(request.initial_q_body_from_eci_xyzw).inv())


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
