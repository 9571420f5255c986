"""The best choice found of requests to image, their times and order, its slews, and its bound.

A path through candidates in order of time, worth the priorities of the requests it fulfils, found
by `label_search` with slew times that suffice, and bounded by it with times that none can beat, as
in campaigns.  The two looks of a stereo pair are candidates of their own; only the second earns,
and only after the first.  A choice holds once every slew in it is found.
Source: Peng et al. 2020 (agile satellites).
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import compiled
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew, Refusal, SearchEnded, Unreachable
from planner.planning import label_search
from planner.planning.campaigns.platforms.slew_fits import NECESSARY, SUFFICIENT
from planner.planning.label_search import (
    COMPLETES,
    OPENS,
    WHOLE,
    LabelMemory,
    Repeats,
    Round,
    Visit,
    best,
    follow,
    no_labels,
    rounds,
    visit,
)
from planner.spacecraft.imaging.candidates import Candidate, candidates
from planner.spacecraft.imaging.session import ImagingSession, Slews
from planner.spacecraft.imaging.timeline import DoesNotFit, Timeline, build_timeline
from planner.spacecraft.requests import LeftOut


@dataclass(frozen=True, kw_only=True)
class ChoiceOptions:
    """What a choice and its bound may take, and how it is revised where a slew isn't found."""

    pair: float = 0.3  # of `effort`
    wait_ticks: int = 10  # of the chain of idle instants: 2 s, little beside a slew to them
    bound_labels_max: int = 2_000_000  # no round of the bound is begun after so many: 2 s
    bound_share: float = 0.3  # of what work is left: the rest is for flights
    more_s: tuple[float, float, float] = (4.0, 2.0, 0.8)  # for every slew, tried in this order
    tries: int = 3  # of a request, before others are imaged in its place
    request: float = 1_000.0  # of `effort`, for each request
    gentler_share: float = 0.4  # of what work is left, for gentler slews
    rest_before_s: float = 20.0  # a slew from and to the idle attitude takes about so long


OPTIONS = ChoiceOptions()


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
    slews, count = session.slews, len(options)
    starts_s, stops_s, parts = np.array([(one.start_s, one.stop_s, one.part) for one in options]).T
    leaving_s = np.maximum(starts_s - OPTIONS.rest_before_s, 0.0)
    back_by_s = np.minimum(stops_s + OPTIONS.rest_before_s, session.duration_s)
    idle = session.ends(None, np.append(leaving_s, back_by_s), 0.0)
    entries, exits = _end_states(options)
    there_s = slews.ticks(idle[:count], entries) * COMMAND_STEP_S
    if (initial := session.initial_state) is not None:
        there_s += slews.ticks(np.tile(initial, (count, 1)), idle[:count]) * COMMAND_STEP_S
    back_s = slews.ticks(exits, idle[count:]) * COMMAND_STEP_S - slews.settle_s
    fits = (there_s <= starts_s) & (stops_s + back_s <= session.duration_s)
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
    # Of a stereo pair some second look has to be in reach of a first one.
    second, first = map(
        np.ravel, np.meshgrid(*(np.flatnonzero(fits & (parts == p)) for p in (COMPLETES, OPENS)))
    )
    if first.size:
        needed_s = COMMAND_STEP_S * slews.ticks(exits[first], entries[second])
        between_s = starts_s[second] - stops_s[first]
        k = int(np.argmax(between_s - needed_s))
        if needed_s[k] > between_s[k] + 0.5 * COMMAND_STEP_S:
            gap_s = float(starts_s[second[k]] - starts_s[first[k]])
            raise LooksTooClose(number, gap_s, gap_s - between_s[k], needed_s[k])
    return [option for option, fit in zip(options, fits, strict=True) if fit]


def _end_states(options: Sequence[Candidate]) -> tuple[Array, Array]:
    """Entries and exits, (n, 11) each."""
    entries = np.array([option.entry_state for option in options])
    return entries, np.array([option.exit_state for option in options])


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Candidates in order of time, and how good the choice of them is.

    value: sum of priorities fulfilled.  greedy_value: of taking requests by priority, each at the
    first moment that fits.
    """

    chosen: tuple[Candidate, ...] = ()
    value: float = 0.0
    greedy_value: float = 0.0

    @property
    def requests(self) -> frozenset[int]:
        """Theirs."""
        return frozenset(one.request for one in self.chosen)


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """What is imaged, with its slews, and why the rest of what could be seen is not."""

    choice: Choice
    timeline: Timeline
    left_out: tuple[LeftOut, ...] = ()


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
            choice = choose(options_of(longer)[0], longer.priorities, longer.slews)
            if choice.value >= first.value:
                timeline = build_timeline(longer, choice.chosen)
                choice = replace(choice, greedy_value=first.greedy_value)
                return Chosen(choice=choice, timeline=timeline)
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
            break
        except DoesNotFit as misfit:
            at_fault, why = misfit.candidate, misfit.why
        refused.setdefault(at_fault.request, []).append(why.detail)
        is_over = len(refused[at_fault.request]) >= OPTIONS.tries
        options = [
            one
            for one in options
            if one is not at_fault and not (is_over and one.request == at_fault.request)
        ]
        choice = choose(options, session.priorities, session.slews)
    else:
        raise InfeasibleSlew(why.detail, field="requests", limit=why.limit)
    requests = session.request.requests
    beside = ["no time beside requests worth more, in the best choice found"]
    left_out = tuple(
        LeftOut(name=requests[number].name, reason=refused.get(number, beside)[-1])
        for number in sorted(seen - choice.requests)
    )
    choice = replace(choice, greedy_value=min(first.greedy_value, choice.value))
    return Chosen(choice=choice, timeline=timeline, left_out=left_out)


class Imaging(NamedTuple):
    """Candidates by their start, (n,) each, and which can follow which.

    priority: what imaging each adds to a choice's value, nothing for the first of a stereo pair.
    first (n + 1,): candidate j can directly follow before[first[j]] to before[first[j + 1]].
    reach_ticks: so long after a candidate's stop any other can be begun.
    """

    start_tick: Indices
    stop_tick: Indices
    request: Indices
    part: Indices
    priority: Array
    first: Indices
    before: Indices
    reach_ticks: int

    def with_first(self, placed: list[int], options: Iterable[int]) -> list[int] | None:
        """Those placed and the first of the options for whose slews they leave the time."""
        for k in options:
            near = [*[i for i in placed if i < k][-1:], k, *[j for j in placed if j > k][:1]]
            if all(
                self.start_tick[j] - self.stop_tick[i] >= self.reach_ticks
                or i in self.before[self.first[j] : self.first[j + 1]]
                for i, j in pairwise(near)
            ):
                return sorted([*placed, k])
        return None


def choose(options: Sequence[Candidate], priorities: Sequence[float], slews: Slews) -> Choice:
    """The best choice of candidates by their start for slew times that suffice, if labels last."""
    if not options:
        return Choice()
    imaging = _made_ready(options, priorities, slews, SUFFICIENT)
    greedy = most = _greedy(imaging, priorities)
    for one in _rounds(imaging):
        most = max(most, _without_repeats(imaging, one.visits[:, 0].tolist()), key=itemgetter(0))
        if one.value <= most[0]:
            break
    value, path = most
    chosen = tuple(options[k] for k in _less_tilted(options, imaging, path))
    return Choice(chosen=chosen, value=value, greedy_value=greedy[0])


def bound_of(
    options: Sequence[Candidate], priorities: Sequence[float], slews: Slews, value: float
) -> float:
    """No choice of these candidates is worth more, whatever its slews; value: of one of them."""
    least = float(sum(priorities[request] for request in {one.request for one in options}))
    if least > value and effort.remaining() > 0.0:
        with at_most(OPTIONS.bound_share * effort.remaining()):
            imaging = _made_ready(options, priorities, slews, NECESSARY)
            for one in _rounds(imaging, OPTIONS.bound_labels_max):
                least = min(least, label_search.bound([one]))
                if least <= value or effort.remaining() <= 0.0:
                    break
    return max(least, value)


def _made_ready(
    options: Sequence[Candidate], priorities: Sequence[float], slews: Slews, sign: float
) -> Imaging:
    """sign: of the slew times, as of `slew_fits`."""
    start_tick = np.array([c.arcs[0].first_row for c in options])
    stop_tick = np.array([c.arcs[-1].last_row for c in options])
    entries, exits = _end_states(options)
    before: list[Indices] = []
    for j, tick in enumerate(start_tick):
        ticks = tick - stop_tick
        # Beyond, it is followed by way of an idle instant.
        i = np.flatnonzero((ticks > 0) & (ticks < slews.widest_ticks + OPTIONS.wait_ticks))
        effort.charge(OPTIONS.pair * len(i))
        entry = np.repeat(entries[j : j + 1], len(i), axis=0)
        before.append(i[slews.fit(exits[i], entry, ticks[i], sign)])
    return Imaging(
        start_tick=start_tick,
        stop_tick=stop_tick,
        request=np.array([c.request for c in options]),
        part=np.array([c.part for c in options]),
        priority=np.array([0.0 if c.part == OPENS else priorities[c.request] for c in options]),
        first=np.cumsum([0, *map(len, before)]),
        before=np.concatenate(before),
        reach_ticks=slews.widest_ticks,
    )


def _rounds(
    imaging: Imaging, labels_max: int = label_search.OPTIONS.search_labels_max
) -> Iterator[Round]:
    longest_ticks = int(np.max(imaging.stop_tick - imaging.start_tick))
    leap_ticks = longest_ticks + imaging.reach_ticks + 2 * OPTIONS.wait_ticks
    stereo = np.unique(imaging.request[imaging.part != WHOLE]).tolist()
    ticks, things = imaging.start_tick, int(imaging.request.max()) + 1
    repeats = Repeats(things, imaging.request, ticks, ticks, leap_ticks, stereo)
    return rounds(
        lambda memory: Round(*_label_paths(imaging, memory, OPTIONS.wait_ticks)),
        repeats,
        labels_max,
    )


@compiled
def _label_paths(
    imaging: Imaging, memory: LabelMemory, wait_ticks: int
) -> tuple[float, Indices, int, bool]:
    """A `Round`.  Places: candidates, then idle instants; visits are numbered by candidate."""
    n = len(imaging.start_tick)
    end = int(imaging.stop_tick.max()) + imaging.reach_ticks + 2 * wait_ticks
    labels = no_labels(n + end // wait_ticks + 2, n, memory)
    now = 0
    for j in range(n):
        start_tick = imaging.start_tick[j]
        while (now + 1) * wait_ticks <= start_tick:
            now += 1
            mask = memory.tick_mask[now * wait_ticks]
            follow(labels, n + now - 1, (n + now,), mask, False)
        made = Visit(j, imaging.request[j], imaging.part[j], imaging.priority[j], start_tick)
        visit(labels, (n + now,), j, memory, made)
        visit(labels, imaging.before[imaging.first[j] : imaging.first[j + 1]], j, memory, made)
        free = (imaging.stop_tick[j] + imaging.reach_ticks + wait_ticks - 1) // wait_ticks
        follow(labels, j, (n + free,), memory.every, False)
    value, visits, count, is_complete = best(labels, (0, n))
    return max(value, 0.0), visits, count, is_complete


def _without_repeats(imaging: Imaging, path: list[int]) -> tuple[float, list[int]]:
    """The path with later repeats and halves of pairs left out.

    What remains stays flyable, the gaps only grow.
    """
    first: dict[tuple[int, int], int] = {}
    for k in path:
        first.setdefault((int(imaging.request[k]), int(imaging.part[k])), k)
    done = {request for request, part in first if part != OPENS}
    kept = [k for (request, _), k in first.items() if request in done]
    return float(sum(imaging.priority[k] for k in kept)), kept


def _greedy(imaging: Imaging, priorities: Sequence[float]) -> tuple[float, list[int]]:
    """Requests by falling priority, each at the first time that fits between those placed."""
    placed: list[int] = []
    for request in sorted(range(len(priorities)), key=lambda r: -priorities[r]):
        trial: list[int] | None = placed
        parts = np.unique(imaging.part[imaging.request == request])
        for part in parts:
            options = np.flatnonzero((imaging.request == request) & (imaging.part == part))
            trial = None if trial is None else imaging.with_first(trial, options.tolist())
        placed = trial if trial and OPENS not in parts[-1:] else placed  # half a pair is no image
    return _without_repeats(imaging, placed)


def _less_tilted(options: Sequence[Candidate], imaging: Imaging, path: list[int]) -> list[int]:
    """The same requests, each moved to where it is seen from nearest overhead among its free
    neighbours; stereo looks stay."""
    tilt_rad = np.array([one.tilt_rad for one in options])
    for k in list(path):
        if imaging.part[k] == WHOLE:
            same = np.flatnonzero(imaging.request == imaging.request[k])
            nearest = same[np.argsort(tilt_rad[same], kind="stable")].tolist()
            path = imaging.with_first([one for one in path if one != k], nearest) or path
    return path
