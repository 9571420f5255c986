"""Chooses what is imaged and slews between: a choice holds once every slew in it fits."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from planner.base import effort
from planner.base.commands import COMMAND_STEP_S
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew, Refusal, SearchEnded, Unreachable
from planner.base.rotation import Rotation
from planner.planning.label_search import COMPLETES, OPENS
from planner.spacecraft.imaging.candidates import Candidate, candidates
from planner.spacecraft.imaging.choose import Choice, choose
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.imaging.timeline import DoesNotFit, Timeline, build_timeline
from planner.spacecraft.requests import LeftOut


@dataclass(frozen=True, kw_only=True)
class SlewRevisionOptions:
    """How slews share the time that is left, and how a choice is revised where one isn't found."""

    more_s: tuple[float, float, float] = (4.0, 2.0, 0.8)  # for every slew, tried in this order
    tries: int = 3  # of a request, before others are imaged in its place
    request: float = 1_000.0  # of `effort`, for each request
    gentler_share: float = 0.4  # of what work is left, for gentler slews
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
    """Candidates by their start that can be turned to from the session's and back before its end.

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
    return sorted(options, key=lambda one: one.arcs[0].first_row), tuple(left_out)


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
    there_s = session.slews.ticks(idle[:count], entries) * COMMAND_STEP_S
    initial_xyzw = session.request.initial_q_body_from_eci_xyzw
    if initial_xyzw is not None:
        at_rest = Rotation.from_quat([initial_xyzw] * count).inv()
        initial = session.slews.states(lambda _: at_rest)
        there_s += session.slews.ticks(initial, idle[:count]) * COMMAND_STEP_S
    back_s = session.slews.ticks(exits, idle[count:]) * COMMAND_STEP_S - session.slews.settle_s
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
    needed_s = COMMAND_STEP_S * np.array(
        [session.slews.ticks(exits, np.array([one.entry_state] * len(firsts))) for one in seconds]
    )
    i, k = np.unravel_index(np.argmax(between_s - needed_s), needed_s.shape)
    if needed_s[i, k] > between_s[i, k] + 0.5 * COMMAND_STEP_S:
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
    """The choice and its timeline.  Where all that can be seen fits and it is to be refined, smooth
    slews share the time left over, as a slower slew shakes the structure less.

    Raises InfeasibleSlew where nothing fits.
    """
    first, found = choose(options, session.priorities, session.slews), None
    is_all = first.requests == {option.request for option in options}
    if refine and is_all and session.request.objective == "smooth":
        with at_most(OPTIONS.gentler_share * effort.remaining()):
            found = _gentler(session, first)
    return found or _fitting(session, options, first)


def _gentler(session: ImagingSession, first: Choice) -> Chosen | None:
    """Everything imaged with the gentlest slews tried, or None.

    What the choice is measured by stays.
    """
    for more_s in OPTIONS.more_s:
        longer = replace(session, slews=replace(session.slews, more_s=more_s))
        with suppress(Unreachable, InfeasibleSlew, SearchEnded, DoesNotFit):
            options, _ = options_of(longer)
            choice = choose(options, longer.priorities, longer.slews)
            if choice.value >= first.value:
                timeline = build_timeline(longer, choice.chosen)
                choice = replace(choice, greedy_value=first.greedy_value)
                return Chosen(choice=choice, timeline=timeline, left_out=())
    return None


def _fitting(session: ImagingSession, options: Sequence[Candidate], first: Choice) -> Chosen:
    """The choice with its slews; where one isn't found, another choice without the scan at fault,
    after some tries without its request."""
    choice, seen = first, {option.request for option in options}
    refused: dict[int, list[str]] = {}  # requests, and why
    why: Refusal = InfeasibleSlew("the slews between its scans don't fit", limit="time")
    while choice.chosen:
        try:
            timeline = build_timeline(session, choice.chosen)
        except DoesNotFit as misfit:
            at_fault, why = misfit.candidate, misfit.why
        else:
            beside = ["no time beside requests worth more, in the best choice found"]
            return Chosen(
                choice=replace(choice, greedy_value=min(first.greedy_value, choice.value)),
                timeline=timeline,
                left_out=tuple(
                    LeftOut(
                        name=session.request.requests[number].name,
                        reason=refused.get(number, beside)[-1],
                    )
                    for number in sorted(seen - choice.requests)
                ),
            )
        refused.setdefault(at_fault.request, []).append(why.detail)
        is_over = len(refused[at_fault.request]) >= OPTIONS.tries
        options = [
            one
            for one in options
            if one is not at_fault and not (is_over and one.request == at_fault.request)
        ]
        choice = choose(options, session.priorities, session.slews)
    raise InfeasibleSlew(why.detail, field="requests", limit=why.limit)
