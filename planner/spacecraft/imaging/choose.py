"""The best choice found of requests to image, their times and order, and what bounds it.

A path through candidates in order of time, worth the priorities of the requests it fulfils, found
by `label_search` with slew times that suffice, and bounded by it with times that none can beat, as
in campaigns.  The two looks of a stereo pair are candidates of their own; only the second earns,
and only after the first.
Source: Peng et al. 2020 (agile satellites).
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.compiled import compiled
from planner.planning import label_search
from planner.planning.campaigns.platforms.slew_fits import NECESSARY, SUFFICIENT
from planner.planning.label_search import (
    COMPLETES,
    OPENS,
    ROUNDING,
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
from planner.spacecraft.imaging.candidates import Candidate
from planner.spacecraft.imaging.slews import Slews


@dataclass(frozen=True, kw_only=True)
class ChoiceOptions:
    """What a choice and its bound may take."""

    pair: float = 0.3  # of `effort`
    wait_ticks: int = 10  # of the chain of idle instants: 2 s, the grid of the candidates
    bound_labels_max: int = 2_000_000  # no round of the bound is begun after so many: 2 s
    # of some 60 slews that were solved nearly all that were found lacked at most 7.7 % of the time
    # that suffices
    stretch_factor: float = 1.08
    bound_share: float = 0.3  # of what work is left: the rest is for flights


OPTIONS = ChoiceOptions()


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Candidates in order of time, and how good the choice of them is.

    chosen: indices into the candidates; requests: theirs.  value: sum of priorities
    fulfilled.  greedy_value: of taking requests by priority, each at the first moment that fits.
    """

    chosen: tuple[int, ...] = ()
    requests: tuple[int, ...] = ()
    value: float = 0.0
    greedy_value: float = 0.0


class Imaging(NamedTuple):
    """Candidates by their start, (n,) each; priority: what imaging each adds to a choice's value,
    nothing for the first of a stereo pair."""

    start_tick: Indices
    stop_tick: Indices
    request: Indices
    part: Indices
    priority: Array
    tilt_rad: Array


class SlewGraph(NamedTuple):
    """first (n + 1,): candidate j can directly follow before[first[j]] to before[first[j + 1]].

    reach_ticks: so long after a candidate's stop any other can be begun.
    """

    first: Indices
    before: Indices
    reach_ticks: int

    def follows(self, imaging: Imaging, i: int, j: int) -> bool:
        """Whether candidate j can follow candidate i."""
        is_late = imaging.start_tick[j] - imaging.stop_tick[i] >= self.reach_ticks
        return bool(is_late or i in self.before[self.first[j] : self.first[j + 1]])

    def without(self, imaging: Imaging, i: int, j: int) -> "SlewGraph":
        """Without the slew from candidate i to candidate j, nor any between the same two scans that
        leaves later and arrives sooner."""
        after = np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))
        scan = np.stack([imaging.request, imaging.part], axis=1)
        is_same = (scan[self.before] == scan[i]) & (scan[after] == scan[j])
        kept = ~(is_same.all(axis=1) & (self.before >= i) & (after <= j))
        return self._replace(
            first=np.append(0, np.cumsum(kept))[self.first], before=self.before[kept]
        )


def choose(candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews) -> Choice:
    """The best choice for slew times that suffice, if labels last."""
    order, imaging, graph = _made_ready(candidates, priorities, slews, SUFFICIENT)
    greedy = most = _greedy(imaging, graph, priorities)
    for one in _rounds(imaging, graph):
        most = max(most, _without_repeats(imaging, one.visits[:, 0].tolist()), key=itemgetter(0))
        if one.value <= most[0]:
            break
    return _choice_of(order, imaging, graph, *most, greedy[0])


def choose_by_solving(
    candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews, choice: Choice
) -> Choice:
    """A choice worth more than this one, where slews that aren't known to suffice but are found by
    solving them let others follow each other; the same where none is found by the work left."""
    order, imaging, known = _made_ready(candidates, priorities, slews, SUFFICIENT)
    hasty = replace(slews, stretch_factor=OPTIONS.stretch_factor)
    hoped = _made_ready(candidates, priorities, hasty, SUFFICIENT)[2]

    @cache
    def is_flown(i: int, j: int) -> bool:
        ticks = int(imaging.start_tick[j] - imaging.stop_tick[i])
        ends = candidates[order[i]].exit_state, candidates[order[j]].entry_state
        return known.follows(imaging, i, j) or slews.is_found(*ends, ticks)

    while effort.remaining() > 0.0:
        *_, last = _rounds(imaging, hoped, OPTIONS.bound_labels_max)
        found = _without_repeats(imaging, last.visits[:, 0].tolist())
        if found[0] <= choice.value * (1.0 + ROUNDING):
            break
        failed = [pair for pair in pairwise(found[1]) if not is_flown(*pair)]
        if not failed:
            return _choice_of(order, imaging, known, *found, choice.greedy_value)
        edges = len(hoped.before)
        for pair in failed:
            hoped = hoped.without(imaging, *pair)
        if len(hoped.before) == edges:
            break
    return choice


def _choice_of(
    order: Sequence[int],
    imaging: Imaging,
    graph: SlewGraph,
    value: float,
    path: list[int],
    greedy_value: float,
) -> Choice:
    path = _less_tilted(imaging, graph, path)
    return Choice(
        chosen=tuple(order[k] for k in path),
        requests=tuple(int(imaging.request[k]) for k in path),
        value=value,
        greedy_value=greedy_value,
    )


def bound_of(
    candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews, value: float
) -> float:
    """No choice of these candidates is worth more, whatever its slews; value: of one of them."""
    least = float(sum(priorities[request] for request in {one.request for one in candidates}))
    if least <= value or effort.remaining() <= 0.0:
        return least
    with effort.at_most(OPTIONS.bound_share * effort.remaining()):
        _, imaging, graph = _made_ready(candidates, priorities, slews, NECESSARY)
        for one in _rounds(imaging, graph, OPTIONS.bound_labels_max):
            least = min(least, label_search.bound([one]))
            if least <= value or effort.remaining() <= 0.0:
                break
    return max(least, value)


def _made_ready(
    candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews, sign: float
) -> tuple[list[int], Imaging, SlewGraph]:
    """Numbers of the candidates by their start, the candidates so, and which can follow which by
    slew times as of `slew_fits`."""
    order = sorted(range(len(candidates)), key=lambda k: candidates[k].arcs[0].first_row)
    ordered = [candidates[k] for k in order]
    imaging = Imaging(
        start_tick=np.array([c.arcs[0].first_row for c in ordered]),
        stop_tick=np.array([c.arcs[-1].last_row for c in ordered]),
        request=np.array([c.request for c in ordered]),
        part=np.array([c.part for c in ordered]),
        priority=np.array([0.0 if c.part == OPENS else priorities[c.request] for c in ordered]),
        tilt_rad=np.array([c.tilt_rad for c in ordered]),
    )
    entry_states = np.array([c.entry_state for c in ordered])
    exit_states = np.array([c.exit_state for c in ordered])
    before: list[Indices] = []
    for j, start_tick in enumerate(imaging.start_tick):
        ticks = start_tick - imaging.stop_tick
        # Beyond, it is followed by way of an idle instant.
        i = np.flatnonzero((ticks > 0) & (ticks < slews.widest_ticks + OPTIONS.wait_ticks))
        effort.charge(OPTIONS.pair * len(i))
        after = np.full(len(i), j)
        before.append(i[slews.fit(exit_states, entry_states, i, after, ticks[i], sign)])
    first = np.cumsum([0, *map(len, before)])
    return order, imaging, SlewGraph(first, np.concatenate(before), slews.widest_ticks)


def _rounds(
    imaging: Imaging,
    graph: SlewGraph,
    labels_max: int = label_search.OPTIONS.search_labels_max,
) -> Iterator[Round]:
    longest_ticks = int(np.max(imaging.stop_tick - imaging.start_tick))
    leap_ticks = longest_ticks + graph.reach_ticks + 2 * OPTIONS.wait_ticks
    stereo = np.unique(imaging.request[imaging.part != WHOLE]).tolist()
    ticks, things = imaging.start_tick, int(imaging.request.max()) + 1
    repeats = Repeats(things, imaging.request, ticks, ticks, leap_ticks, stereo)
    return rounds(
        lambda memory: Round(*_label_paths(imaging, graph, memory, OPTIONS.wait_ticks)),
        repeats,
        labels_max,
    )


@compiled
def _label_paths(
    imaging: Imaging, graph: SlewGraph, memory: LabelMemory, wait_ticks: int
) -> tuple[float, Indices, int]:
    """A `Round`.  Places: candidates, then idle instants; visits are numbered by candidate."""
    n = len(imaging.start_tick)
    end = int(imaging.stop_tick.max()) + graph.reach_ticks + 2 * wait_ticks
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
        visit(labels, graph.before[graph.first[j] : graph.first[j + 1]], j, memory, made)
        free = (imaging.stop_tick[j] + graph.reach_ticks + wait_ticks - 1) // wait_ticks
        follow(labels, j, (n + free,), memory.every, False)
    value, visits, count = best(labels, (0, n))
    return max(value, 0.0), visits, count


def _without_repeats(imaging: Imaging, path: list[int]) -> tuple[float, list[int]]:
    """The path with later repeats and halves of pairs left out.

    What remains stays flyable, the gaps only grow.
    """
    first: dict[tuple[int, int], int] = {}
    for k in path:
        first.setdefault((int(imaging.request[k]), int(imaging.part[k])), k)
    whole = {
        request
        for request, _ in first
        if _is_whole({part for other, part in first if other == request})
    }
    kept = [k for (request, _), k in first.items() if request in whole]
    return float(sum(imaging.priority[k] for k in kept)), kept


def _is_whole(parts: Collection[int]) -> bool:
    """Whether a request's looks are all there."""
    return WHOLE in parts or (OPENS in parts and COMPLETES in parts)


def _greedy(
    imaging: Imaging, graph: SlewGraph, priorities: Sequence[float]
) -> tuple[float, list[int]]:
    """Requests by falling priority, each at the first time that fits between those placed."""
    placed: list[int] = []
    total = 0.0
    for request in sorted(range(len(priorities)), key=lambda r: -priorities[r]):
        parts = sorted({int(p) for p in imaging.part[imaging.request == request]})
        trial = placed
        for part in parts:
            options = np.flatnonzero((imaging.request == request) & (imaging.part == part)).tolist()
            first = next((k for k in options if _fits(imaging, graph, trial, k)), None)
            if first is None:
                break
            trial = sorted([*trial, first])
        else:
            if _is_whole(parts):
                placed, total = trial, total + priorities[request]
    return total, placed


def _less_tilted(imaging: Imaging, graph: SlewGraph, path: list[int]) -> list[int]:
    """The same requests, each moved to where it is seen from nearest overhead among its free
    neighbours; stereo looks stay."""
    request, tilt_rad = imaging.request, imaging.tilt_rad
    for k in list(path):
        if imaging.part[k] != WHOLE:
            continue
        others = [other for other in path if other != k]
        options = np.flatnonzero((request == request[k]) & (tilt_rad < tilt_rad[k]))
        for option in options[np.argsort(tilt_rad[options], kind="stable")].tolist():
            if _fits(imaging, graph, others, option):
                path = sorted([*others, option])
                break
    return path


def _fits(imaging: Imaging, graph: SlewGraph, placed: list[int], k: int) -> bool:
    """Whether a candidate's slews from and to its neighbours among those placed have their time."""
    before = [(i, k) for i in placed if i < k][-1:]
    after = [(k, j) for j in placed if j > k][:1]
    return all(graph.follows(imaging, *pair) for pair in (*before, *after))
