"""The best choice found of requests to image, their times and order, and what bounds it.

A path through candidates in order of time, worth the priorities of the requests it fulfils, found
by `label_search` with slew times that suffice, and bounded by it with times that none can beat, as
in campaigns.  The two looks of a stereo pair are candidates of their own; only the second earns,
and only after the first.
Source: Peng et al. 2020 (agile satellites).
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
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
    wait_ticks: int = 10  # of the chain of idle instants: 2 s, little beside a slew to them
    bound_labels_max: int = 2_000_000  # no round of the bound is begun after so many: 2 s
    bound_share: float = 0.3  # of what work is left: the rest is for flights


OPTIONS = ChoiceOptions()


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

    def follows(self, i: int, j: int) -> bool:
        """Whether candidate j can follow candidate i."""
        is_late = self.start_tick[j] - self.stop_tick[i] >= self.reach_ticks
        return bool(is_late or i in self.before[self.first[j] : self.first[j + 1]])


def choose(candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews) -> Choice:
    """The best choice of candidates by their start for slew times that suffice, if labels last."""
    if not candidates:
        return Choice()
    imaging = _made_ready(candidates, priorities, slews, SUFFICIENT)
    greedy = most = _greedy(imaging, priorities)
    for one in _rounds(imaging):
        most = max(most, _without_repeats(imaging, one.visits[:, 0].tolist()), key=itemgetter(0))
        if one.value <= most[0]:
            break
    value, path = most
    chosen = tuple(candidates[k] for k in _less_tilted(candidates, imaging, path))
    return Choice(chosen=chosen, value=value, greedy_value=greedy[0])


def bound_of(
    candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews, value: float
) -> float:
    """No choice of these candidates is worth more, whatever its slews; value: of one of them."""
    least = float(sum(priorities[request] for request in {one.request for one in candidates}))
    if least > value and effort.remaining() > 0.0:
        with effort.at_most(OPTIONS.bound_share * effort.remaining()):
            imaging = _made_ready(candidates, priorities, slews, NECESSARY)
            for one in _rounds(imaging, OPTIONS.bound_labels_max):
                least = min(least, label_search.bound([one]))
                if least <= value or effort.remaining() <= 0.0:
                    break
    return max(least, value)


def _made_ready(
    candidates: Sequence[Candidate], priorities: Sequence[float], slews: Slews, sign: float
) -> Imaging:
    """sign: of the slew times, as of `slew_fits`."""
    start_tick = np.array([c.arcs[0].first_row for c in candidates])
    stop_tick = np.array([c.arcs[-1].last_row for c in candidates])
    entry_states = np.array([c.entry_state for c in candidates])
    exit_states = np.array([c.exit_state for c in candidates])
    before: list[Indices] = []
    for j, tick in enumerate(start_tick):
        ticks = tick - stop_tick
        # Beyond, it is followed by way of an idle instant.
        i = np.flatnonzero((ticks > 0) & (ticks < slews.widest_ticks + OPTIONS.wait_ticks))
        effort.charge(OPTIONS.pair * len(i))
        after = np.full(len(i), j)
        before.append(i[slews.fit(exit_states, entry_states, i, after, ticks[i], sign)])
    return Imaging(
        start_tick=start_tick,
        stop_tick=stop_tick,
        request=np.array([c.request for c in candidates]),
        part=np.array([c.part for c in candidates]),
        priority=np.array([0.0 if c.part == OPENS else priorities[c.request] for c in candidates]),
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
) -> tuple[float, Indices, int]:
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


def _greedy(imaging: Imaging, priorities: Sequence[float]) -> tuple[float, list[int]]:
    """Requests by falling priority, each at the first time that fits between those placed."""
    placed: list[int] = []
    total = 0.0
    for request in sorted(range(len(priorities)), key=lambda r: -priorities[r]):
        parts = sorted({int(p) for p in imaging.part[imaging.request == request]})
        trial = placed
        for part in parts:
            options = np.flatnonzero((imaging.request == request) & (imaging.part == part)).tolist()
            first = next((k for k in options if _fits(imaging, trial, k)), None)
            if first is None:
                break
            trial = sorted([*trial, first])
        else:
            if _is_whole(parts):
                placed, total = trial, total + priorities[request]
    return total, placed


def _less_tilted(candidates: Sequence[Candidate], imaging: Imaging, path: list[int]) -> list[int]:
    """The same requests, each moved to where it is seen from nearest overhead among its free
    neighbours; stereo looks stay."""
    tilt_rad = np.array([one.tilt_rad for one in candidates])
    for k in list(path):
        if imaging.part[k] != WHOLE:
            continue
        others = [other for other in path if other != k]
        options = np.flatnonzero((imaging.request == imaging.request[k]) & (tilt_rad < tilt_rad[k]))
        for option in options[np.argsort(tilt_rad[options], kind="stable")].tolist():
            if _fits(imaging, others, option):
                path = sorted([*others, option])
                break
    return path


def _fits(imaging: Imaging, placed: list[int], k: int) -> bool:
    """Whether a candidate's slews from and to its neighbours among those placed have their time."""
    before = [(i, k) for i in placed if i < k][-1:]
    after = [(k, j) for j in placed if j > k][:1]
    return all(imaging.follows(*pair) for pair in (*before, *after))
