"""Orders of looks at one thing after another, by the earliest end of every set of them.

Who ends a look earlier can do all that who ends it later can, because a look may begin later.  So
of all orders of the same looks that end with the same one, the soonest is enough.  Where all sets
are kept, the most that any of them is worth is the most there is; where the least promising are
given up, it is the best found.
Source: Dumas et al. 1995, "An optimal algorithm for the traveling salesman problem with time
windows", Operations Research 43(2).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.label_search import NONE


@dataclass(frozen=True, kw_only=True, eq=False)
class LookGraph:
    """Ways (w,) to look at items, each of which ends at places, (n,), in order of time.

    way: of each place.  end: when, in any unit, (n,).  first: place at which a look by each way
    ends at the earliest, (w,), NONE.  follow: the same after a look that ended at each place, or
    at a later one by the same way, (n, w).  last: the last place at which a look by each way may be
    the last of all, (w,), NONE.
    seen: the bit that looks by a way set, of words of `label_search.BITS`, and that may not be set
    before; 0 of no use, (w, words).  gain: what they are worth, (w,).
    """

    way: Indices
    end: Indices
    first: Indices
    last: Indices
    follow: Indices
    seen: Indices
    gain: Array


class Orders(NamedTuple):
    """Orders of as many looks, (n,): the bits set, (n, words), the place at which the last look
    ends, the row of the order without it among those of one look less, and what they are worth."""

    seen: Indices
    place: Indices
    before: Indices
    value: Array


def orders_by_count(graph: LookGraph, width: int) -> Iterator[Orders]:
    """Of one look, of two, and so on; of more than `width` the most promising."""
    pace = float(graph.gain.sum()) / max(float(np.ptp(graph.end)), 1.0)
    ways = np.flatnonzero((graph.first != NONE) & graph.seen.any(axis=1))
    found = Orders(graph.seen[ways], graph.first[ways], np.zeros_like(ways), graph.gain[ways])
    while len(found.place):
        if len(found.place) > width:
            promise = found.value - pace * graph.end[found.place]
            best = np.argpartition(-promise, width)[:width]
            seen, place, before, value = found
            found = Orders(seen[best], place[best], before[best], value[best])
        yield found
        found = _one_more(graph, found)


def _one_more(graph: LookGraph, found: Orders) -> Orders:
    """Every order with each look that may follow; of the same looks the soonest by its last way."""
    fits = (graph.follow[found.place] != NONE) & graph.seen.any(axis=1)
    for seen, bit in zip(found.seen.T, graph.seen.T, strict=True):
        fits &= seen[:, None] & bit == 0
    before, way = np.nonzero(fits)
    place = graph.follow[found.place[before], way].astype(np.intp)
    all_seen = found.seen[before] | graph.seen[way]
    order = np.lexsort((place, way, *all_seen.T))
    is_first = np.ones(len(order), np.bool_)
    is_first[1:] = (np.diff(all_seen[order], axis=0) != 0).any(axis=1)
    is_first[1:] |= np.diff(way[order]) != 0
    kept = order[is_first]
    value = found.value[before] + graph.gain[way]
    return Orders(all_seen[kept], place[kept], before[kept], value[kept])


def places_of(found: list[Orders], row: int) -> list[int]:
    """The places of the looks of an order among the last of those found, in order of time."""
    places = []
    for orders in reversed(found):
        places.append(int(orders.place[row]))
        row = int(orders.before[row])
    return places[::-1]
