"""Chooses what is imaged and turns between: a choice holds once every turn in it fits."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planner import effort
from planner.effort import at_most
from planner.errors import InfeasibleSlew, Refusal, Unreachable
from planner.spacecraft.imaging.candidates import Candidate, candidates
from planner.spacecraft.imaging.choose import Choice, choose
from planner.spacecraft.imaging.ground_arc import ChebyshevProfile
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.imaging.timeline import (
    PROFILE_MARGIN_S,
    Misfit,
    Outcomes,
    Timeline,
    TurnsDoNotFit,
    build_timeline,
    scans_of,
)
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turns.turn_time import MovingEnds

LONGER_BY_S = (3.0, 1.5, 0.6)  # tried in this order, added to every turn
LONGER_ROUNDS = 2
ROUNDS = 12  # choices revised when a turn needs more time than estimated
HOPELESS_S = 10.0  # missing: no other moment to image the same will do
REST_BEFORE_S = 20.0  # a turn onto a scan leaves orbital orientation about so long before
REQUEST = 1_000.0  # of `planner.effort`
GENTLER_SHARE = 0.6  # of what work is left, for gentler turns


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A request that isn't imaged, and why.

    name: the request's. E.g. `"strip"`.
    reason: what is in its way. E.g. `"others are worth more"`.
    """

    name: str
    reason: str


def options_of(session: ImagingSession) -> tuple[list[Candidate], tuple[LeftOut, ...]]:
    """Candidates that can be turned to from the session's start and back before its end.

    Raises the first request's refusal when there is none of any.
    """
    options: list[Candidate] = []
    left_out: list[LeftOut] = []
    refusal: Refusal | None = None
    rest = session.profile(None, -PROFILE_MARGIN_S, session.duration_s + PROFILE_MARGIN_S)
    for number, request in enumerate(session.request.requests):
        effort.spend(REQUEST)
        try:
            found = candidates(request, number, session)
            options += _within_session(found, number, session, rest)
        except (Unreachable, InfeasibleSlew) as why:
            refusal = refusal or why
            left_out.append(LeftOut(name=request.name, reason=why.detail))
    if not options and refusal is not None:
        raise refusal
    return options, tuple(left_out)


def _within_session(
    options: list[Candidate], number: int, session: ImagingSession, rest: ChebyshevProfile
) -> list[Candidate]:
    count = len(options)
    starts_s = np.array([option.start_s for option in options])
    stops_s = np.array([option.stop_s for option in options])
    q_body_from_eci, motion = rest.attitude_at(
        np.append(np.maximum(starts_s - REST_BEFORE_S, 0.0), stops_s)
    )
    ends = MovingEnds(
        q_body_from_eci_xyzw=q_body_from_eci.as_quat(),
        rate_eci_rad_s=q_body_from_eci.inv().apply(motion.omega_body_rad_s),
    )
    entries = MovingEnds.concatenate([option.entry for option in options])
    exits = MovingEnds.concatenate([option.exit for option in options])
    there_s = session.turn_time.ticks(ends[:count], entries) * TICK_S
    back_s = session.turn_time.ticks(exits, ends[count:]) * TICK_S
    fits = (there_s <= starts_s) & (stops_s + back_s <= session.duration_s)
    parts = np.array([option.part for option in options])
    lacking = np.flatnonzero(~np.isin(parts, parts[fits]))  # half a pair is no image
    if lacking.size:
        k = int(lacking[0])
        raise InfeasibleSlew(
            f"the turn onto requests.{number} and back to orbital orientation needs about "
            f"{there_s[k]:.1f} s before its start and {back_s[k]:.1f} s after its end, more than "
            f"the session leaves (it could be imaged {starts_s[k]:.1f} to {stops_s[k]:.1f} s "
            "after the start); start earlier or stop later by as much",
            field=f"requests.{number}",
            limit="time",
        )
    return [option for option, fit in zip(options, fits, strict=True) if fit]


def choose_and_turn(
    session: ImagingSession, options: list[Candidate]
) -> tuple[Choice, Timeline, tuple[str, ...]]:
    """The choice and its timeline, with warnings.  Where all that can be seen fits, the turns
    share the time left over: a slower turn shakes the structure less."""
    first = _Revision().choice(session, options)
    warnings: tuple[str, ...] = ()
    if set(first.requests) == {option.request for option in options}:
        with at_most(GENTLER_SHARE * effort.remaining()) as search:
            gentler = _gentler(session, first)
            if gentler is not None:
                return (*gentler, ())
        if search.is_spent:
            warnings = ("gentler turns weren't looked for to the end: it takes too much work",)
    return (*_with_turns(session, options, first, ROUNDS), warnings)


def _gentler(session: ImagingSession, first: Choice) -> tuple[Choice, Timeline] | None:
    """Everything imaged with the gentlest turns tried, or None.

    What the choice is measured by stays.
    """
    for more_s in LONGER_BY_S:
        longer = replace(session, turn_time=session.turn_time.plus(more_s))
        try:
            options, _ = options_of(longer)
        except (Unreachable, InfeasibleSlew):
            continue
        choice = _Revision().choice(longer, options)
        if choice.value < first.value:
            continue
        try:
            choice, timeline = _with_turns(longer, options, choice, LONGER_ROUNDS)
        except InfeasibleSlew:  # the turns are as short as they can be already
            return None
        if choice.value >= first.value:
            return replace(choice, bound=first.bound, greedy_value=first.greedy_value), timeline
    return None


def _with_turns(
    session: ImagingSession, options: list[Candidate], choice: Choice, rounds: int
) -> tuple[Choice, Timeline]:
    """The choice with its turns; where a turn doesn't fit, another choice that allows for it.

    Raises InfeasibleSlew when no turns fit in so many rounds.
    """
    revision = _Revision()
    outcomes: Outcomes = {}
    misfits: tuple[Misfit, ...] = ()
    for revised in range(rounds):
        if len(revision.barred) == len(options):
            break
        if revised:
            choice = revision.choice(session, options)
        try:
            return choice, build_timeline(session, scans_of(options, choice.chosen), outcomes)
        except TurnsDoNotFit as why:
            misfits = why.misfits
            revision.learn(misfits, options)
    why_not = misfits[0].why
    raise InfeasibleSlew(why_not.detail, field="requests", limit=why_not.limit)


@dataclass(eq=False)
class _Revision:
    """What the turns tried have shown of the candidates, by their numbers among all options.

    extra_ticks: pairs that must stand so far apart.  barred: those that can't be turned to.
    """

    extra_ticks: dict[tuple[int, int], int] = field(default_factory=dict)
    barred: set[int] = field(default_factory=set)

    def choice(self, session: ImagingSession, options: list[Candidate]) -> Choice:
        """The best choice that allows for it."""
        allowed = [k for k in range(len(options)) if k not in self.barred]
        place = {k: position for position, k in enumerate(allowed)}
        choice = choose(
            [options[k] for k in allowed],
            [request.priority for request in session.request.requests],
            session.turn_time,
            {
                (place[a], place[b]): ticks
                for (a, b), ticks in self.extra_ticks.items()
                if a in place and b in place
            },
        )
        return replace(choice, chosen=tuple(allowed[k] for k in choice.chosen))

    def learn(self, misfits: Sequence[Misfit], options: Sequence[Candidate]) -> None:
        """Keep pairs further apart; bar candidates that don't fit with themselves or the ends,
        and where far too much time is missing, all of their request."""
        for misfit in misfits:
            if misfit.before is None or misfit.after is None or misfit.before == misfit.after:
                culprit = next(k for k in (misfit.after, misfit.before) if k is not None)
                self.barred.add(culprit)
                if misfit.why.missing_s > HOPELESS_S:
                    request = options[culprit].request
                    self.barred |= {k for k, o in enumerate(options) if o.request == request}
            else:
                pair = (misfit.before, misfit.after)
                self.extra_ticks[pair] = max(misfit.ticks, self.extra_ticks.get(pair, 0))
