"""The most valuable path through candidates, by labels that wait or turn from one to another."""

from typing import NamedTuple

from planner.arrays import Array, Indices
from planner.compiled import compiled
from planner.label_search import EVERYTHING, Memory, best, follow, no_labels, visit, visit_at

WAIT_TICKS = 10  # of the chain of idle instants: 2 s, the grid of the candidates


class Imaging(NamedTuple):
    """Candidates by their start, (n,) each; priority: what each adds to a choice's value."""

    start_tick: Indices
    stop_tick: Indices
    request: Indices
    part: Indices
    priority: Array


class Turns(NamedTuple):
    """first (n + 1,): candidate j can directly follow before[first[j]] to before[first[j + 1]].

    reach_ticks (n,): so long after a candidate's stop any other can be begun.
    """

    first: Indices
    before: Indices
    reach_ticks: Indices


@compiled
def label_paths(imaging: Imaging, turns: Turns, memory: Memory) -> tuple[float, Indices, int]:
    """A `Round`.  Places: candidates, then idle instants; visits are numbered by candidate."""
    n = len(imaging.start_tick)
    end = int(imaging.stop_tick.max() + turns.reach_ticks.max()) + 2 * WAIT_TICKS
    labels = no_labels(n + end // WAIT_TICKS + 2, n, memory)
    now = 0
    for j in range(n):
        start_tick = imaging.start_tick[j]
        while (now + 1) * WAIT_TICKS <= start_tick:
            now += 1
            follow(labels, n + now - 1, n + now, memory.tick_mask[now * WAIT_TICKS])
        made = visit_at(
            memory, start_tick, j, imaging.request[j], imaging.part[j], imaging.priority[j]
        )
        visit(labels, (n + now,), j, made)
        visit(labels, turns.before[turns.first[j] : turns.first[j + 1]], j, made)
        free = (imaging.stop_tick[j] + turns.reach_ticks[j] + WAIT_TICKS - 1) // WAIT_TICKS
        follow(labels, j, n + free, EVERYTHING)
    value, visits, count = best(labels, (0, n))
    return max(value, 0.0), visits, count
