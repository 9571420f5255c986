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
from planner.base.compiled import compiled, inlined, lean

NONE = -1
BITS = 62  # of a word of a label's memory, which is signed
LABELS_MAX = 4_000_000  # of a round, a minute; its value is no bound then


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
        ("visit", "i8"),  # the caller's number of the last visit, if made here
        ("item", "i4"),  # visited then
        ("last", "i4"),  # label made by the last visit, NONE
        ("before", "i4"),  # label made by the visit before it, NONE
        ("next", "i4"),  # label at the same place, NONE
    ]
)
_SLOTS, _MADE, _MOST = 0, 1, 2  # of `Labels.use`


class LabelMemory(NamedTuple):
    """What labels remember of the items visited, by bits of w words.

    word, bit: of each item, 0 for those forgotten at once, (items,); visit_mask: the bits that
    outlast a visit to it, (items, w).  tick_mask: bits that mean something then, (ticks, w).
    every, none: of the bits, (w,).  most: labels that a round may make where any are remembered.
    """

    word: Indices
    bit: Indices
    visit_mask: Indices
    tick_mask: Indices
    every: Indices
    none: Indices
    most: int


class Visit(NamedTuple):
    """What becomes of a label that makes it.

    number: the caller's.  tick: when it ends.
    """

    number: int
    item: int
    value: float
    tick: int


class Labels(NamedTuple):
    """first: label at every place, NONE.  label: records of _LABEL.

    bits: of items visited, (labels + 1, w), the last of a label that is being made.
    use: how many of them are in use, how many were made, and how many may be.
    """

    first: Indices
    label: NDArray[np.void]
    bits: Indices
    use: Indices


class Round(NamedTuple):
    """The best path as far as repeats are remembered.

    value: no path that visits each item once is worth more, where labels didn't run out.
    visits: number and item of each, in order of time, (n, 2).
    """

    value: float
    visits: Indices
    labels: int
    is_complete: bool


Sweep = Callable[[LabelMemory], Round]


def _memory(number: Indices, visit_mask: Indices, ticks: int, most: int) -> LabelMemory:
    """number: of each item's bit, NONE; no bit means anything at any tick yet."""
    words = visit_mask.shape[1]
    return LabelMemory(
        word=np.maximum(number, 0) // BITS,
        bit=np.where(number == NONE, 0, 1 << (np.maximum(number, 0) % BITS)),
        visit_mask=visit_mask,
        tick_mask=np.zeros((ticks, words), np.int64),
        every=np.full(words, -1),
        none=np.zeros(words, np.int64),
        most=most,
    )


class Repeats:
    """Which items are remembered, and where.

    items: how many there are.  item, first_tick, last_tick: of each place where one can be
    visited, (n,).  Things that lie further apart than a label can leap share a bit.
    everywhere: items that are remembered from the first on, and everywhere.
    """

    def __init__(
        self,
        items: int,
        item: Indices,
        first_tick: Indices,
        last_tick: Indices,
        leap_ticks: int,
        everywhere: Sequence[int],
    ) -> None:
        self._first, self._last = np.full(items, last_tick.max()), np.zeros(items, np.int64)
        np.minimum.at(self._first, item, first_tick)
        np.maximum.at(self._last, item, last_tick)
        self._leap_ticks = leap_ticks
        self._everywhere = frozenset(everywhere)
        self._number: dict[int, int] = {}
        self._visit_mask = np.zeros((items, 1), np.int64)
        for one in everywhere:
            self._remember(one, slice(None))

    def memory(self, most: int) -> LabelMemory:
        numbers = np.full(len(self._visit_mask), NONE)
        numbers[list(self._number)] = list(self._number.values())
        memory = _memory(numbers, self._visit_mask.copy(), int(self._last.max()) + 1, most)
        for item in self._number:
            seen = slice(self._first[item], self._last[item] + 1)
            memory.tick_mask[seen, memory.word[item]] |= memory.bit[item]
        return memory

    def forbid(self, items: Sequence[int]) -> bool:
        """The shortest way each is repeated in this order; False when none can be."""
        last: dict[int, int] = {}
        changed = False
        for place, item in enumerate(items):
            if item in self._everywhere:
                continue
            if item in last:
                self._remember(item, list(items[last[item] : place + 1]))
                changed = True
            last[item] = place
        return changed

    def _remember(self, item: int, among: slice | list[int]) -> None:
        """From now on past visits to items `among`."""
        if item not in self._number:
            taken = {
                number
                for other, number in self._number.items()
                if self._first[other] <= self._last[item] + self._leap_ticks
                and self._first[item] <= self._last[other] + self._leap_ticks
            }
            self._number[item] = min(set(range(len(taken) + 1)) - taken)
        word, bit = divmod(self._number[item], BITS)
        lacking = word + 1 - self._visit_mask.shape[1]
        self._visit_mask = np.pad(self._visit_mask, ((0, 0), (0, max(lacking, 0))))
        self._visit_mask[among, word] |= 1 << bit


def rounds(
    sweep: Sweep,
    repeats: Repeats,
    labels_max: int = OPTIONS.search_labels_max,
    round_max: int = LABELS_MAX,
) -> Iterator[Round]:
    """Ever tighter; the last one is without repeats unless labels ran out.

    labels_max: of all rounds; no more are begun.  round_max: of one.
    """
    labels = 0
    while True:
        found = sweep(repeats.memory(round_max))
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


@inlined
def _is_as_free(bits: Indices, one: int, other: int) -> bool:
    """Whether one label may make all visits that another one may."""
    barred = 0
    for word in range(bits.shape[1]):
        barred |= bits[one, word] & ~bits[other, word]
    return barred == 0


@inlined
def _remember(labels: Labels, k: int, memory: LabelMemory, made: Visit) -> bool:
    """Whether a label may make a visit; the new one's bits are those after it."""
    before, after = memory.tick_mask[made.tick], memory.visit_mask[made.item]
    own, bit = memory.word[made.item], memory.bit[made.item]
    bits, new = labels.bits, len(labels.bits) - 1
    if bits[k, own] & before[own] & bit != 0:
        return False
    for word in range(len(after)):
        bits[new, word] = bits[k, word] & before[word] & after[word]
    bits[new, own] |= bit & after[own]
    return True


@inlined
def _is_dominated(labels: Labels, k: int, value: float) -> bool:
    """Whether one of the labels at a place, from k on, is at least as good as the new one."""
    new = len(labels.bits) - 1
    while k != NONE:
        if labels.label[k].value >= value and _is_as_free(labels.bits, k, new):
            return True
        k = labels.label[k].next
    return False


@inlined
def _keep(labels: Labels, place: int, value: float, last: int) -> int:
    """The new label at a place, where those no better give way; NONE when labels ran out."""
    label, bits, made_at = labels.label, labels.bits, len(labels.bits) - 1
    new, before, k = NONE, NONE, labels.first[place]
    while k != NONE:
        following = label[k].next
        if value >= label[k].value and _is_as_free(bits, made_at, k):
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
    made.value, made.last = value, last
    for word in range(bits.shape[1]):
        bits[new, word] = bits[made_at, word]
    made.next = labels.first[place]
    labels.first[place] = new
    return int(new)


@compiled
def no_labels(places: int, start: int, memory: LabelMemory) -> Labels:
    """None but at the place where every path begins."""
    # One at each is the best if none remember, and as many as make way for it are few.
    slots, most = places, max(LABELS_MAX, 100 * places)
    if memory.bit.any():
        slots, most = memory.most, memory.most
    words = len(memory.none)
    labels = Labels(
        first=np.full(places, NONE),
        label=np.empty(slots, _LABEL),
        bits=np.empty((slots + 1, words), np.int64),
        use=np.array([0, 0, most]),
    )
    labels.bits[slots] = 0
    _keep(labels, start, 0.0, NONE)
    return labels


@lean
def follow(labels: Labels, begin: int, places: Iterable[int], mask: Indices, visited: bool) -> None:
    """Labels at place `begin` come to others with nothing done on the way; NONE is no place.

    mask: bits that are kept, (w,).  visited: only those that made a visit there.
    """
    first, label, bits = labels.first, labels.label, labels.bits
    k, new = first[begin], len(bits) - 1
    while k != NONE:
        here = label[k]
        if here.last == k or not visited:
            for word in range(len(mask)):
                bits[new, word] = bits[k, word] & mask[word]
            for to in places:
                if to != NONE and not _is_dominated(labels, first[to], here.value):
                    _keep(labels, to, here.value, here.last)
        k = here.next


@lean
def visit(labels: Labels, begins: Iterable[int], to: int, memory: LabelMemory, made: Visit) -> bool:
    """All labels at places `begins` that may come to another one by a visit; whether any did."""
    first, label = labels.first, labels.label
    is_any = False
    for begin in begins:
        k = first[begin]
        while k != NONE:
            here = label[k]
            value = here.value + made.value
            allowed = _remember(labels, k, memory, made)
            k = here.next
            if not allowed or _is_dominated(labels, first[to], value):
                continue
            new = _keep(labels, to, value, NONE)
            if new != NONE:
                label[new].visit, label[new].item = made.number, made.item
                label[new].last, label[new].before = new, here.last
                is_any = True
    return is_any


@compiled
def best(labels: Labels, places: tuple[int, int]) -> tuple[float, Indices, int, bool]:
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
    return value, visits, labels.use[_MADE], labels.use[_MADE] < labels.use[_MOST]
