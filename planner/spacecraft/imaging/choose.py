"""The best choice found of requests to image, their times and order.

A path through candidates in order of time, worth the priorities of the requests it fulfils, found
by `label_search`.  The two looks of a stereo pair are candidates of their own; only the
second earns, and only after the first.
Source: Peng et al. 2020 (agile satellites).
"""

from collections.abc import Collection, Sequence, Set
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled
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
from planner.spacecraft.table import TICK_S

PAIR = 0.3  # of `effort`
WAIT_TICKS = 10  # of the chain of idle instants: 2 s, the grid of the candidates


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Candidates in order of time, and how good the choice of them is: the best found for slew
    times that suffice, mostly longer than the slews', so that a better one may exist.

    chosen: indices into the candidates; requests: theirs.  value: sum of priorities
    fulfilled.  greedy_value: of taking requests by priority, each at the first moment that fits.
    rounds: relaxations solved.
    """

    chosen: tuple[int, ...]
    requests: tuple[int, ...]
    value: float
    greedy_value: float
    rounds: int


class Imaging(NamedTuple):
    """Candidates by their start, (n,) each; priority: what imaging each adds to a choice's value,
    nothing for the first of a stereo pair."""

    start_tick: Indices
    stop_tick: Indices
    request: Indices
    part: Indices
    priority: Array


class SlewGraph(NamedTuple):
    """first (n + 1,): candidate j can directly follow before[first[j]] to before[first[j + 1]].

    reach_ticks: so long after a candidate's stop any other can be begun.
    """

    first: Indices
    before: Indices
    reach_ticks: int


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Candidates by their start, and the slews between them.

    candidate: index in the order given, (n,).  entry_states, exit_states: (n, 11).
    apart: nodes of which the second can't follow the first, though the time seemed to suffice.
    """

    imaging: Imaging
    candidate: Indices
    entry_states: Array
    exit_states: Array
    tilt_rad: Array
    slews: Slews
    apart: Set[tuple[int, int]]

    def follow(self, before: Indices, after: Indices) -> Mask:
        """Whether nodes can follow others, (n,)."""
        gap = self.imaging.start_tick[after] - self.imaging.stop_tick[before]
        fits = self.slews.fit(self.exit_states, self.entry_states, before, after, gap)
        if self.apart:
            pairs = zip(before.tolist(), after.tolist(), strict=True)
            fits &= np.fromiter((pair not in self.apart for pair in pairs), np.bool_, len(before))
        return fits


def choose(
    candidates: Sequence[Candidate],
    priorities: Sequence[float],
    slews: Slews,
    apart: Set[tuple[int, int]] = frozenset(),
) -> Choice:
    """The best choice for these slew times, if labels last.

    apart: candidates of which the second can't follow the first.
    """
    nodes = _nodes(candidates, priorities, slews, apart)
    imaging, graph = nodes.imaging, _slew_graph(nodes)
    greedy = _greedy(nodes, priorities)
    solved = 0
    most: tuple[float, list[int]] = (0.0, [])
    for one in rounds(
        lambda memory: Round(*_label_paths(imaging, graph, memory)),
        _repeats(imaging, len(priorities), graph),
    ):
        solved += 1
        flyable = _without_repeats(imaging, one.visits[:, 0].tolist())
        most = max(most, flyable, key=lambda item: item[0])
        if one.value <= max(most[0], greedy[0]):
            break
    value, path = max(most, greedy, key=lambda item: item[0])
    path = _less_tilted(nodes, path)
    return Choice(
        chosen=tuple(int(nodes.candidate[k]) for k in path),
        requests=tuple(int(imaging.request[k]) for k in path),
        value=value,
        greedy_value=greedy[0],
        rounds=solved,
    )


def _nodes(
    candidates: Sequence[Candidate],
    priorities: Sequence[float],
    slews: Slews,
    apart: Set[tuple[int, int]],
) -> _Nodes:
    order = np.argsort([round(c.start_s / TICK_S) for c in candidates], kind="stable")
    node = {int(k): place for place, k in enumerate(order)}
    ordered = [candidates[k] for k in order]
    return _Nodes(
        imaging=Imaging(
            start_tick=np.array([round(c.start_s / TICK_S) for c in ordered]),
            stop_tick=np.array([round(c.stop_s / TICK_S) for c in ordered]),
            request=np.array([c.request for c in ordered]),
            part=np.array([c.part for c in ordered]),
            priority=np.array([0.0 if c.part == OPENS else priorities[c.request] for c in ordered]),
        ),
        candidate=order,
        entry_states=np.array([c.entry_state for c in ordered]),
        exit_states=np.array([c.exit_state for c in ordered]),
        tilt_rad=np.array([c.tilt_rad for c in ordered]),
        slews=slews,
        apart={(node[a], node[b]) for a, b in apart},
    )


def _slew_graph(nodes: _Nodes) -> SlewGraph:
    start_tick, stop_tick = nodes.imaging.start_tick, nodes.imaging.stop_tick
    widest = nodes.slews.widest_ticks
    before: list[Indices] = []
    for j, start in enumerate(start_tick):
        gap = start - stop_tick
        i = np.flatnonzero((gap > 0) & (gap < widest))
        effort.charge(PAIR * len(i))
        before.append(i[nodes.follow(i, np.full(len(i), j))])
    first = np.cumsum([0, *map(len, before)])
    return SlewGraph(first, np.concatenate(before), widest)


def _repeats(imaging: Imaging, count: int, graph: SlewGraph) -> Repeats:
    longest_ticks = int(np.max(imaging.stop_tick - imaging.start_tick))
    leap_ticks = longest_ticks + graph.reach_ticks + 2 * WAIT_TICKS
    stereo = np.unique(imaging.request[imaging.part != WHOLE]).tolist()
    start_tick = imaging.start_tick
    return Repeats(count, imaging.request, start_tick, start_tick, leap_ticks, stereo)


@compiled
def _label_paths(
    imaging: Imaging, graph: SlewGraph, memory: LabelMemory
) -> tuple[float, Indices, int]:
    """A `Round`.  Places: candidates, then idle instants; visits are numbered by candidate."""
    n = len(imaging.start_tick)
    end = int(imaging.stop_tick.max()) + graph.reach_ticks + 2 * WAIT_TICKS
    labels = no_labels(n + end // WAIT_TICKS + 2, n, memory)
    now = 0
    for j in range(n):
        start_tick = imaging.start_tick[j]
        while (now + 1) * WAIT_TICKS <= start_tick:
            now += 1
            mask = memory.tick_mask[now * WAIT_TICKS]
            follow(labels, n + now - 1, (n + now,), mask, False)
        made = Visit(j, imaging.request[j], imaging.part[j], imaging.priority[j], start_tick)
        visit(labels, (n + now,), j, memory, made)
        visit(labels, graph.before[graph.first[j] : graph.first[j + 1]], j, memory, made)
        free = (imaging.stop_tick[j] + graph.reach_ticks + WAIT_TICKS - 1) // WAIT_TICKS
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


def _greedy(nodes: _Nodes, priorities: Sequence[float]) -> tuple[float, list[int]]:
    """Requests by falling priority, each at the first time that fits between those placed."""
    request_of, part_of = nodes.imaging.request, nodes.imaging.part
    placed: list[int] = []
    total = 0.0
    for request in sorted(range(len(priorities)), key=lambda r: -priorities[r]):
        parts = sorted({int(p) for p in part_of[request_of == request]})
        trial = placed
        for part in parts:
            options = np.flatnonzero((request_of == request) & (part_of == part)).tolist()
            first = next((k for k in options if _fits(nodes, trial, k)), None)
            if first is None:
                break
            trial = sorted([*trial, first], key=lambda k: int(nodes.imaging.start_tick[k]))
        else:
            if _is_whole(parts):
                placed, total = trial, total + priorities[request]
    return total, placed


def _less_tilted(nodes: _Nodes, path: list[int]) -> list[int]:
    """The same requests, each moved to where it is seen from nearest overhead among its free
    neighbours; stereo looks stay."""
    request = nodes.imaging.request
    for k in list(path):
        if nodes.imaging.part[k] != WHOLE:
            continue
        others = [other for other in path if other != k]
        options = np.flatnonzero((request == request[k]) & (nodes.tilt_rad < nodes.tilt_rad[k]))
        for option in options[np.argsort(nodes.tilt_rad[options], kind="stable")].tolist():
            if _fits(nodes, others, option):
                path = sorted([*others, option])
                break
    return path


def _fits(nodes: _Nodes, placed: list[int], k: int) -> bool:
    """Whether a node's slews from and to its neighbours among those placed have their time."""
    start_tick = nodes.imaging.start_tick
    before = [i for i in placed if start_tick[i] <= start_tick[k]]
    after = [i for i in placed if start_tick[i] > start_tick[k]]
    pairs = [*((i, k) for i in before[-1:]), *((k, j) for j in after[:1])]
    return all(nodes.follow(np.array([i]), np.array([j]))[0] for i, j in pairs)
