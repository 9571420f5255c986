"""Chooses what is imaged and slews between: a choice holds once every slew in it fits."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from planner.base import effort
from planner.base.effort import WorkLimitReached, at_most
from planner.base.errors import InfeasibleSlew, Refusal, Unreachable
from planner.base.rotation import Rotation
from planner.planning.label_search import COMPLETES, OPENS
from planner.planning.sessions.platforms.mover import Join
from planner.spacecraft.imaging.candidates import Candidate, candidates
from planner.spacecraft.imaging.choose import Choice, choose
from planner.spacecraft.imaging.session import ImagingSession
from planner.spacecraft.imaging.slew_time import MovingEnds
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
from planner.spacecraft.requests import LeftOut
from planner.spacecraft.table import TICK_S


@dataclass(frozen=True, kw_only=True)
class SlewRevisionOptions:
    """How a choice is revised whose slews need more time than estimated."""

    # tried in this order, added to every slew
    longer_by_s: tuple[float, float, float] = (3.0, 1.5, 0.6)
    longer_rounds: int = 2  # of choices revised at each: it is a try
    rounds: int = 12  # choices revised when a slew needs more time than estimated
    longer_times: int = 3  # that the slews within a request are given more time
    longer_more_s: float = 0.4  # than is missing,
    hopeless_s: float = 30.0  # unless so much is
    one_more_rounds: int = 4  # choices revised for one request beside those kept
    request: float = 1_000.0  # of `effort`, for each request
    # tried in this order, off every slew: the second is less than almost any slew takes
    shorter_by_s: tuple[float, float] = (1.2, 2.0)
    gentler_share: float = 0.4  # of what work is left, for gentler slews,
    together_share: float = 0.7  # then for all requests at once,
    one_share: float = 0.5  # for each one after another,
    denser_share: float = 0.4  # and for a choice worth more,
    denser: float = 1_000_000.0  # of `effort`: 10 s, however many are asked for


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
            options += _options_of_one(number, session)
        except (Unreachable, InfeasibleSlew) as why:
            refusal = refusal or why
            left_out.append(LeftOut(name=request.name, reason=why.detail))
    if not options and refusal is not None:
        raise refusal
    return options, tuple(left_out)


def _options_of_one(number: int, session: ImagingSession) -> list[Candidate]:
    effort.charge(OPTIONS.request)
    found = candidates(session.request.requests[number], number, session)
    return _within_session(found, number, session)


def _within_session(
    options: list[Candidate], number: int, session: ImagingSession
) -> list[Candidate]:
    count = len(options)
    starts_s = np.array([option.start_s for option in options])
    stops_s = np.array([option.stop_s for option in options])
    leaving_s = np.maximum(starts_s - TIMELINE_OPTIONS.rest_before_s, 0.0)
    ends = session.ends(None, 0.0, np.append(leaving_s, stops_s))
    entries = MovingEnds.concatenate([option.entry for option in options])
    exits = MovingEnds.concatenate([option.exit for option in options])
    there_s = session.slew_time.ticks(ends[:count], entries) * TICK_S
    initial_xyzw = session.request.initial_q_body_from_eci_xyzw
    if initial_xyzw is not None:
        at_rest = Rotation.from_quat([initial_xyzw])
        initial = MovingEnds.between(at_rest, at_rest)
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


def choose_and_slew(
    session: ImagingSession, options: list[Candidate], *, gentler: bool
) -> Chosen | None:
    """The choice and its timeline.  Where all that can be seen fits, smooth slews share the time
    left over (if gentler): a slower slew shakes the structure less.

    None where the work that may be done is done before anything fits.
    Raises InfeasibleSlew where nothing does.
    """
    search = _Search(session, options)
    first = search.choice()
    warnings: tuple[str, ...] = ()
    gentler = gentler and session.request.objective == "smooth"
    if gentler and set(first.requests) == {option.request for option in options}:
        with at_most(OPTIONS.gentler_share * effort.remaining()) as work:
            found = _gentler_choice(session, first)
            if found is not None:
                return found
        if work.is_exhausted:
            warnings = ("gentler slews weren't looked for to the end: it takes too much work",)
    found = None
    with at_most(OPTIONS.together_share * effort.remaining()) as work:
        found = search.fitting(OPTIONS.rounds, choice=first)
    if found is not None:
        return replace(_denser_choice(session, search, found), warnings=warnings)
    found = search.one_by_one()
    if found is not None:
        alone = "requests were kept as they fitted, one after another: more may fit"
        return replace(found, warnings=(*warnings, alone))
    if work.is_exhausted or search.why_not is None:
        return None
    raise InfeasibleSlew(search.why_not.detail, field="requests", limit=search.why_not.limit)


def _gentler_choice(session: ImagingSession, first: Choice) -> Chosen | None:
    """Everything imaged with the gentlest slews tried, or None.

    What the choice is measured by stays.
    """
    for more_s in OPTIONS.longer_by_s:
        longer = replace(session, slew_time=session.slew_time.plus(more_s))
        try:
            options, _ = options_of(longer)
        except (Unreachable, InfeasibleSlew):
            continue
        search = _Search(longer, options)
        choice = search.choice()
        if choice.value < first.value:
            continue
        found = search.fitting(OPTIONS.longer_rounds, choice=choice)
        if found is None:  # the slews are as short as they can be already
            return None
        if found.choice.value >= first.value:
            return replace(found, choice=replace(found.choice, greedy_value=first.greedy_value))
    return None


def _denser_choice(session: ImagingSession, search: "_Search", found: Chosen) -> Chosen:
    """The same, or one worth more whose slews were found though estimated to take longer."""
    denser = _Search(session, search.options)
    denser.outcomes, denser.barred = search.outcomes, dict(search.barred)
    greedy_value = found.choice.greedy_value
    for less_s in OPTIONS.shorter_by_s:
        if set(found.choice.requests) == {option.request for option in denser.options}:
            break
        denser.session = replace(session, slew_time=session.slew_time.plus(-less_s))
        with at_most(min(OPTIONS.denser_share * effort.remaining(), OPTIONS.denser)):
            better = denser.fitting(OPTIONS.rounds)
            if better is not None and better.choice.value > found.choice.value:
                choice = replace(better.choice, greedy_value=greedy_value)
                found = replace(better, choice=choice)
    return found


class _Search:
    """Choices, and what the slews tried have shown of the candidates, by their place in `options`.

    extra_ticks: pairs that must stand so far apart.  barred: those that can't be turned to, and
    why not.  longer: how often the slews within a request were given more time, and how much.
    untried: requests for which no work was left.
    """

    def __init__(self, session: ImagingSession, options: Sequence[Candidate]) -> None:
        self.session = session
        self.options = list(options)
        self.outcomes = Outcomes()
        self.extra_ticks: dict[tuple[int, int], int] = {}
        self.barred: dict[int, str] = {}
        self.longer: dict[int, tuple[int, float]] = {}
        self.why_not: InfeasibleSlew | None = None
        self.tried: Choice | None = None
        self.untried: set[int] = set()

    def choice(self, among: Collection[int] | None = None) -> Choice:
        """The best choice among some requests (None: all) that allows for what is known."""
        allowed = [
            k
            for k, option in enumerate(self.options)
            if k not in self.barred and (among is None or option.request in among)
        ]
        place = {k: position for position, k in enumerate(allowed)}
        if not allowed:
            return Choice(chosen=(), requests=(), value=0.0, greedy_value=0.0, rounds=0)
        choice = choose(
            [self.options[k] for k in allowed],
            [request.priority for request in self.session.request.requests],
            self.session.slew_time,
            {
                (place[a], place[b]): ticks
                for (a, b), ticks in self.extra_ticks.items()
                if a in place and b in place
            },
        )
        return replace(choice, chosen=tuple(allowed[k] for k in choice.chosen))

    def fitting(
        self,
        rounds: int,
        among: Collection[int] | None = None,
        choice: Choice | None = None,
    ) -> Chosen | None:
        """The choice with its slews; where a slew doesn't fit, another choice that allows for it.

        None when no slews fit in so many rounds.
        """
        for _ in range(rounds):
            choice = choice or self.choice(among)
            if not choice.chosen:
                return None
            self.tried = choice
            scans = scans_of(self.options, choice.chosen)
            try:
                timeline = build_timeline(self.session, scans, self.outcomes)
            except SlewsDoNotFit as why:
                self.why_not = why.misfits[0].why
                self._learn_pairs(why.misfits)
                choice = None
            else:
                return Chosen(choice=choice, timeline=timeline, left_out=self._left_out(choice))
        return None

    def one_by_one(self) -> Chosen | None:
        """What was slewed to in the choice tried last; then requests by falling priority, each kept
        if it fits beside those kept before, with half of the work that is left."""
        asked = self.session.request.requests
        order = sorted({one.request for one in self.options}, key=lambda k: -asked[k].priority)
        kept: Chosen | None = None
        begun = self._slewed_to()
        self.untried = {*order}
        with suppress(WorkLimitReached):
            if begun.chosen:
                with at_most(OPTIONS.one_share * effort.remaining()):
                    kept = self.fitting(OPTIONS.one_more_rounds, {*begun.requests}, begun)
            for number in order:
                before = set(kept.choice.requests) if kept else set()
                if number in before:
                    continue
                with at_most(OPTIONS.one_share * effort.remaining()):
                    found = self.fitting(OPTIONS.one_more_rounds, before | {number})
                    self.untried.discard(number)
                    if found and (kept is None or found.choice.value > kept.choice.value):
                        kept = found
        return kept and replace(kept, left_out=self._left_out(kept.choice))

    def _slewed_to(self) -> Choice:
        """The part of the choice tried last whose scans have slews onto them."""
        tried = self.tried or self.choice(())
        scans = scans_of(self.options, tried.chosen)
        missing = {
            scan.request
            for before, scan in zip((None, *scans), scans, strict=False)
            if not isinstance(self.outcomes.slews.get((before, scan)), Join)
        }
        chosen = tuple(k for k in tried.chosen if self.options[k].request not in missing)
        requests = tuple(self.options[k].request for k in chosen)
        asked = self.session.request.requests
        value = sum(asked[number].priority for number in set(requests))
        return replace(tried, chosen=chosen, requests=requests, value=value)

    def _learn_pairs(self, misfits: Sequence[Misfit]) -> None:
        """Keep pairs further apart, give the slews within a request more time, and bar candidates
        too near the session's ends."""
        within: dict[int, Misfit] = {}
        for misfit in misfits:
            before, after = misfit.before, misfit.after
            if misfit.is_unheld:
                assert after is not None  # which can't be scanned
                self.barred.setdefault(after, misfit.why.detail)
            elif before is not None and before == after:
                number = self.options[before].request
                if number not in within or misfit.missing_s > within[number].missing_s:
                    within[number] = misfit
            elif before is None or after is None:
                self._bar_near_end(misfit)
            else:
                pair = (before, after)
                self.extra_ticks[pair] = max(misfit.ticks, self.extra_ticks.get(pair, 0))
        for number, misfit in within.items():
            self._make_longer(number, misfit)

    def _bar_near_end(self, misfit: Misfit) -> None:
        """Those of the same look that have no more time, or less than half of the time missing."""
        more_s = 0.5 * misfit.missing_s
        culprit = self.options[next(k for k in (misfit.after, misfit.before) if k is not None)]
        for k, option in enumerate(self.options):
            if (option.request, option.part) == (culprit.request, culprit.part) and (
                option.start_s <= culprit.start_s + more_s
                if misfit.before is None
                else option.stop_s >= culprit.stop_s - more_s
            ):
                self.barred.setdefault(k, misfit.why.detail)

    def _make_longer(self, number: int, misfit: Misfit) -> None:
        """Other candidates of a request, whose own slews have more time."""
        own = [k for k, option in enumerate(self.options) if option.request == number]
        times, longer_s = self.longer.get(number, (0, 0.0))
        longer_s += misfit.missing_s + OPTIONS.longer_more_s
        self.longer[number] = (times + 1, longer_s)
        reason = misfit.why.detail
        if times < OPTIONS.longer_times and misfit.missing_s <= OPTIONS.hopeless_s:
            longer = replace(self.session, slew_time=self.session.slew_time.plus(longer_s))
            try:
                self.options += _options_of_one(number, longer)
            except (Unreachable, InfeasibleSlew) as refusal:
                reason = refusal.detail
        self.barred |= {k: self.barred.get(k, reason) for k in own}

    def _left_out(self, choice: Choice) -> tuple[LeftOut, ...]:
        """Requests with candidates that aren't chosen: none of a look can be turned to, no work was
        left to try it, or others are worth more."""
        looks: dict[tuple[int, int], list[int]] = {}
        for k, option in enumerate(self.options):
            looks.setdefault((option.request, option.part), []).append(k)
        barred = {
            number: self.barred[looked[-1]]
            for (number, _), looked in looks.items()
            if all(k in self.barred for k in looked)
        }
        reasons = dict.fromkeys(
            self.untried,
            "fitting it in takes more work than may be done for one session; ask for it by itself",
        )
        beside = "no time beside requests worth more, in the best choice found"
        asked = self.session.request.requests
        return tuple(
            LeftOut(name=asked[number].name, reason=(reasons | barred).get(number, beside))
            for number in sorted({option.request for option in self.options} - {*choice.requests})
        )
