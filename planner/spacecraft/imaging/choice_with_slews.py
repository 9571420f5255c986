"""Chooses what is imaged and slews between: a choice holds once every slew in it fits."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planner.base import effort
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew, Refusal, Unreachable
from planner.base.rotation import Rotation
from planner.planning.label_search import COMPLETES, OPENS
from planner.spacecraft.imaging.candidates import Candidate, candidates
from planner.spacecraft.imaging.choose import Choice, choose
from planner.spacecraft.imaging.ground_arc import ChebyshevProfile
from planner.spacecraft.imaging.left_out import LeftOut
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.imaging.timeline import (
    OPTIONS as TIMELINE_OPTIONS,
)
from planner.spacecraft.imaging.timeline import (
    Misfit,
    Outcomes,
    SlewsDoNotFit,
    Timeline,
    build_timeline,
    scans_of,
)
from planner.spacecraft.slews.slew_problem import EndState
from planner.spacecraft.slews.slew_time import MovingEnds
from planner.spacecraft.table import TICK_S


@dataclass(frozen=True, kw_only=True)
class SlewRevisionOptions:
    """How a choice is revised whose slews need more time than estimated."""

    # tried in this order, added to every slew
    longer_by_s: tuple[float, float, float] = (3.0, 1.5, 0.6)
    longer_rounds: int = 2  # of choices revised at each: it is a try
    rounds: int = 12  # choices revised when a slew needs more time than estimated
    hopeless_s: float = 10.0  # missing: no other moment to image the same will do
    request: float = 1_000.0  # of `effort`, for each request
    gentler_share: float = 0.6  # of what work is left, for gentler slews


OPTIONS = SlewRevisionOptions()


class LooksTooClose(InfeasibleSlew):
    """The looks of a stereo pair leave no time for the slew between; gap_s: how far apart they had
    to begin if the slew were no longer for it."""

    def __init__(self, number: int, gap_s: float, scan_s: float, slew_s: float) -> None:
        self.gap_s = scan_s + slew_s
        super().__init__(
            f"the looks of requests.{number} begin {gap_s:.1f} s apart; a scan takes "
            f"{scan_s:.1f} s and the slew between about {slew_s:.1f} s: ask for a larger gap_s "
            "or look_angle_deg, a faster scan or a shorter line",
            field=f"requests.{number}",
            limit="time",
        )


def options_of(session: ImagingSession) -> tuple[list[Candidate], tuple[LeftOut, ...]]:
    """Candidates that can be turned to from the session's start and back before its end.

    Raises the first request's refusal when there is none of any.
    """
    options: list[Candidate] = []
    left_out: list[LeftOut] = []
    refusal: Refusal | None = None
    rest = session.profile(
        None,
        -TIMELINE_OPTIONS.profile_margin_s,
        session.duration_s + TIMELINE_OPTIONS.profile_margin_s,
    )
    for number, request in enumerate(session.request.requests):
        effort.charge(OPTIONS.request)
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
        np.append(np.maximum(starts_s - TIMELINE_OPTIONS.rest_before_s, 0.0), stops_s)
    )
    ends = MovingEnds(
        q_body_from_eci_xyzw=q_body_from_eci.as_quat(),
        rate_eci_rad_s=q_body_from_eci.inv().apply(motion.omega_body_rad_s),
    )
    entries = MovingEnds.concatenate([option.entry for option in options])
    exits = MovingEnds.concatenate([option.exit for option in options])
    there_s = session.slew_time.ticks(ends[:count], entries) * TICK_S
    initial_xyzw = session.request.initial_q_body_from_eci_xyzw
    if initial_xyzw is not None:
        initial = MovingEnds.of(EndState.at_rest(Rotation.from_quat(initial_xyzw)))
        there_s += session.slew_time.ticks(initial, ends[:count]) * TICK_S
    back_s = session.slew_time.ticks(exits, ends[count:]) * TICK_S
    fits = (there_s <= starts_s) & (stops_s + back_s <= session.duration_s)
    parts = np.array([option.part for option in options])
    lacking = np.flatnonzero(~np.isin(parts, parts[fits]))  # half a pair is no image
    if lacking.size:
        k = int(lacking[0])
        raise InfeasibleSlew(
            f"turning onto requests.{number} and back to orbital orientation needs about "
            f"{there_s[k]:.1f} s before its start and {back_s[k]:.1f} s after its end, more than "
            f"the session leaves (it could be imaged {starts_s[k]:.1f} to {stops_s[k]:.1f} s "
            "after the start); start earlier or stop later by as much",
            field=f"requests.{number}",
            limit="time",
        )
    kept = [option for option, fit in zip(options, fits, strict=True) if fit]
    _refuse_looks_too_close(kept, number, session)
    return kept


def _refuse_looks_too_close(options: list[Candidate], number: int, session: ImagingSession) -> None:
    """A stereo pair none of whose second looks can be turned to from a first one."""
    firsts = [option for option in options if option.part == OPENS]
    seconds = [option for option in options if option.part == COMPLETES]
    if not firsts:
        return
    exits = MovingEnds.concatenate([first.exit for first in firsts])
    between_s = np.array([second.start_s for second in seconds])[:, None] - [
        first.stop_s for first in firsts
    ]
    needed_s = TICK_S * np.array([session.slew_time.ticks(exits, one.entry) for one in seconds])
    i, k = np.unravel_index(np.argmax(between_s - needed_s), needed_s.shape)
    if needed_s[i, k] > between_s[i, k] + 0.5 * TICK_S:
        gap_s = seconds[i].start_s - firsts[k].start_s
        raise LooksTooClose(number, gap_s, gap_s - between_s[i, k], needed_s[i, k])


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """What is imaged, with its slews, and why the rest of what could be seen is not."""

    choice: Choice
    timeline: Timeline
    left_out: tuple[LeftOut, ...]
    warnings: tuple[str, ...] = ()


def choose_and_slew(session: ImagingSession, options: list[Candidate], *, gentler: bool) -> Chosen:
    """The choice and its timeline.  Where all that can be seen fits, the slews share the time left
    over (if gentler): a slower slew shakes the structure less."""
    first = _Revision().choice(session, options)
    warnings: tuple[str, ...] = ()
    if gentler and set(first.requests) == {option.request for option in options}:
        with at_most(OPTIONS.gentler_share * effort.remaining()) as search:
            found = _gentler(session, first)
            if found is not None:
                return found
        if search.is_exhausted:
            warnings = ("gentler slews weren't looked for to the end: it takes too much work",)
    return replace(_with_slews(session, options, first, OPTIONS.rounds), warnings=warnings)


def _gentler(session: ImagingSession, first: Choice) -> Chosen | None:
    """Everything imaged with the gentlest slews tried, or None.

    What the choice is measured by stays.
    """
    for more_s in OPTIONS.longer_by_s:
        longer = replace(session, slew_time=session.slew_time.plus(more_s))
        try:
            options, _ = options_of(longer)
        except (Unreachable, InfeasibleSlew):
            continue
        choice = _Revision().choice(longer, options)
        if choice.value < first.value:
            continue
        try:
            found = _with_slews(longer, options, choice, OPTIONS.longer_rounds)
        except InfeasibleSlew:  # the slews are as short as they can be already
            return None
        if found.choice.value >= first.value:
            choice = replace(found.choice, bound=first.bound, greedy_value=first.greedy_value)
            return replace(found, choice=choice)
    return None


def _with_slews(
    session: ImagingSession, options: list[Candidate], choice: Choice, rounds: int
) -> Chosen:
    """The choice with its slews; where a slew doesn't fit, another choice that allows for it.

    Raises InfeasibleSlew when no slews fit in so many rounds.
    """
    revision = _Revision()
    outcomes: Outcomes = {}
    misfits: tuple[Misfit, ...] = ()
    for revised in range(rounds):
        if revised:
            if len(revision.barred) == len(options):
                break
            choice = revision.choice(session, options)
            if not choice.chosen:  # of pairs, the first looks are left
                break
        try:
            timeline = build_timeline(session, scans_of(options, choice.chosen), outcomes)
        except SlewsDoNotFit as why:
            misfits = why.misfits
            revision.learn(misfits, options)
        else:
            left_out = _left_out(session, options, choice, revision)
            return Chosen(choice=choice, timeline=timeline, left_out=left_out)
    why_not = misfits[0].why
    raise InfeasibleSlew(why_not.detail, field="requests", limit=why_not.limit)


def _left_out(
    session: ImagingSession, options: list[Candidate], choice: Choice, revision: "_Revision"
) -> tuple[LeftOut, ...]:
    """Requests with candidates that aren't chosen: none of a look can be turned to, or others are
    worth more."""
    gap = "no better choice exists" if choice.proven_optimal else "the choice is not proven best"
    beside = f"no time beside requests worth more ({gap})"
    barred = revision.barred_requests(options)
    return tuple(
        LeftOut(name=session.request.requests[number].name, reason=barred.get(number, beside))
        for number in sorted({option.request for option in options} - set(choice.requests))
    )


@dataclass(eq=False)
class _Revision:
    """What the slews tried have shown of the candidates, by their numbers among all options.

    extra_ticks: pairs that must stand so far apart.  barred: those that can't be turned to, and
    why not.
    """

    extra_ticks: dict[tuple[int, int], int] = field(default_factory=dict)
    barred: dict[int, str] = field(default_factory=dict)

    def choice(self, session: ImagingSession, options: list[Candidate]) -> Choice:
        """The best choice that allows for it."""
        allowed = [k for k in range(len(options)) if k not in self.barred]
        place = {k: position for position, k in enumerate(allowed)}
        choice = choose(
            [options[k] for k in allowed],
            [request.priority for request in session.request.requests],
            session.slew_time,
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
                same = [culprit]
                if misfit.why.missing_s > OPTIONS.hopeless_s:
                    request = options[culprit].request
                    same = [k for k, option in enumerate(options) if option.request == request]
                self.barred |= dict.fromkeys(same, misfit.why.detail)
            else:
                pair = (misfit.before, misfit.after)
                self.extra_ticks[pair] = max(misfit.ticks, self.extra_ticks.get(pair, 0))

    def barred_requests(self, options: Sequence[Candidate]) -> dict[int, str]:
        """Those of which every candidate of a look is barred, and why the last one is."""
        looks: dict[tuple[int, int], list[int]] = {}
        for k, option in enumerate(options):
            looks.setdefault((option.request, option.part), []).append(k)
        return {
            request: self.barred[looked[-1]]
            for (request, _), looked in looks.items()
            if all(k in self.barred for k in looked)
        }
