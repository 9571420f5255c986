"""Labels set forward in time: the most valuable visits, each item once, with a bound.

A caller's sweep goes through places in order of time, has labels follow from place to place and
visit items on the way.  Repeats are first allowed and then forbidden where they occur
(decremental state-space relaxation with local memory): every round's value bounds the optimum
from above, and the first path without repeats is optimal.
Source: Righini, Salani 2008, "New dynamic programming algorithms for the resource constrained
elementary shortest path problem", Networks 51(3); Baldacci, Mingozzi, Roberti 2011, Operations
Research 59(5) (ng-routes).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base import effort
from planner.base.arrays import Indices
from planner.base.compiled import compiled

NONE = -1
ALL_ITEMS = -1  # a mask of all bits
WHOLE, OPENS, COMPLETES = 0, 1, 2  # parts of a item that a visit makes
BITS = 62  # of a label's memory, in a signed word
LABELS_MAX = 4_000_000  # of a round; its value is no bound then


@dataclass(frozen=True, kw_only=True)
class LabelSearchOptions:
    """Bounds of a search over partial sequences, whose work doubles with a look."""

    search_labels_max: int = 8_000_000  # of all rounds: no more are begun
    label: float = 0.1  # of `effort`


OPTIONS = LabelSearchOptions()

ROUNDING = 1e-12  # by so much a path that looks back must be better to replace another
_LABEL = np.dtype(
    [
        ("value", "f8"),
        ("items", "i8"),  # bits of those visited
        ("partial_items", "i8"),  # bits of those of which one part was visited
        ("visit", "i8"),  # the caller's number of the last visit, if made here
        ("item", "i4"),  # visited then
        ("last", "i4"),  # label made by the last visit, NONE
        ("before", "i4"),  # label made by the visit before it, NONE
        ("next", "i4"),  # label at the same place, NONE
    ]
)
_SLOTS, _MADE, _MOST = 0, 1, 2  # of `Labels.use`


class LabelMemory(NamedTuple):
    """What labels remember of the items visited.

    bit: of each item, 0 for those forgotten at once; visit_mask: the bits that outlast a visit
    to it, (items,) each.  tick_mask: bits that mean something then, (ticks,).
    once: labels look back at the whole path instead, and only the best at a place is kept: no
    item is visited twice, but a better path may be missed.
    """

    bit: Indices
    visit_mask: Indices
    tick_mask: Indices
    once: bool


class Visit(NamedTuple):
    """What becomes of a label that makes it.

    number: the caller's.  part: WHOLE, or OPENS and COMPLETES a item, others between.
    tick: when it ends.
    """

    number: int
    item: int
    part: int
    value: float
    tick: int


class Labels(NamedTuple):
    """first: label at every place, NONE.  label: records of _LABEL.

    use: how many of them are in use, how many were made, and how many may be.
    """

    first: Indices
    label: NDArray[np.void]
    use: Indices


class Round(NamedTuple):
    """The best path as far as repeats are remembered.

    value: no path that visits each item once is worth more, unless labels ran out.
    visits: number and item of each, in order of time, (n, 2).
    """

    value: float
    visits: Indices
    labels: int

    @property
    def is_complete(self) -> bool:
        return self.labels < LABELS_MAX


Sweep = Callable[[LabelMemory], Round]


def forgetful(items: int, ticks: int, *, once: bool) -> LabelMemory:
    """No item is remembered."""
    none = np.zeros(items, np.int64)
    return LabelMemory(none, none, np.zeros(ticks, np.int64), once)


class Repeats:
    """Which items are remembered, and where.

    items: how many there are.  item, first_tick, last_tick: of each place where one can be
    visited, (n,).  Things that lie further apart than a label can leap share a bit.
    pairs: items visited in two parts, remembered everywhere.
    """

    def __init__(
        self,
        items: int,
        item: Indices,
        first_tick: Indices,
        last_tick: Indices,
        leap_ticks: int,
        pairs: Sequence[int],
    ) -> None:
        self._first, self._last = np.full(items, last_tick.max()), np.zeros(items, np.int64)
        np.minimum.at(self._first, item, first_tick)
        np.maximum.at(self._last, item, last_tick)
        self._leap_ticks = leap_ticks
        self._pairs = frozenset(pairs)
        self._number: dict[int, int] = {}
        self._visit_mask = np.zeros(items, np.int64)
        for pair in pairs:
            self._remember(pair, slice(None))

    def memory(self) -> LabelMemory:
        bit = np.zeros_like(self._visit_mask)
        tick_mask = np.zeros(int(self._last.max()) + 1, np.int64)
        for item, number in self._number.items():
            bit[item] = 1 << number
            tick_mask[self._first[item] : self._last[item] + 1] |= 1 << number
        return LabelMemory(bit, self._visit_mask.copy(), tick_mask, False)

    def forbid(self, items: Sequence[int]) -> bool:
        """The shortest way each is repeated in this order; False when none can be."""
        last: dict[int, int] = {}
        changed = False
        for place, item in enumerate(items):
            if item in self._pairs:
                continue
            if item in last:
                changed |= self._remember(item, list(items[last[item] : place + 1]))
            last[item] = place
        return changed

    def _remember(self, item: int, among: slice | list[int]) -> bool:
        """From now on past visits to items `among`; False when all bits are taken."""
        if item not in self._number:
            taken = {
                number
                for other, number in self._number.items()
                if self._first[other] <= self._last[item] + self._leap_ticks
                and self._first[item] <= self._last[other] + self._leap_ticks
            }
            free = next((number for number in range(BITS) if number not in taken), None)
            if free is None:
                return False
            self._number[item] = free
        self._visit_mask[among] |= 1 << self._number[item]
        return True


def rounds(
    sweep: Sweep, repeats: Repeats, labels_max: int = OPTIONS.search_labels_max
) -> Iterator[Round]:
    """Ever tighter; the last one is without repeats unless bits or labels ran out.

    labels_max: of all rounds; no more are begun.
    """
    labels = 0
    while True:
        found = sweep(repeats.memory())
        effort.count(OPTIONS.label * found.labels)
        labels += found.labels
        yield found
        if not found.is_complete or labels > labels_max:
            return
        if not repeats.forbid(found.visits[:, 1].tolist()):
            return


def bound(found: Iterable[Round]) -> float:
    """No path that visits each item once has a greater value."""
    return min((one.value for one in found if one.is_complete), default=np.inf)


@compiled
def no_labels(places: int, start: int, memory: LabelMemory) -> Labels:
    """None but at the place where every path begins."""
    # One at each is the best if none remember, and as many as make way for it are few.
    slots, most = places, max(LABELS_MAX, 100 * places)
    if memory.bit.any():
        slots, most = LABELS_MAX, LABELS_MAX
    first, label = np.full(places, NONE), np.empty(slots, _LABEL)
    labels = Labels(first, label, np.array([0, 0, most]))
    _keep(labels, start, 0.0, 0, 0, NONE)
    return labels


@compiled
def follow(labels: Labels, begin: int, places: Iterable[int], mask: int, visited: bool) -> None:
    """Labels at place `begin` come to others with nothing done on the way; NONE is no place.

    visited: only those that made a visit there.
    """
    first, label = labels.first, labels.label
    k = first[begin]
    while k != NONE:
        here = label[k]
        if here.last == k or not visited:
            value, items, partial_items = here.value, here.items & mask, here.partial_items & mask
            for to in places:
                if to != NONE and not _is_dominated(
                    label, first[to], value, items, partial_items, False
                ):
                    _keep(labels, to, value, items, partial_items, here.last)
        k = here.next


@compiled
def visit(labels: Labels, begins: Iterable[int], to: int, memory: LabelMemory, made: Visit) -> bool:
    """All labels at places `begins` that may come to another one by a visit; whether any did."""
    first, label, once = labels.first, labels.label, memory.once
    before_mask, after_mask = memory.tick_mask[made.tick], memory.visit_mask[made.item]
    bit = memory.bit[made.item]
    is_any = False
    for begin in begins:
        k = first[begin]
        while k != NONE:
            here = label[k]
            k = here.next
            value = here.value + made.value
            allowed, items, partial_items = _remember(
                made.part,
                bit,
                after_mask,
                here.items & before_mask,
                here.partial_items & before_mask,
            )
            if not allowed or _is_dominated(label, first[to], value, items, partial_items, once):
                continue
            if once and _is_behind(label, here.last, made.item):
                continue
            new = _keep(labels, to, value, items, partial_items, NONE)
            if new != NONE:
                label[new].visit, label[new].item = made.number, made.item
                label[new].last, label[new].before = new, here.last
                is_any = True
    return is_any


@compiled
def _remember(
    part: int, bit: int, after_mask: int, items: int, partial_items: int
) -> tuple[bool, int, int]:
    """A label's memory after a visit to the item of that bit: (allowed, items, partial_items)."""
    allowed = items & bit == 0
    if part == OPENS:
        return allowed and partial_items & bit == 0, items & after_mask, partial_items | bit
    if part == COMPLETES:
        allowed = allowed and (partial_items & bit != 0 or bit == 0)
        partial_items &= ~bit
    return allowed, (items | bit) & after_mask, partial_items


@compiled
def _is_dominated(
    label: NDArray[np.void], k: int, value: float, items: int, partial_items: int, once: bool
) -> bool:
    """Whether one of the labels at a place, from k on, is at least as good."""
    least = value - ROUNDING if once else value
    while k != NONE:
        other = label[k]
        if (
            other.value >= least
            and other.items & ~items == 0
            and partial_items & ~other.partial_items == 0
        ):
            return True
        k = other.next
    return False


@compiled
def best(labels: Labels, places: tuple[int, int]) -> tuple[float, Indices, int]:
    """The best label from one place to before another, as a `Round`."""
    label = labels.label
    value, last = -np.inf, NONE
    for place in range(places[0], places[1]):
        k = labels.first[place]
        while k != NONE:
            if label[k].value > value:
                value, last = label[k].value, label[k].last
            k = label[k].next
    count, k = 0, last
    while k != NONE:
        count, k = count + 1, label[k].before
    visits = np.empty((count, 2), np.int64)
    k = last
    for row in range(count - 1, -1, -1):
        visits[row, 0], visits[row, 1], k = label[k].visit, label[k].item, label[k].before
    return value, visits, labels.use[_MADE]


@compiled
def _is_behind(label: NDArray[np.void], last: int, item: int) -> bool:
    """Whether a item was visited by the last visit or one before it."""
    while last != NONE:
        if label[last].item == item:
            return True
        last = label[last].before
    return False


@compiled
def _keep(
    labels: Labels, place: int, value: float, items: int, partial_items: int, last: int
) -> int:
    """The new label at a place, where those no better give way; NONE when labels ran out."""
    label = labels.label
    new, before, k = NONE, NONE, labels.first[place]
    while k != NONE:
        other = label[k]
        following = other.next
        if (
            value >= other.value
            and items & ~other.items == 0
            and other.partial_items & ~partial_items == 0
        ):
            if before == NONE:
                labels.first[place] = following
            else:
                label[before].next = following
            new = k  # nothing follows from it yet
        else:
            before = k
        k = following
    if labels.use[_MADE] == labels.use[_MOST]:
        return NONE
    labels.use[_MADE] += 1
    if new == NONE:
        new = labels.use[_SLOTS]
        labels.use[_SLOTS] += 1
    made = label[new]
    made.value, made.items, made.partial_items, made.last = value, items, partial_items, last
    made.next = labels.first[place]
    labels.first[place] = new
    return int(new)
