"""Chooses what is imaged and turns between: a choice holds once every turn in it fits."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from planner import effort
from planner.effort import at_most
from planner.errors import InfeasibleSlew, Refusal, Unreachable
from planner.spacecraft.imaging.candidates import Candidate, ImagingSession, candidates
from planner.spacecraft.imaging.choose import Choice, choose
from planner.spacecraft.imaging.ground_arc import fitted_profile
from planner.spacecraft.imaging.timeline import (
    Attitudes,
    InertialHold,
    Misfit,
    Outcome,
    Timeline,
    TurnsDoNotFit,
    build_timeline,
    looks_of,
)
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turns.turn_time import MovingEnds, joined

EASES_S = (3.0, 1.5, 0.6)  # tried in this order, added to every turn
EASED_ROUNDS = 2
HOPELESS_S = 10.0  # missing: no other moment to image the same will do
ROUNDS = 12  # choices revised when a turn needs more time than estimated
REQUEST = 1_000.0  # of `planner.effort`
GENTLER_SHARE = 0.6  # of what work is left, for gentler turns


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A request that isn't imaged, and why."""

    name: str
    reason: str


def options_of(
    request: ImagingPlanRequest, session: ImagingSession
) -> tuple[list[Candidate], tuple[LeftOut, ...]]:
    """Candidates that can be turned to from the session's start and back before its end."""
    found: list[Candidate] = []
    left_out: list[LeftOut] = []
    refusal: Refusal | None = None
    rest = fitted_profile(
        None, session.ephemeris, session.epoch_utc, (-1.0, session.duration_s + 1.0)
    )
    for number, one in enumerate(request.requests):
        effort.spend(REQUEST)
        try:
            found += _within_session(candidates(one, number, session), number, session, rest)
        except (Unreachable, InfeasibleSlew) as why:
            refusal = refusal or why
            left_out.append(LeftOut(name=one.name, reason=why.detail))
    if not found and refusal is not None:
        raise refusal
    return found, tuple(left_out)


def _within_session(
    options: list[Candidate], number: int, session: ImagingSession, rest: Attitudes
) -> list[Candidate]:
    starts_s = np.array([option.start_s for option in options])
    stops_s = np.array([option.stop_s for option in options])
    attitude, motion = rest.at(np.append(np.maximum(starts_s - 20.0, 0.0), stops_s))
    ends = MovingEnds(attitude.as_quat(), attitude.apply(motion.omega_body_rad_s))
    count = len(options)
    entries = joined([option.entry for option in options])
    exits = joined([option.exit for option in options])
    there_s = session.turn_time.ticks(ends[:count], entries) * TICK_S
    back_s = session.turn_time.ticks(exits, ends[count:]) * TICK_S
    fits = (there_s <= starts_s) & (stops_s + back_s <= session.duration_s)
    kept = [option for option, fit in zip(options, fits, strict=True) if fit]
    if not kept:
        first = options[0]
        raise InfeasibleSlew(
            f"the turn onto requests.{number} and back to orbital orientation needs about "
            f"{there_s[0]:.1f} s before its start and {back_s[0]:.1f} s after its end, more than "
            f"the session leaves (it could be imaged {first.start_s:.1f} to {first.stop_s:.1f} s "
            "after the start); start earlier or stop later by as much",
            field=f"requests.{number}",
            limit="time",
        )
    return kept


def choose_and_turn(
    request: ImagingPlanRequest, session: ImagingSession, options: list[Candidate]
) -> tuple[Choice, Timeline, tuple[str, ...]]:
    """Choose and fly, with warnings.  Where all that can be seen fits, the turns share the time
    left over: a slower turn shakes the structure less."""
    first = _choice(request, session, options, {}, set())
    warnings: tuple[str, ...] = ()
    if set(first.requests) == {option.request for option in options}:
        with at_most(GENTLER_SHARE * effort.remaining()) as search:
            gentler = _gentler(request, session, first)
            if gentler is not None:
                return (*gentler, ())
        if search.is_spent:
            warnings = ("gentler turns weren't looked for to the end: it takes too much work",)
    return (*_flown(request, session, options, first, ROUNDS), warnings)


def _gentler(
    request: ImagingPlanRequest, session: ImagingSession, first: Choice
) -> tuple[Choice, Timeline] | None:
    """Everything imaged with the gentlest turns tried, or None."""
    for ease_s in EASES_S:
        eased = replace(session, turn_time=session.turn_time.eased(ease_s))
        try:
            found = _flown_eased(request, eased, first)
        except InfeasibleSlew:  # the turns are as short as they can be already
            return None
        if found is not None:
            return found
    return None


def _flown_eased(
    request: ImagingPlanRequest, eased: ImagingSession, first: Choice
) -> tuple[Choice, Timeline] | None:
    """Everything imaged with the longer turns, or None.  What the choice is measured by stays."""
    try:
        options, _ = options_of(request, eased)
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
