"""Chooses what is imaged and slews between: a choice holds once every slew in it fits."""

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from planner.base import effort
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew, Refusal, SearchEnded, Unreachable
from planner.base.rotation import Rotation
from planner.planning.label_search import COMPLETES, OPENS
from planner.spacecraft.imaging.candidates import Candidate, candidates
from planner.spacecraft.imaging.choose import Choice, choose, choose_by_solving
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.imaging.timeline import DoesNotFit, Timeline, build_timeline, scans_of
from planner.spacecraft.requests import LeftOut
from planner.spacecraft.table import TICK_S


@dataclass(frozen=True, kw_only=True)
class SlewRevisionOptions:
    """How slews share the time that is left, and how a choice is revised where one isn't found."""

    more_s: tuple[float, float, float] = (4.0, 2.0, 0.8)  # for every slew, tried in this order
    tries: int = 3  # of a request, before others are imaged in its place
    request: float = 1_000.0  # of `effort`, for each request
    gentler_share: float = 0.4  # of what work is left, for gentler slews
    solving_share: float = 0.6  # of what work is left, for slews that may be found by solving them
    rest_before_s: float = 20.0  # a slew from and to the idle attitude takes about so long


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
    for number, request in enumerate(session.request.requests):
        try:
            effort.charge(OPTIONS.request)
            options += _within_session(candidates(request, number, session), number, session)
        except (Unreachable, InfeasibleSlew) as why:
            refusal = refusal or why
            left_out.append(LeftOut(name=request.name, reason=why.detail))
    if not options and refusal is not None:
        raise refusal
    return options, tuple(left_out)


def _within_session(
    options: list[Candidate], number: int, session: ImagingSession
) -> list[Candidate]:
    count = len(options)
    starts_s = np.array([option.start_s for option in options])
    stops_s = np.array([option.stop_s for option in options])
    leaving_s = np.maximum(starts_s - OPTIONS.rest_before_s, 0.0)
    back_by_s = np.minimum(stops_s + OPTIONS.rest_before_s, session.duration_s)
    idle = session.ends(None, np.append(leaving_s, back_by_s), 0.0)
    entries, exits = (
        np.array([getattr(option, end) for option in options])
        for end in ("entry_state", "exit_state")
    )
    there_s = session.slews.ticks(idle[:count], entries) * TICK_S
    initial_xyzw = session.request.initial_q_body_from_eci_xyzw
    if initial_xyzw is not None:
        at_rest = Rotation.from_quat([initial_xyzw] * count).inv()
        initial = session.slews.states(lambda _: at_rest)
        there_s += session.slews.ticks(initial, idle[:count]) * TICK_S
    back_s = session.slews.ticks(exits, idle[count:]) * TICK_S - session.slews.settle_s
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
    between_s = np.array([second.start_s for second in seconds])[:, None] - [
        first.stop_s for first in firsts
    ]
    exits = np.array([first.exit_state for first in firsts])
    needed_s = TICK_S * np.array(
        [session.slews.ticks(exits, np.array([one.entry_state] * len(firsts))) for one in seconds]
    )
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


def choose_and_slew(
    session: ImagingSession, options: Sequence[Candidate], *, refine: bool
) -> Chosen:
    """The choice and its timeline.  If it is to be refined, work that is left is spent: where all
    that can be seen fits, smooth slews share the time left over, as a slower slew shakes the
    structure less; else slews are solved that aren't known to suffice.

    Raises InfeasibleSlew where nothing fits.
    """
    first = _best(session, options)
    is_all = set(first.requests) == {option.request for option in options}
    if refine and is_all and session.request.objective == "smooth":
        found = None
        with at_most(OPTIONS.gentler_share * effort.remaining()):
            found = _gentler(session, first)
        if found is not None:
            return found
    fitting = _fitting(session, options, first)
    if refine and not is_all:
        with at_most(OPTIONS.solving_share * effort.remaining()):
            return _tighter(session, options, fitting.choice) or fitting
    return fitting


def _best(
    session: ImagingSession, options: Sequence[Candidate], barred: Collection[int] = ()
) -> Choice:
    """The best choice of candidates that aren't barred, by their place in `options`."""
    allowed = [k for k in range(len(options)) if k not in barred]
    if not allowed:
        return Choice()
    choice = choose([options[k] for k in allowed], session.priorities, session.slews)
    return replace(choice, chosen=tuple(allowed[k] for k in choice.chosen))


def _tighter(session: ImagingSession, options: Sequence[Candidate], first: Choice) -> Chosen | None:
    """A choice worth more whose slews are found by solving them, or None."""
    choice = choose_by_solving(options, session.priorities, session.slews, first)
    if choice is not first:
        with suppress(DoesNotFit):
            timeline = build_timeline(session, scans_of(options, choice.chosen))
            left_out = _left_out(session, options, choice, {})
            return Chosen(choice=choice, timeline=timeline, left_out=left_out)
    return None


def _gentler(session: ImagingSession, first: Choice) -> Chosen | None:
    """Everything imaged with the gentlest slews tried, or None.

    What the choice is measured by stays.
    """
    for more_s in OPTIONS.more_s:
        longer = replace(session, slews=replace(session.slews, more_s=more_s))
        with suppress(Unreachable, InfeasibleSlew, SearchEnded, DoesNotFit):
            options, _ = options_of(longer)
            choice = _best(longer, options)
            if choice.value >= first.value:
                timeline = build_timeline(longer, scans_of(options, choice.chosen))
                choice = replace(choice, greedy_value=first.greedy_value)
                return Chosen(choice=choice, timeline=timeline, left_out=())
    return None


def _fitting(session: ImagingSession, options: Sequence[Candidate], choice: Choice) -> Chosen:
    """The choice with its slews; where a slew isn't found, another choice without it."""
    barred: set[int] = set()
    refused: list[tuple[int, str]] = []  # requests, and why
    why: Refusal = InfeasibleSlew("the slews between its scans don't fit", limit="time")
    greedy_value = choice.greedy_value
    while choice.chosen:
        try:
            timeline = build_timeline(session, scans_of(options, choice.chosen))
        except DoesNotFit as misfit:
            at_fault, why = misfit.candidate, misfit.why
        else:
            choice = replace(choice, greedy_value=min(greedy_value, choice.value))
            left_out = _left_out(session, options, choice, dict(refused))
            return Chosen(choice=choice, timeline=timeline, left_out=left_out)
        number = options[at_fault].request
        refused.append((number, why.detail))
        barred.add(at_fault)
        if [one for one, _ in refused].count(number) >= OPTIONS.tries:
            barred |= {k for k, one in enumerate(options) if one.request == number}
        choice = _best(session, options, barred)
    raise InfeasibleSlew(why.detail, field="requests", limit=why.limit)


def _left_out(
    session: ImagingSession,
    options: Sequence[Candidate],
    choice: Choice,
    refused: Mapping[int, str],
) -> tuple[LeftOut, ...]:
    """Requests with candidates that aren't chosen: a slew of theirs isn't found, or others are
    worth more."""
    beside = "no time beside requests worth more, in the best choice found"
    asked = session.request.requests
    return tuple(
        LeftOut(name=asked[number].name, reason=refused.get(number, beside))
        for number in sorted({option.request for option in options} - {*choice.requests})
    )
