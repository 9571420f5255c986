"""Which requests are imaged, when and in what order?  Exact, with a bound.

A path through candidates in order of time, worth the priorities of the requests it fulfils.
Repeats are first allowed and then forbidden where they occur (decremental state-space
relaxation with local memory): every round's value bounds the optimum from above, and the
first path without repeats is optimal.  The two looks of a stereo pair are candidates of their
own; only the second earns, and only after the first.
Source: Righini, Salani 2008, Networks 51(3); Baldacci, Mingozzi, Roberti 2011, Operations
Research 59(5) (ng-routes); Peng et al. 2020 (agile satellites).
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner import effort
from planner.arrays import Array
from planner.spacecraft.imaging.candidates import Candidate
from planner.spacecraft.imaging.path_labels import WAIT_TICKS, label_paths
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turns.turn_time import MovingEnds, TurnTime, joined

Ints = NDArray[np.int64]
LABELS_MAX = 4_000_000
BITS = 62
SEARCHED_MAX = 8_000_000  # labels of all rounds; then the best choice and its bound are returned
LABEL, PAIR = 0.1, 0.06  # of `planner.effort`


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Chosen candidates in order of time, and how good the choice is.

    chosen: indices into the candidates; requests: theirs.  value: sum of priorities
    fulfilled.  bound: no choice from these candidates and turn times is worth more.
    greedy_value: of taking requests by priority, each at the first moment that fits.
    rounds: relaxations solved.
    """

    chosen: tuple[int, ...]
    requests: tuple[int, ...]
    value: float
    bound: float
    greedy_value: float
    rounds: int
    seconds: float

    @property
    def proven_optimal(self) -> bool:
        return self.bound <= self.value * (1.0 + 1e-9)


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Candidates sorted by start, in whole ticks; the attitudes they begin and end in."""

    order: Ints
    start: Ints
    stop: Ints
    request: Ints
    part: Ints
    entry: MovingEnds
    exit: MovingEnds
    tilt: Array


def choose(
    candidates: Sequence[Candidate],
    priorities: Sequence[float],
    turn_time: TurnTime,
    extra_ticks: dict[tuple[int, int], int],
) -> Choice:
    """The best choice.  extra_ticks: (candidate, candidate) -> turn time known to be needed."""
    begun = time.perf_counter()
    nodes = _nodes(candidates)
    earn = np.array([0.0 if p == 1 else priorities[r] for r, p in zip(nodes.request, nodes.part,
        strict=True)])  # fmt: skip
    pairs = _pairs(nodes, turn_time, extra_ticks)
    stereo = sorted({int(r) for r, p in zip(nodes.request, nodes.part, strict=True) if p})
    hop_ticks = int(np.max(nodes.stop - nodes.start) + np.max(pairs.reach)) + 2 * WAIT_TICKS
    memory = _Memory(nodes, len(priorities), stereo, hop_ticks)
    bound, rounds, searched = np.inf, 0, 0
    best: tuple[float, list[int]] = (-1.0, [])
    while True:
        rounds += 1
        value, path, labels = _relaxed(nodes, earn, pairs, memory)
        effort.count(LABEL * labels)
        searched += labels
        complete = labels < LABELS_MAX
        if complete:
            bound = min(bound, value)
        best = max(best, _without_repeats(nodes, path, earn), key=lambda item: item[0])
        ended = not complete or searched > SEARCHED_MAX
        if ended or not _remember_repeats(nodes, path, memory):
            break
    greedy = _greedy(nodes, priorities, turn_time, extra_ticks)
    best = max(best, greedy, key=lambda item: item[0])
    path = _less_tilted(nodes, best[1], turn_time, extra_ticks)
    return Choice(
        chosen=tuple(int(nodes.order[k]) for k in path),
        requests=tuple(int(nodes.request[k]) for k in path),
        value=best[0],
        bound=float(bound),
        greedy_value=greedy[0],
        rounds=rounds,
        seconds=time.perf_counter() - begun,
    )


def _nodes(candidates: Sequence[Candidate]) -> _Nodes:
    start = np.array([round(c.start_s / TICK_S) for c in candidates], dtype=np.int64)
    order = np.argsort(start, kind="stable")

    def column(values: list[int]) -> Ints:
        return np.array(values, dtype=np.int64)[order]

    return _Nodes(
        order=np.asarray(order, dtype=np.int64),
        start=start[order],
        stop=column([round(c.stop_s / TICK_S) for c in candidates]),
        request=column([c.request for c in candidates]),
        part=column([c.part for c in candidates]),
        entry=joined([c.entry for c in candidates])[order],
        exit=joined([c.exit for c in candidates])[order],
        tilt=np.array([c.tilt_rad for c in candidates])[order],
    )


@dataclass(frozen=True, eq=False)
class _Pairs:
    """For node j the predecessors it can follow directly, first[j] .. first[j + 1], and reach:
    ticks after a node's stop by which any other can be entered, (n,)."""

    first: Ints
    before: Ints
    reach: Ints


def _pairs(nodes: _Nodes, turn_time: TurnTime, extra_ticks: dict[tuple[int, int], int]) -> _Pairs:
    n = len(nodes.start)
    widest = turn_time.widest_ticks
    widest = max([widest, *extra_ticks.values()], default=widest)
    reach = np.zeros(n, dtype=np.int64)
    before: list[Ints] = []
    first = np.zeros(n + 1, dtype=np.int64)
    position = {int(k): place for place, k in enumerate(nodes.order)}
    extra = {(position[a], position[b]): ticks for (a, b), ticks in extra_ticks.items()}
    for j in range(n):
        gap = nodes.start[j] - nodes.stop
        i = np.flatnonzero((gap > 0) & (gap <= widest))
        effort.spend(PAIR * len(i))
        needed = turn_time.ticks(nodes.exit[i], nodes.entry[j : j + 1])
        if extra:
            needed = np.array([max(t, extra.get((int(a), j), 0)) for a, t in zip(i, needed,
                strict=True)], dtype=np.int64)  # fmt: skip
        np.maximum.at(reach, i, needed)
        before.append(np.asarray(i[needed <= gap[i]], dtype=np.int64))
        first[j + 1] = first[j] + len(before[-1])
    return _Pairs(first, np.concatenate(before) if n else np.zeros(0, dtype=np.int64), reach)


class _Memory:
    """bit: request -> its place in a label's memory; requests whose candidates lie further apart
    than a label can leap (hop_ticks) share places.  kept: per request, the bits a label still
    remembers after imaging it (all stereo pairs, and requests seen to repeat around it).
    born, alive: first and last start of each request's candidates."""

    def __init__(self, nodes: _Nodes, count: int, stereo: list[int], hop_ticks: int) -> None:
        self.hop_ticks = hop_ticks
        self.bit: dict[int, int] = {}
        self.kept = np.zeros(count, dtype=np.int64)
        self.born = np.full(count, np.iinfo(np.int64).max)
        self.alive = np.zeros(count, dtype=np.int64)
        np.minimum.at(self.born, nodes.request, nodes.start)
        np.maximum.at(self.alive, nodes.request, nodes.start)
        for request in stereo:
            self.place(request)
        self.kept[:] = sum({1 << place for place in self.bit.values()})

    def place(self, request: int) -> int | None:
        """The request's place, given when first asked; None when all are taken."""
        if request not in self.bit:
            taken = {
                place
                for other, place in self.bit.items()
                if self.born[other] <= self.alive[request] + self.hop_ticks
                and self.born[request] <= self.alive[other] + self.hop_ticks
            }
            free = next((place for place in range(BITS) if place not in taken), None)
            if free is None:
                return None
            self.bit[request] = free
        return self.bit[request]


def _remember_repeats(nodes: _Nodes, path: list[int], memory: _Memory) -> bool:
    """Forbid the shortest way each request repeats in the path; False when none can be."""
    last: dict[int, int] = {}
    learnt = False
    requests = [int(nodes.request[k]) for k in path]
    for place, (k, request) in enumerate(zip(path, requests, strict=True)):
        if nodes.part[k] != 0:
            continue
        if request in last:
            place_in_memory = memory.place(request)
            if place_in_memory is None:
                continue
            mask = 1 << place_in_memory
            memory.kept[requests[last[request] : place + 1]] |= mask
            learnt = True
        last[request] = place
    return learnt


def _relaxed(
    nodes: _Nodes, earn: Array, pairs: _Pairs, memory: _Memory
) -> tuple[float, list[int], int]:
    """Best path as far as repeats are remembered; (value, node indices, labels made)."""
    n = len(nodes.start)
    bit = np.full(len(memory.kept), -1, dtype=np.int64)
    for request, place in memory.bit.items():
        bit[request] = place
    value, parent, node, best, count = label_paths(
        nodes.start,
        nodes.stop,
        nodes.request,
        nodes.part,
        earn,
        pairs.first,
        pairs.before,
        pairs.reach,
        bit,
        memory.kept,
        memory.born,
        memory.alive,
        LABELS_MAX,
    )
    path: list[int] = []
    k = best
    while k >= 0:
        if 0 <= node[k] < n:
            path.append(int(node[k]))
        k = int(parent[k])
    return float(value[best]) if best >= 0 else 0.0, path[::-1], count


def _without_repeats(nodes: _Nodes, path: list[int], earn: Array) -> tuple[float, list[int]]:
    """The path with later repeats left out: what remains stays flyable, the gaps only grow."""
    seen: set[tuple[int, int]] = set()
    kept = []
    for k in path:
        what = (int(nodes.request[k]), int(nodes.part[k]))
        if what not in seen:
            seen.add(what)
            kept.append(k)
    return float(sum(earn[k] for k in kept)), kept


def _greedy(
    nodes: _Nodes,
    priorities: Sequence[float],
    turn_time: TurnTime,
    extra_ticks: dict[tuple[int, int], int],
) -> tuple[float, list[int]]:
    """Requests by falling priority, each at the first time that fits between those placed."""
    placed: list[int] = []
    total = 0.0
    for request in sorted(range(len(priorities)), key=lambda r: -priorities[r]):
        parts = sorted({int(p) for p in nodes.part[nodes.request == request]})
        trial = placed
        for part in parts:
            options = np.flatnonzero((nodes.request == request) & (nodes.part == part))
            spot = next(
                (int(k) for k in options if _fits(nodes, trial, int(k), turn_time, extra_ticks)),
                None,
            )
            if spot is None:
                break
            trial = sorted([*trial, spot], key=lambda k: int(nodes.start[k]))
        else:
            if parts:
                placed, total = trial, total + priorities[request]
    return total, placed


def _less_tilted(
    nodes: _Nodes, path: list[int], turn_time: TurnTime, extra_ticks: dict[tuple[int, int], int]
) -> list[int]:
    """The same requests, each moved to where it is seen from nearest overhead among its free
    neighbours; stereo looks stay."""
    for k in list(path):
        if nodes.part[k] != 0:
            continue
        others = [other for other in path if other != k]
        options = np.flatnonzero((nodes.request == nodes.request[k]) & (nodes.tilt < nodes.tilt[k]))
        for option in options[np.argsort(nodes.tilt[options], kind="stable")].tolist():
            if _fits(nodes, others, option, turn_time, extra_ticks):
                path = sorted([*others, option])
                break
    return path


def _fits(
    nodes: _Nodes,
    placed: list[int],
    k: int,
    turn_time: TurnTime,
    extra_ticks: dict[tuple[int, int], int],
) -> bool:
    before = [i for i in placed if nodes.start[i] <= nodes.start[k]]
    after = [i for i in placed if nodes.start[i] > nodes.start[k]]
    neighbours = [(before[-1], k)] if before else []
    if after:
        neighbours.append((k, after[0]))
    for i, j in neighbours:
        gap = nodes.start[j] - nodes.stop[i]
        needed = int(turn_time.ticks(nodes.exit[i : i + 1], nodes.entry[j : j + 1])[0])
        needed = max(needed, extra_ticks.get((int(nodes.order[i]), int(nodes.order[j])), 0))
        if gap < needed:
            return False
    return True
