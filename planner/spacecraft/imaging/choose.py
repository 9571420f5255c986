"""Which requests are imaged, when and in what order: the best choice, with a bound.

A path through candidates in order of time, worth the priorities of the requests it fulfils.
Repeats are first allowed and then forbidden where they occur (decremental state-space
relaxation with local memory): every round's value bounds the optimum from above, and the
first path without repeats is optimal.  The two looks of a stereo pair are candidates of their
own; only the second earns, and only after the first.
Source: Righini, Salani 2008, Networks 51(3); Baldacci, Mingozzi, Roberti 2011, Operations
Research 59(5) (ng-routes); Peng et al. 2020 (agile satellites).
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner import effort
from planner.arrays import Array
from planner.label_search import COMPLETES, OPENS, WHOLE, Memory, Repeats, Round, bound, rounds
from planner.spacecraft.imaging.candidates import Candidate
from planner.spacecraft.imaging.path_labels import WAIT_TICKS, Imaging, Turns, label_paths
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turns.turn_time import MovingEnds, TurnTime

Ints = NDArray[np.int64]
PAIR = 0.06  # of `planner.effort`


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Candidates in order of time, and how good the choice of them is.

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

    @property
    def proven_optimal(self) -> bool:
        return self.bound <= self.value * (1.0 + 1e-9)


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Candidates sorted by start, (n,) each, and the turns between them.

    candidate: index in the order given.  start, stop: whole ticks.  priority: what imaging it
    adds to the choice's value, nothing for the first of a stereo pair.  extra_ticks: (node,
    node) -> turn time known to be needed, where it was estimated too short.
    """

    candidate: Ints
    start: Ints
    stop: Ints
    request: Ints
    part: Ints
    priority: Array
    entry: MovingEnds
    exit: MovingEnds
    tilt_rad: Array
    turn_time: TurnTime
    extra_ticks: dict[tuple[int, int], int]

    def turn_ticks(self, before: Ints, after: int) -> Ints:
        """Turn time from each of some nodes to one."""
        ticks = self.turn_time.ticks(self.exit[before], self.entry[after : after + 1])
        if not self.extra_ticks:
            return ticks
        known = [self.extra_ticks.get((int(k), after), 0) for k in before]
        return np.maximum(ticks, np.array(known, dtype=np.int64))


def choose(
    candidates: Sequence[Candidate],
    priorities: Sequence[float],
    turn_time: TurnTime,
    extra_ticks: dict[tuple[int, int], int],
) -> Choice:
    """The best choice.  extra_ticks: (candidate, candidate) -> turn time known to be needed."""
    nodes = _nodes(candidates, priorities, turn_time, extra_ticks)
    pairs = _pairs(nodes)

    def sweep(memory: Memory) -> Round:
        return Round(
            *label_paths(
                Imaging(nodes.start, nodes.stop, nodes.request, nodes.part, nodes.priority),
                Turns(pairs.first, pairs.before, pairs.reach),
                memory,
            )
        )

    greedy = _greedy(nodes, priorities)
    found: list[Round] = []
    best: tuple[float, list[int]] = (0.0, [])
    for one in rounds(sweep, _repeats(nodes, len(priorities), pairs)):
        found.append(one)
        flyable = _without_repeats(nodes, one.visits[:, 0].tolist())
        best = max(best, flyable, key=lambda item: item[0])
        if one.value <= max(best[0], greedy[0]):
            break
    value, path = max(best, greedy, key=lambda item: item[0])
    path = _less_tilted(nodes, path)
    return Choice(
        chosen=tuple(int(nodes.candidate[k]) for k in path),
        requests=tuple(int(nodes.request[k]) for k in path),
        value=value,
        bound=bound(found),
        greedy_value=greedy[0],
        rounds=len(found),
    )


def _nodes(
    candidates: Sequence[Candidate],
    priorities: Sequence[float],
    turn_time: TurnTime,
    extra_ticks: dict[tuple[int, int], int],
) -> _Nodes:
    order = np.argsort([round(c.start_s / TICK_S) for c in candidates], kind="stable")
    node = {int(k): place for place, k in enumerate(order)}
    ordered = [candidates[k] for k in order]
    return _Nodes(
        candidate=np.asarray(order, dtype=np.int64),
        start=np.array([round(c.start_s / TICK_S) for c in ordered], dtype=np.int64),
        stop=np.array([round(c.stop_s / TICK_S) for c in ordered], dtype=np.int64),
        request=np.array([c.request for c in ordered], dtype=np.int64),
        part=np.array([c.part for c in ordered], dtype=np.int64),
        priority=np.array([0.0 if c.part == 1 else priorities[c.request] for c in ordered]),
        entry=MovingEnds.concatenate([c.entry for c in ordered]),
        exit=MovingEnds.concatenate([c.exit for c in ordered]),
        tilt_rad=np.array([c.tilt_rad for c in ordered]),
        turn_time=turn_time,
        extra_ticks={(node[a], node[b]): ticks for (a, b), ticks in extra_ticks.items()},
    )


@dataclass(frozen=True, eq=False)
class _Pairs:
    """For node j the predecessors it can follow directly, first[j] .. first[j + 1], and reach:
    ticks after a node's stop by which any other can be entered, (n,)."""

    first: Ints
    before: Ints
    reach: Ints


def _pairs(nodes: _Nodes) -> _Pairs:
    n = len(nodes.start)
    widest = max([nodes.turn_time.widest_ticks, *nodes.extra_ticks.values()])
    reach = np.zeros(n, dtype=np.int64)
    before: list[Ints] = []
    first = np.zeros(n + 1, dtype=np.int64)
    for j in range(n):
        gap = nodes.start[j] - nodes.stop
        i = np.flatnonzero((gap > 0) & (gap <= widest))
        effort.spend(PAIR * len(i))
        needed = nodes.turn_ticks(i, j)
        np.maximum.at(reach, i, needed)
        before.append(np.asarray(i[needed <= gap[i]], dtype=np.int64))
        first[j + 1] = first[j] + len(before[-1])
    return _Pairs(first, np.concatenate(before) if n else np.zeros(0, dtype=np.int64), reach)


def _repeats(nodes: _Nodes, count: int, pairs: _Pairs) -> Repeats:
    first_tick = np.full(count, nodes.stop.max())
    last_tick = np.zeros(count, dtype=np.int64)
    np.minimum.at(first_tick, nodes.request, nodes.start)
    np.maximum.at(last_tick, nodes.request, nodes.start)
    leap_ticks = int(np.max(nodes.stop - nodes.start) + np.max(pairs.reach)) + 2 * WAIT_TICKS
    stereo = np.unique(nodes.request[nodes.part != WHOLE]).tolist()
    return Repeats(first_tick, last_tick, leap_ticks, stereo)


def _without_repeats(nodes: _Nodes, path: list[int]) -> tuple[float, list[int]]:
    """The path with later repeats and halves of pairs left out.

    What remains stays flyable, the gaps only grow.
    """
    first: dict[tuple[int, int], int] = {}
    for k in path:
        first.setdefault((int(nodes.request[k]), int(nodes.part[k])), k)
    whole = {
        request
        for request, _ in first
        if _is_whole({part for other, part in first if other == request})
    }
    kept = [k for (request, _), k in first.items() if request in whole]
    return float(sum(nodes.priority[k] for k in kept)), kept


def _is_whole(parts: Collection[int]) -> bool:
    """Whether a request's looks are all there."""
    return WHOLE in parts or (OPENS in parts and COMPLETES in parts)


def _greedy(nodes: _Nodes, priorities: Sequence[float]) -> tuple[float, list[int]]:
    """Requests by falling priority, each at the first time that fits between those placed."""
    placed: list[int] = []
    total = 0.0
    for request in sorted(range(len(priorities)), key=lambda r: -priorities[r]):
        parts = sorted({int(p) for p in nodes.part[nodes.request == request]})
        trial = placed
        for part in parts:
            options = np.flatnonzero((nodes.request == request) & (nodes.part == part)).tolist()
            first = next((k for k in options if _fits(nodes, trial, k)), None)
            if first is None:
                break
            trial = sorted([*trial, first], key=lambda k: int(nodes.start[k]))
        else:
            if _is_whole(parts):
                placed, total = trial, total + priorities[request]
    return total, placed


def _less_tilted(nodes: _Nodes, path: list[int]) -> list[int]:
    """The same requests, each moved to where it is seen from nearest overhead among its free
    neighbours; stereo looks stay."""
    for k in list(path):
        if nodes.part[k] != 0:
            continue
        others = [other for other in path if other != k]
        options = np.flatnonzero(
            (nodes.request == nodes.request[k]) & (nodes.tilt_rad < nodes.tilt_rad[k])
        )
        for option in options[np.argsort(nodes.tilt_rad[options], kind="stable")].tolist():
            if _fits(nodes, others, option):
                path = sorted([*others, option])
                break
    return path


def _fits(nodes: _Nodes, placed: list[int], k: int) -> bool:
    """Whether a node's turns from and to its neighbours among those placed have their time."""
    before = [i for i in placed if nodes.start[i] <= nodes.start[k]]
    after = [i for i in placed if nodes.start[i] > nodes.start[k]]
    return all(
        nodes.turn_ticks(np.array([i]), j)[0] <= nodes.start[j] - nodes.stop[i]
        for i, j in (*((i, k) for i in before[-1:]), *((k, j) for j in after[:1]))
    )
