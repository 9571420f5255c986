"""How are all worthwhile paths through candidates found?  Labels forward in time, compiled."""

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array
from planner.compiled import compiled

Ints = NDArray[np.int64]
WAIT_TICKS = 10  # of the chain of idle instants: 2 s, the grid of the candidates


@compiled
def _insert(
    head: Ints,
    following: Ints,
    value: Array,
    visited: Ints,
    opened: Ints,
    node: Ints,
    parent: Ints,
    place: int,
    count: int,
    v: float,
    seen: int,
    half: int,
    comes_from: int,
    is_node: int,
) -> int:
    """Add a label to a place unless another there is at least as good; returns the new count."""
    k = head[place]
    previous = -1
    while k >= 0:
        if value[k] >= v and (visited[k] & ~seen) == 0 and (half & ~opened[k]) == 0:
            return count
        if v >= value[k] and (seen & ~visited[k]) == 0 and (opened[k] & ~half) == 0:
            if previous < 0:
                head[place] = following[k]
            else:
                following[previous] = following[k]
        else:
            previous = k
        k = following[k]
    if count >= len(value):
        return count
    value[count], visited[count], opened[count] = v, seen, half
    node[count], parent[count] = is_node, comes_from
    following[count] = head[place]
    head[place] = count
    return count + 1


@compiled
def _dead(bit: Ints, born: Ints, alive: Ints, tick: int) -> int:
    """All bits but those of requests that may have come by this tick and may come again."""
    mask = 0
    for r in range(len(alive)):
        if bit[r] >= 0 and born[r] <= tick and alive[r] >= tick:
            mask |= 1 << bit[r]
    return ~mask


@compiled
def _imaged(part: int, own: int, seen: int, half: int) -> tuple[bool, int, int]:
    """A label's memory after a candidate: (allowed, visited, opened)."""
    if part == 1:
        return (seen & own) == 0 and (half & own) == 0, seen, half | own
    if part == 2:
        return (seen & own) == 0 and (half & own) != 0, seen | own, half & ~own
    return (seen & own) == 0, seen | own, half


@compiled
def label_paths(
    start: Ints,
    stop: Ints,
    request: Ints,
    part: Ints,
    earn: Array,
    first: Ints,
    before: Ints,
    reach: Ints,
    bit: Ints,
    kept: Ints,
    born: Ints,
    alive: Ints,
    labels_max: int,
) -> tuple[Array, Ints, Ints, int, int]:
    """Labels forward in time over candidates (places 0..n-1) and idle instants (n..n+m).

    A label carries which remembered requests it has imaged (while they can still come again)
    and which stereo pairs it has begun.
    """
    n = len(start)
    end = int(stop.max() + reach.max()) + 2 * WAIT_TICKS
    head = np.full(n + end // WAIT_TICKS + 2, -1, dtype=np.int64)
    value = np.empty(labels_max)
    visited = np.empty(labels_max, dtype=np.int64)
    opened = np.empty(labels_max, dtype=np.int64)
    node = np.empty(labels_max, dtype=np.int64)
    parent = np.empty(labels_max, dtype=np.int64)
    following = np.empty(labels_max, dtype=np.int64)
    count = _insert(
        head, following, value, visited, opened, node, parent, n, 0, 0.0, 0, 0, -1, -1
    )  # fmt: skip
    now = 0
    best = -1
    for j in range(n):
        while (now + 1) * WAIT_TICKS <= start[j]:
            dead = _dead(bit, born, alive, (now + 1) * WAIT_TICKS)
            k = head[n + now]
            while k >= 0:
                count = _insert(
                    head, following, value, visited, opened, node, parent, n + now + 1, count,
                    value[k], visited[k] & ~dead, opened[k] & ~dead, k, -1,
                )  # fmt: skip
                k = following[k]
            now += 1
        dead = _dead(bit, born, alive, start[j])
        own = 1 << bit[request[j]] if bit[request[j]] >= 0 else 0
        for source in range(first[j + 1] - first[j] + 1):
            k = head[n + now] if source == 0 else head[before[first[j] + source - 1]]
            while k >= 0:
                allowed, seen, half = _imaged(part[j], own, visited[k] & ~dead, opened[k] & ~dead)
                if allowed:
                    count = _insert(
                        head, following, value, visited, opened, node, parent, j, count,
                        value[k] + earn[j], seen & kept[request[j]], half, k, j,
                    )  # fmt: skip
                k = following[k]
        free = (stop[j] + reach[j] + WAIT_TICKS - 1) // WAIT_TICKS
        k = head[j]
        while k >= 0:
            if best < 0 or value[k] > value[best]:
                best = k
            count = _insert(
                head, following, value, visited, opened, node, parent, n + free, count,
                value[k], visited[k], opened[k], k, -1,
            )  # fmt: skip
            k = following[k]
    return value[:count], parent[:count], node[:count], best, count
