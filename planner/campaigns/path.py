"""Which looks of one pass, one after another, are worth most together?"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array
from planner.campaigns.network import NEVER, Network
from planner.compiled import compiled

Indices = NDArray[np.intp]
NONE = -1
NOTHING = -np.inf
MEMORY_BITS_MAX = 8  # each doubles the states


@dataclass(frozen=True, kw_only=True)
class Look:
    """A target looked at: by which way (row in `Ways`), from which step on the grid.

    length: which of the target's lengths.
    """

    target: int
    way: int
    first_step: int
    length: int


@dataclass(frozen=True, kw_only=True)
class Path:
    """Looks in order of time, and what they are worth by the gains given."""

    value: float
    looks: tuple[Look, ...]


def best_path(network: Network, length_steps: Indices, gain: Array, *, each_once: bool) -> Path:
    """Dynamic programme over steps and ways.

    length_steps, gain: (targets, lengths); a look of no positive gain is never taken.
    each_once: no target is looked at twice, and so a better path may be missed; else the
    optimum of all paths, which may come back to a target after another one.
    """
    memory = _Memory.of(network, [], len(gain))
    return _traced(network, length_steps, gain, memory, each_once=each_once)


def path_bound(network: Network, length_steps: Indices, gain: Array) -> float:
    """No path that looks at each target once has a greater value.

    Targets that the best path looks at twice are remembered from then on, as far as
    MEMORY_BITS_MAX bits suffice.
    Source: Righini, Salani 2008, "New dynamic programming algorithms for the resource
    constrained elementary shortest path problem", Networks 51.
    """
    remembered: list[int] = []
    while True:
        memory = _Memory.of(network, remembered, len(gain))
        path = _traced(network, length_steps, gain, memory, each_once=False)
        counts = Counter(look.target for look in path.looks)
        again = [t for t, count in counts.items() if count > 1 and t not in remembered]
        if not again:
            return path.value
        remembered += again


@dataclass(frozen=True, kw_only=True, eq=False)
class _Memory:
    """Which looks a state remembers.

    bit: of each target, NONE for those forgotten at once, (targets,).  kept: bits that mean
    something on a way, (w,); targets that one way can tell apart never share a bit.
    """

    bit: Indices
    kept: Indices
    bits: int

    @classmethod
    def of(cls, network: Network, targets: Sequence[int], target_count: int) -> "_Memory":
        bit = np.full(target_count, NONE)
        kept = np.zeros(len(network.way), np.intp)
        meets = np.array([_meets(network, target) for target in targets])
        for row, target in enumerate(targets):
            apart = (meets[row] & meets[:row]).any(axis=1)
            taken = {int(bit[other]) for other in np.array(targets)[:row][apart]}
            free = [one for one in range(MEMORY_BITS_MAX) if one not in taken]
            if free:
                bit[target] = free[0]
                kept[meets[row]] |= 1 << free[0]
        return cls(bit=bit, kept=kept, bits=int(bit.max()) + 1)


def _meets(network: Network, target: int) -> NDArray[np.bool_]:
    """Ways that can be followed at some time while the target's can, or between them, (w,)."""
    own = network.target == target
    first, last = network.first[own].min(), network.last[own].max()
    return np.asarray((network.first <= last) & (network.last >= first))


def _traced(
    network: Network,
    length_steps: Indices,
    gain: Array,
    memory: _Memory,
    *,
    each_once: bool,
) -> Path:
    value, last, cells = _programme(
        (network.first, network.last, network.offset, network.target),
        (network.edge_from, network.edge_to, network.arrival_offset),
        network.arrival,
        network.reach,
        length_steps,
        gain,
        memory.bit,
        memory.kept,
        1 << memory.bits,
        each_once,
    )
    looks = []
    event = int(last)
    while event != NONE:
        way, first, length, event = (int(number) for number in cells[event])
        looks.append(
            Look(
                target=int(network.target[way]),
                way=int(network.way[way]),
                first_step=network.first_step + first,
                length=length,
            )
        )
    return Path(value=float(value), looks=tuple(reversed(looks)))


@compiled
def _programme(
    ways: tuple[Indices, Indices, Indices, Indices],
    edges: tuple[Indices, Indices, Indices],
    arrival: NDArray[np.int32],
    reach: int,
    length_steps: Indices,
    gain: Array,
    bit: Indices,
    kept: Indices,
    memories: int,
    each_once: bool,
) -> tuple[float, int, Indices]:
    """The greatest value, its last look, and of every look: way, first step, length, previous.

    A state is a cell (way and step) and a memory: which of the targets with a bit have been
    looked at.  A look is numbered by the state in which it ends, cell * memories + memory.
    ready: most worth on a way before its look; done: after one that ended on it, this way
    still followed.
    """
    first, last, offset, target = ways
    size = offset[-1] + last[-1] - first[-1] + 1
    looks = np.full((size * memories, 4), NONE)
    ready, ready_after = np.full(size * memories, NOTHING), np.full(size * memories, NONE)
    done, done_after = np.full(size * memories, NOTHING), np.full(size * memories, NONE)
    end = last.max() + 1
    best, best_after = np.full((end, memories), NOTHING), np.full((end, memories), NONE)
    best[0, 0] = 0.0
    for step in range(end):
        if step > 0:
            best[step], best_after[step] = best[step - 1], best_after[step - 1]
        for way in range(len(first)):
            if step < first[way] or step > last[way]:
                continue
            cell = offset[way] + step - first[way]
            if step == first[way]:
                since = max(step - reach, 0)
                _follow(
                    cell * memories, kept[way], best[since], best_after[since], ready, ready_after
                )
            else:
                held = slice((cell - 1) * memories, cell * memories)
                _follow(cell * memories, -1, ready[held], ready_after[held], ready, ready_after)
                _follow(cell * memories, -1, done[held], done_after[held], done, done_after)
            _finish(
                (cell, step, way, first[way], target[way], memories),
                length_steps, gain, bit, each_once,
                ready, ready_after, done, done_after, looks, target,
            )  # fmt: skip
            for memory in range(memories):
                state = cell * memories + memory
                if done_after[state] != state:
                    continue
                if done[state] > best[step, memory]:
                    best[step, memory], best_after[step, memory] = done[state], state
                _leave(
                    done[state], state, memory, memories, step - first[way], way, first, offset,
                    kept, edges, arrival, ready, ready_after,
                )  # fmt: skip
    greatest = np.argmax(best[end - 1])
    return best[end - 1, greatest], best_after[end - 1, greatest], looks


@compiled
def _follow(
    first_state: int, mask: int, worth: Array, after: Indices, kept: Array, kept_after: Indices
) -> None:
    """Values of one cell, by memory, that pass on to another where they are greater."""
    for memory in range(len(worth)):
        state = first_state + (memory & mask)
        if worth[memory] > kept[state]:
            kept[state], kept_after[state] = worth[memory], after[memory]


@compiled
def _leave(
    worth: float,
    state: int,
    memory: int,
    memories: int,
    steps: int,
    way: int,
    first: Indices,
    offset: Indices,
    kept: Indices,
    edges: tuple[Indices, Indices, Indices],
    arrival: NDArray[np.int32],
    ready: Array,
    ready_after: Indices,
) -> None:
    """For every other way that can be reached."""
    edge_from, edge_to, arrival_offset = edges
    for edge in range(edge_from[way], edge_from[way + 1]):
        reached = arrival[arrival_offset[edge] + steps]
        if reached == NEVER:
            continue
        to = edge_to[edge]
        there = (offset[to] + reached - first[to]) * memories + (memory & kept[to])
        if worth > ready[there]:
            ready[there], ready_after[there] = worth, state


@compiled
def _finish(
    place: tuple[int, int, int, int, int, int],
    length_steps: Indices,
    gain: Array,
    bit: Indices,
    each_once: bool,
    ready: Array,
    ready_after: Indices,
    done: Array,
    done_after: Indices,
    looks: Indices,
    target: Indices,
) -> None:
    """The best look that ends in this cell, if it beats having ended before."""
    cell, step, way, first, seen, memories = place
    mark = 0 if bit[seen] == NONE else 1 << bit[seen]
    for length in range(length_steps.shape[1]):
        steps = length_steps[seen, length]
        if step - steps < first or gain[seen, length] <= 0.0:
            continue
        for memory in range(memories):
            begun = (cell - steps) * memories + memory
            state = cell * memories + (memory | mark)
            worth = ready[begun] + gain[seen, length]
            if memory & mark or not worth > done[state] + 1e-12:
                continue
            if each_once and _is_seen(seen, ready_after[begun], looks, target):
                continue
            done[state], done_after[state] = worth, state
            looks[state, 0], looks[state, 1] = way, step - steps
            looks[state, 2], looks[state, 3] = length, ready_after[begun]


@compiled
def _is_seen(seen: int, event: int, looks: Indices, target: Indices) -> bool:
    while event != NONE:
        if target[looks[event, 0]] == seen:
            return True
        event = looks[event, 3]
    return False
